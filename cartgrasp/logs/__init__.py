"""Logs: read by the file's suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..errors import LogError, Place, UsageError
from .coasting import coasts, said_to_coast
from .csv_log import read_csv, write_csv
from .emps import read_emps
from .parquet_log import read_parquet, write_parquet
from .run_log import ArmLog, RunLog

STORAGES = (".mcap", ".db3")
BAGS = (*STORAGES, ".bag")
READERS: dict[str, Callable[[Path], RunLog]] = {".csv": read_csv, ".parquet": read_parquet, ".mat": read_emps}


def _write_mcap(log: RunLog, path: Path) -> Path:
    from .bags import write_mcap

    return write_mcap(log, path)


WRITERS: dict[str, Callable[[RunLog, Path], Path]] = {
    ".csv": write_csv,
    ".parquet": write_parquet,
    ".mcap": _write_mcap,
}


def read_log(path: str | Path, topics: str | Path | None = None) -> RunLog:
    """The log of a file: .csv, .parquet, the EMPS data set's .mat, or a ROS bag through its topic map."""
    path = Path(path)
    if is_bag_name(path):
        from .bags import read_bag

        return read_bag(path, topics).log
    if topics is not None:
        raise UsageError(f"{path}: is no bag, so a topic map is of no use")
    reader = READERS.get(path.suffix.lower())
    if path.is_dir():
        raise LogError(Place(str(path)), "", "is a folder; name the log in it")
    if reader is None:
        known = ", ".join([*READERS, *BAGS])
        raise LogError(Place(str(path)), "", f"unknown kind of log {path.suffix!r}; known are {known}")
    if not path.is_file():
        raise LogError(Place(str(path)), "", "there is no such file")
    return reader(path)


def is_bag_name(path: Path) -> bool:
    """Whether it is read through a topic map: a bag, or a folder with a recorder's files in it."""
    try:
        if path.is_dir():
            return (path / "metadata.yaml").is_file() or any(p.suffix.lower() in STORAGES for p in path.iterdir())
    except OSError as error:
        raise LogError(Place(str(path)), "", f"can't be read: {error.strerror or error}") from error
    return path.suffix.lower() in BAGS


def write_log(log: RunLog, path: str | Path) -> Path:
    """Writes a log aside, then renames it."""
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LogError(Place(str(path)), "", f"can't write {path.suffix!r}; known are {', '.join(WRITERS)}")
    return writer(log, path)


__all__ = ["ArmLog", "RunLog", "coasts", "is_bag_name", "read_log", "said_to_coast", "write_log"]
