"""A study run to its end: what is there is left alone, so a campaign that was killed goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import FileError, Place
from ...writing import write_atomically
from .job import JobResult, Study
from .workers import Workers


@dataclass(frozen=True)
class Results:
    """`FOLDER/KEY.json` of each job, written aside and renamed, so that what is there is whole."""

    folder: Path

    @classmethod
    def under(cls, out: Path) -> Results:
        folder = out / "results"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(Place(str(folder)), "", f"can't be made: {error.strerror}; name another folder") from error
        return cls(folder)

    def has(self, key: str) -> bool:
        return self._path(key).is_file()

    def keep(self, done: JobResult) -> Path:
        return write_atomically(self._path(done.key), done.text)

    def read(self, key: str) -> dict[str, Any]:
        path = self._path(key)
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise FileError(Place(str(path)), "", f"is no result ({error}); remove it and run again") from error
        return dict(found)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.json"


def run_campaign(
    study: Study, results: Results, workers: Workers, progress: Callable[[float], None] | None = None
) -> list[dict[str, Any]]:
    """All results, in the jobs' order; `progress` is told the share done."""
    jobs = study.jobs()
    keys = [job.key for job in jobs]
    left = [job for job, key in zip(jobs, keys, strict=True) if not results.has(key)]
    for count, done in enumerate(workers(left) if left else (), 1):
        results.keep(done)
        if progress is not None:
            progress((len(jobs) - len(left) + count) / len(jobs))
    return [results.read(key) for key in keys]
