"""A file with a table in it: its names, and its columns as numbers; read as it is said to be, nothing is guessed."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import LogError, Place, printable
from ...frames import Array
from ...yaml_file import did_you_mean
from ..csv_log import MAX_CELL_CHARS, MISSING_CELLS, opened_text
from .table_map import TableFormat

MISSING_TABLE_CELLS = (*MISSING_CELLS, "NA", "N/A", "#N/A", "null", "None", "-", "--")
NUMBER_PATTERN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
DATE_PATTERN = re.compile(r"\d[-/.:]\d{1,2}[-/.:]\d")
"""A pattern found in a date, or in a time of the day."""
PARQUET_SUFFIX = ".parquet"


@dataclass(frozen=True)
class Table:
    """`header` is None where columns have no names; `lines` are those of the file that its rows are from. Cells are
    text, by column, or numbers (Parquet's)."""

    name: str
    header: tuple[str, ...] | None
    cells: Sequence[Sequence[str] | Array]
    lines: Sequence[int]
    decimal: str = "."
    header_line: int | None = None

    def index(self, column: str | int) -> int:
        """The index, from 0, of a column that is named or numbered from 1; raises LogError."""
        width = len(self.cells)
        if isinstance(column, int):
            if not 1 <= column <= width:
                raise self.refuse(str(column), f"there is no such column; there are 1 to {width}")
            return column - 1
        if self.header is None:
            raise self.refuse(column, f"its columns have no names; give a number from 1 to {width}")
        if self.header.count(column) > 1:
            raise self.refuse(column, "stands twice in the header; give its number, from 1")
        if column not in self.header:
            raise self.refuse(column, f"there is no such column{did_you_mean(column, self.header)}")
        return self.header.index(column)

    def column(self, column: str | int) -> Array:
        """Numbers (n,); NaN where a cell is blank."""
        j = self.index(column)
        cells = self.cells[j]
        if isinstance(cells, np.ndarray):
            return cells
        return np.array([self._number(cell, line, column) for cell, line in zip(cells, self.lines, strict=True)])

    def refuse(self, column: str | int, why: str, line: int | None = None) -> LogError:
        place = Place(self.name, self.header_line if line is None else line)
        return LogError(place, printable(str(column)), printable(why))

    def _number(self, cell: str, line: int, column: str | int) -> float:
        value = number(cell, self.decimal)
        if value is None or math.isinf(value):
            short = cell.strip() if len(cell) <= MAX_CELL_CHARS else cell[:MAX_CELL_CHARS] + "…"
            cure = "write times as seconds" if DATE_PATTERN.search(cell) else "a missing sample is a blank cell or nan"
            raise self.refuse(column, f"{short!r} is not a number ({cure})", line)
        return value


def number(cell: str, decimal: str) -> float | None:
    """None if it is none; NaN if it is missing. Digits in groups are no number: 1,234 may be 1.234."""
    cell = cell.strip()
    if cell in MISSING_TABLE_CELLS:
        return math.nan
    if decimal == ",":
        if "." in cell:
            return None
        cell = cell.replace(",", ".")
    return float(cell) if NUMBER_PATTERN.fullmatch(cell) else None


def read_table(path: Path, layout: TableFormat) -> Table:
    """The table in a file."""
    if path.suffix.lower() == PARQUET_SUFFIX:
        return _parquet(path, layout.every)
    name, lines = str(path), text_lines(path)
    header = None
    if layout.header is not None:
        if layout.header > len(lines):
            why = f"the header is said to be there; the file has {len(lines)} lines"
            raise LogError(Place(name, layout.header), "", why)
        header = tuple(cell.strip() for cell in split(lines[layout.header - 1], layout.separator))
    numbered = [(i + 1, line) for i, line in enumerate(lines) if i + 1 >= layout.first and line.strip()]
    rows = [(i, split(line, layout.separator)) for i, line in numbered]
    if not rows:
        raise LogError(Place(name, layout.first), "", "the table has no rows")
    width = len(rows[0][1]) if header is None else len(header)
    for i, row in rows:
        if len(row) != width:
            why = f"{len(row)} cells, {width} columns: what parts cells, and is this a row?"
            raise LogError(Place(name, i), "", why)
    kept = rows[:: layout.every]
    cells = list(zip(*(row for _, row in kept), strict=True))
    return Table(name, header, cells, [i for i, _ in kept], layout.decimal, layout.header)


def _parquet(path: Path, every: int) -> Table:
    """What is no column of numbers is refused when it is asked for, as text that is none."""
    from ..parquet_log import open_parquet, parquet_numbers, parquet_text

    name, table = str(path), open_parquet(path)
    if not table.num_rows:
        raise LogError(Place(name), "", "the table has no rows")
    cells: list[Sequence[str] | Array] = []
    for j in range(table.num_columns):
        try:
            cells.append(parquet_numbers(table, j, name)[::every])
        except LogError:
            cells.append(parquet_text(table, j)[::every])
    header = tuple(str(column) for column in table.column_names)
    return Table(name, header, cells, range(1, table.num_rows + 1, every))


def text_lines(path: Path) -> list[str]:
    """The lines of a file as an editor counts them. Cells that span lines are refused later, as rows of another
    width."""
    with opened_text(path) as stream:
        return re.split(r"\r\n|\n|\r", stream.read())


def split(line: str, separator: str) -> list[str]:
    """The cells of a line; blanks part them however many there are."""
    if separator == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True), [])
    except csv.Error:
        return line.split(separator)
