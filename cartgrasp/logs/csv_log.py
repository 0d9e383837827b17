"""Run logs as CSV: strict, with file, line and column of what can't be accepted; nothing is guessed."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np

from ..errors import DataError, LogError, Place
from ..frames import Array
from ..writing import write_atomically
from ..yaml_file import did_you_mean
from .run_log import CONTACT_COLUMNS, POSE_COLUMNS, VELOCITY_COLUMNS, WRENCH_COLUMNS, ArmLog, RunLog

ARM_COLUMNS = CONTACT_COLUMNS + WRENCH_COLUMNS
MISSING_CELLS = ("", "nan", "NaN", "NAN")
TIME_AND_MOTION_COLUMNS = ("t", *POSE_COLUMNS, *VELOCITY_COLUMNS)
PAGE = "docs/tables.md"
"""Which explains how a table of other columns is read."""
MAX_COLUMNS_SHOWN = 12
MAX_CELL_CHARS = 40
"""Characters of a cell that are repeated in an error."""


def read_csv(path: str | Path) -> RunLog:
    """The log of a CSV file with the header of the run-log contract."""
    name = str(path)
    with opened_text(path) as stream:
        reader = csv.reader(stream, strict=True)
        try:
            rows = [(reader.line_num, row) for row in reader]
        except csv.Error as error:
            raise LogError(Place(name, reader.line_num), "", f"is not CSV: {error}") from error
    first = next((i for i, (_, row) in enumerate(rows) if any(cell.strip() for cell in row)), None)
    if first is None:
        raise LogError(Place(name, 1), "", "the file is empty; a header line is needed")
    if first:
        why = f"is blank; the header, now in line {rows[first][0]}, must stand here: take out what is above it"
        raise LogError(Place(name, 1), "", why)
    header = [column.strip() for column in rows[0][1]]
    check_columns(header, name)
    lines = [(line, row) for line, row in rows[1:] if row]
    return log_from_table(header, _numbers(header, lines, name), name, [line for line, _ in lines])


@contextmanager
def opened_text(path: str | Path) -> Iterator[TextIO]:
    """A file as text with its own line breaks; LogError where it can't be read, or is no UTF-8."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as stream:
            yield stream
    except OSError as error:
        is_missing = isinstance(error, FileNotFoundError)
        why = "there is no such file" if is_missing else f"can't be read: {error.strerror or error}"
        raise LogError(Place(str(path)), "", why) from error
    except UnicodeDecodeError as error:
        why = f"is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        raise LogError(Place(str(path)), "", why) from error


def write_csv(log: RunLog, path: str | Path) -> Path:
    """Writes the log; floats are written so that they read back the same."""
    for arm in log.arms:
        if arm != arm.strip():
            raise DataError(f"{log.name}: the arm {arm!r} begins or ends with a blank, which a CSV loses; rename it")
    header = ",".join(_quoted(column) for column in log.columns)
    rows = (",".join("" if math.isnan(v) else repr(v) for v in row) for row in log.table.tolist())
    return write_atomically(path, "\n".join([header, *rows]) + "\n")


def _quoted(column: str) -> str:
    return column if re.fullmatch(r"[\w. -]+", column) else '"' + column.replace('"', '""') + '"'


def check_columns(header: Sequence[str], name: str) -> None:
    """Every column is known, none is missing, none stands twice. All that is missing is told at once."""
    for column in header:
        if list(header).count(column) > 1:
            raise LogError(Place(name, 1), column, "stands twice in the header")
    missing = [column for column in ("t", *POSE_COLUMNS) if column not in header]
    has_velocity = [column in header for column in VELOCITY_COLUMNS]
    of_velocity = [c for c, has in zip(VELOCITY_COLUMNS, has_velocity, strict=True) if any(has_velocity) and not has]
    arms = arm_names(header)
    of_arms = [f"{arm}.{part}" for arm in arms for part in ARM_COLUMNS if f"{arm}.{part}" not in header]
    if lost := [*missing, *of_velocity, *of_arms]:
        beside = f"; so are {_some(lost[1:])}" if len(lost) > 1 else ""
        why = "; vx, vy and omega come together or not at all" if of_velocity else ""
        cure = f"; columns of one's own are read through a map: `cartgrasp topics {name}` proposes it ({PAGE})"
        instead = _instead(header) if missing else ""
        raise LogError(Place(name, 1), lost[0], f"this column is missing{beside}{why}{instead}{cure}")
    known = {"t", *POSE_COLUMNS, *VELOCITY_COLUMNS, *(f"{arm}.{part}" for arm in arms for part in ARM_COLUMNS)}
    for column in header:
        if column not in known:
            raise LogError(Place(name, 1), column or "(empty)", f"unknown column{did_you_mean(column, sorted(known))}")


