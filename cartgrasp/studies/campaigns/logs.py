"""Batches of logs: each estimated, identified or diagnosed by itself, as the commands do."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from estimation.whole_log.coasting import with_known_wrench
from estimation.whole_log.replay import estimated

from ...errors import DataError
from ...logs import is_bag_name, read_log
from ...model import CartModel
from .job import Job

ESTIMATE, IDENTIFY = "estimate", "identify"


@dataclass(frozen=True)
class LogStudy:
    """`do` one of the three with each of the logs; `told` is what the file says of it."""

    name: str
    paths: tuple[Path, ...]
    cart: CartModel
    do: str
    method: str
    topics: Path | None
    told: dict[str, Any] = field(repr=False)

    def jobs(self) -> list[LogJob]:
        return [LogJob(self, path, digest(path)) for path in self.paths]


@dataclass(frozen=True)
class LogJob(Job):
    """One log, with the digest of what it holds."""

    study: LogStudy
    path: Path
    digest: str

    @property
    def config(self) -> dict[str, Any]:
        topics = None if self.study.topics is None else digest(self.study.topics)
        return {**self.study.told, "log": self.digest, "name": self.path.name, "topics": topics}

    @property
    def seed(self) -> list[int]:
        return []

    def run(self) -> dict[str, Any]:
        log, cart = read_log(self.path, self.study.topics), self.study.cart
        if self.study.do == ESTIMATE:
            known, method = with_known_wrench(log.thinned()), self.study.method
            told = estimated(known, cart, method, until=float(log.time[-1])).as_dict()
        elif self.study.do == IDENTIFY:
            from estimation.whole_log.identification import identify  # closed loops need none of it

            told = identify([log], cart).as_dict()
        else:
            from estimation.discrepancy import diagnose

            told = diagnose([log], cart).report.as_dict()
        return {"log": self.path.name, **told}


def digest(path: Path) -> str:
    """The digest of a file, or of all files in a recorder's folder. It leaves out what can't be read, which its job
    will tell."""
    whole = hashlib.sha256()
    for one in _files(path):
        try:
            whole.update(one.name.encode() + b"\0" + one.read_bytes())
        except OSError:
            continue
    return whole.hexdigest()


def _files(path: Path) -> list[Path]:
    """The files that are the log. A folder that is none is not walked through, which might not end."""
    if not os.path.isdir(path):
        return [path]
    try:
        return sorted(p for p in path.rglob("*") if os.path.isfile(p)) if is_bag_name(path) else []
    except DataError:
        return []
