"""Logs: read by the file's suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..errors import LogError, Place
from .csv_log import read_csv, write_csv
from .emps import read_emps
from .parquet_log import read_parquet, write_parquet
from .run_log import ArmLog, RunLog

READERS: dict[str, Callable[[Path], RunLog]] = {".csv": read_csv, ".parquet": read_parquet, ".mat": read_emps}
WRITERS: dict[str, Callable[[RunLog, Path], Path]] = {".csv": write_csv, ".parquet": write_parquet}


def read_log(path: str | Path) -> RunLog:
    """The log of a file: .csv, .parquet, or the EMPS data set's .mat."""
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise LogError(Place(str(path)), "", f"unknown kind of log {path.suffix!r}; known are {', '.join(READERS)}")
    if path.is_dir():
        raise LogError(Place(str(path)), "", "is a folder; name the log in it")
    if not path.is_file():
        raise LogError(Place(str(path)), "", "there is no such file")
    return reader(path)


def write_log(log: RunLog, path: str | Path) -> Path:
    """Writes a log aside, then renames it."""
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LogError(Place(str(path)), "", f"can't write {path.suffix!r}; known are {', '.join(WRITERS)}")
    return writer(log, path)


__all__ = ["ArmLog", "RunLog", "read_log", "write_log"]
