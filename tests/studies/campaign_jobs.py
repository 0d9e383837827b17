"""Jobs that other processes can import."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from cartgrasp.errors import UsageError
from cartgrasp.studies.campaigns.job import Job


@dataclass(frozen=True)
class Squares:
    """A study of `count` numbers; the one called `deadly` kills its process the first time."""

    count: int
    folder: str = ""
    deadly: int = -1
    seconds: float = 0.0
    name: str = "squares"

    def jobs(self):
        return [Square(i, self.seconds, self.folder if i == self.deadly else "") for i in range(self.count)]


@dataclass(frozen=True)
class Square(Job):
    number: int
    seconds: float = 0.0
    folder: str = ""

    @property
    def config(self):
        return {"number": self.number}

    @property
    def seed(self):
        return [self.number]

    def run(self):
        if self.folder and not (mark := Path(self.folder) / "killed").exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.seconds)
        if self.number == 3:
            raise UsageError("three can't be squared")
        return {"square": self.number**2, "root": float("nan") if self.number == 0 else self.number**0.5}