def _some(columns: Sequence[str]) -> str:
    rest = len(columns) - MAX_COLUMNS_SHOWN
    return ", ".join(columns[:MAX_COLUMNS_SHOWN]) + (f" and {rest} more" if rest > 0 else "")


def _instead(header: Sequence[str]) -> str:
    """What the first line seems to be where it lacks a column that every log has."""
    line = ",".join(header)
    if "\0" in line:
        return ": this is no plain text; save it as UTF-8"
    if line.startswith("#"):
        return ": the first line is a comment; begin with the header t,x,y,theta,…"
    for sign in ";\t":
        if line.count(sign) > line.count(","):
            return f": cells are parted by {sign!r}; part them by commas, and write numbers with a point"
    others = [column for column in header if column and "." not in column and column not in TIME_AND_MOTION_COLUMNS]
    return f"; not known are {_short(', '.join(others))}" if others else ""


def arm_names(header: Sequence[str]) -> list[str]:
    """Arms of the columns ARM.part, in order of appearance."""
    parts = (column.rsplit(".", 1) for column in header if "." in column)
    return list(dict.fromkeys(p[0] for p in parts if p[0] and "." not in p[0] and p[1] in ARM_COLUMNS))


def log_from_table(header: Sequence[str], table: Array, name: str, lines: Sequence[int] | None = None) -> RunLog:
    """The log of a table (n, columns); `lines` are the lines of the file its rows are from."""
    at = list(header).index
    lines = range(2, len(table) + 2) if lines is None else lines
    if not len(table):
        raise LogError(Place(name, 2), "", "the log has no rows")
    time = table[:, at("t")]
    if fault := clock_fault(time, "t"):
        raise LogError(Place(name, lines[fault[0]]), "t", fault[1])

    def columns(names: Sequence[str], arm: str = "") -> Array:
        return np.ascontiguousarray(table[:, [at(arm + name) for name in names]])

    return RunLog(
        time=np.ascontiguousarray(time),
        pose=columns(POSE_COLUMNS),
        velocity=columns(VELOCITY_COLUMNS) if "vx" in header else None,
        arms={
            arm: ArmLog(columns(CONTACT_COLUMNS, f"{arm}."), columns(WRENCH_COLUMNS, f"{arm}."))
            for arm in arm_names(header)
        },
        name=name,
    )


def _numbers(header: Sequence[str], lines: Sequence[tuple[int, list[str]]], name: str) -> Array:
    table = np.empty((len(lines), len(header)))
    for i, (line, row) in enumerate(lines):
        if len(row) != len(header):
            what = "a comment, where only rows may stand: " if row[0].startswith("#") else ""
            why = f"{what}{len(row)} cells, the header has {len(header)} columns"
            raise LogError(Place(name, line), "", why)
        try:
            if not _is_plain("".join(row)):
                raise ValueError
            table[i] = row
        except ValueError:
            table[i] = [_number(cell, column, line, name) for cell, column in zip(row, header, strict=True)]
        if np.isinf(table[i]).any():
            j = int(np.flatnonzero(np.isinf(table[i]))[0])
            raise LogError(Place(name, line, j + 1), header[j], f"{_short(row[j].strip())} is not a finite number")
    return table


def _is_plain(text: str) -> bool:
    """Without what Python takes for a part of a number and no other reader does: 1_000, or digits of other scripts."""
    return text.isascii() and "_" not in text


def _number(cell: str, column: str, line: int, name: str) -> float:
    cell = cell.strip()
    if cell in MISSING_CELLS:
        return math.nan
    try:
        if not _is_plain(cell):
            raise ValueError
        return float(cell)
    except ValueError:
        why = f"{_short(cell)!r} is not a number (a missing sample is a blank cell or nan)"
        raise LogError(Place(name, line), column, why) from None


def _short(text: str) -> str:
    return text if len(text) <= MAX_CELL_CHARS else text[:MAX_CELL_CHARS] + "…"


def clock_fault(time: Array, word: str) -> tuple[int, str] | None:
    """The first row at whose time (n,), s, a clock that is called so stands still, goes back or is missing, and why."""
    blank = np.flatnonzero(~np.isfinite(time))
    if len(blank):
        return int(blank[0]), "a row without a time"
    back = np.flatnonzero(time[1:] <= time[:-1])
    if not len(back):
        return None
    i = int(back[0]) + 1
    step = "repeats" if time[i] == time[i - 1] else "goes back on"
    return i, f"{time[i]:.15g} s {step} {time[i - 1]:.15g} s of the row before; {word} must increase strictly"
