"""How a text file seems to be a table: what parts cells, which mark is the decimal one, where names and rows begin."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ....errors import LogError, Place
from ..table_file import MISSING_TABLE_CELLS, PARQUET_SUFFIX, number, split, text_lines
from ..table_map import TableFormat
from ..units import UNITS, unit_of

SEPARATORS = (";", "\t", ",", "|", " ")
MAX_LAYOUT_LINES = 400
"""Lines."""
MAJORITY_FRACTION = 0.5


@dataclass(frozen=True)
class Layout:
    """`units` are those of a row below the names, by column; `is_sure` of the decimal mark."""

    format: TableFormat
    units: tuple[str, ...] = ()
    is_sure: bool = True


def layout_of(path: Path) -> Layout:
    """Raises LogError where no rows of numbers are found."""
    if path.suffix.lower() == PARQUET_SUFFIX:
        return Layout(TableFormat())
    lines = text_lines(path)
    looks = [(i, line) for i, line in enumerate(lines) if line.strip()][:MAX_LAYOUT_LINES]
    best, score = None, (0.0, 0)
    for separator in SEPARATORS:
        for decimal in (".", ",") if separator != "," else (".",):
            cells = [(i, split(line, separator)) for i, line in looks]
            rows, share = _rows(cells, decimal)
            if (round(share, 2), len(rows) * len(rows[0][1]) if rows else 0) > score:
                best, score = (separator, decimal, cells, rows), (round(share, 2), len(rows) * len(rows[0][1]))
    if best is None:
        why = "no rows of two columns of numbers or more are found in it; what parts its cells?"
        raise LogError(Place(str(path)), "", why)
    separator, decimal, cells, rows = best
    header, units = _header(cells, rows[0][0], len(rows[0][1]), separator, decimal)
    named = None if header is None else header + 1
    said = {"separator": separator, "decimal": decimal, "header": named, "first": rows[0][0] + 1}
    return Layout(TableFormat.model_validate(said), units, decimal == "." or not _may_be_groups(rows))


def _rows(cells: Sequence[tuple[int, list[str]]], decimal: str) -> tuple[list[tuple[int, list[str]]], float]:
    """The rows of the commonest width in which at least half the cells that are not blank are numbers, and the share of
    numbers."""
    widths = [len(row) for _, row in cells]
    width = max(set(widths), key=widths.count)
    if width < 2:
        return [], 0.0
    rows = [(i, row) for i, row in cells if len(row) == width and _share(row, decimal) >= MAJORITY_FRACTION]
    total = sum(_share(row, decimal) for _, row in rows)
    return rows, total / len(cells)


def _share(row: Sequence[str], decimal: str) -> float:
    """The share of numbers among the cells that are not missing."""
    cells = [cell for cell in row if cell.strip() not in MISSING_TABLE_CELLS]
    return sum(number(cell, decimal) is not None for cell in cells) / len(cells) if cells else 0.0


def _header(
    cells: Sequence[tuple[int, list[str]]], first: int, width: int, separator: str, decimal: str
) -> tuple[int | None, tuple[str, ...]]:
    """The line of the names, and the units of a row between them and the numbers."""
    above = [
        (i, row)
        for i, row in ((i, _bare(row, width)) for i, row in cells if i < first)
        if len(row) == width and _share(row, decimal) < MAJORITY_FRACTION
    ]
    if not above:
        return None, ()
    i, row = above[-1]
    if len(above) > 1 and _are_units(row):
        return above[-2][0], tuple(cell.strip().strip("[]()") for cell in row)
    return i, ()


def _bare(row: list[str], width: int) -> list[str]:
    """The row without a comment sign that stands alone before the names."""
    return row[1:] if len(row) == width + 1 and row[0].strip() in ("#", "%") else row


def _are_units(row: Sequence[str]) -> bool:
    words = [cell.strip().strip("[]()") for cell in row]
    words = [word for word in words if word not in ("", "-", "1")]
    known = [word for word in words if any(unit_of(word, dimension) for dimension in UNITS)]
    return len(words) > 0 and len(known) > MAJORITY_FRACTION * len(words)


def _may_be_groups(rows: Sequence[tuple[int, list[str]]]) -> bool:
    """Whether every comma may as well part thousands: three digits behind each, and no 0 alone before it."""
    commas = [cell.strip() for _, row in rows for cell in row if "," in cell]
    return bool(commas) and all(re.fullmatch(r"[+-]?[1-9]\d{0,2},\d{3}", cell) for cell in commas)
