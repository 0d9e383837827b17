"""What a campaign is made of: jobs that share nothing, each with a result of its own."""

from __future__ import annotations

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ... import __version__
from ...errors import CartgraspError, UsageError
from ...strict_json import finite

PACKAGES = ("cartgrasp", "estimation", "planning")
FAILURES = (CartgraspError, ArithmeticError, ValueError, np.linalg.LinAlgError)
"""Findings of a run; anything else is the machine's, and kept by nobody."""


class Job(ABC):
    """Frozen, so that it can be handed to another process; it is what it says of itself."""

    @property
    @abstractmethod
    def config(self) -> dict[str, Any]:
        """All that the result follows from, but seed and version, as JSON has it."""

    @property
    @abstractmethod
    def seed(self) -> list[int]:
        """The seed of all that is drawn; empty where nothing is."""

    @abstractmethod
    def run(self) -> dict[str, Any]:
        """The result, as JSON has it: the same whenever and wherever it is worked out."""

    @property
    def key(self) -> str:
        """Hash of config, seed and version."""
        told = {"config": self.config, "seed": self.seed, "version": code_version()}
        return hashlib.sha256(json.dumps(finite(told), sort_keys=True).encode()).hexdigest()[:32]


class Study(Protocol):
    """A named set of jobs."""

    @property
    def name(self) -> str: ...

    def jobs(self) -> Sequence[Job]: ...


@dataclass(frozen=True)
class JobResult:
    """A job's key, and the text that is kept of it."""

    key: str
    text: str


def work(job: Job, version: str) -> JobResult:
    """Does a job, in whichever process this is, which must have the code that asked for it."""
    if version != code_version():
        raise UsageError(f"this worker has cartgrasp {code_version()}, the campaign {version}; install the same code")
    try:
        with np.errstate(all="ignore"):
            result = job.run()
    except FAILURES as error:
        result = {"failure": str(error) or type(error).__name__}
    told = finite({"seed": job.seed, "version": version, **result})
    return JobResult(job.key, json.dumps(told, ensure_ascii=False, allow_nan=False) + "\n")


@cache
def code_version() -> str:
    """The package's version, with a digest of its sources: results of other code are other results."""
    root, whole = Path(__file__).parents[3], hashlib.sha256()
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            whole.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return f"{__version__}+{whole.hexdigest()[:12]}"
