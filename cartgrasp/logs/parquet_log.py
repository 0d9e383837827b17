"""Run logs as Parquet, with the same columns as the CSV ones (extra `parquet`)."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import LogError, Place, UsageError
from ..frames import Array
from ..writing import write_atomically
from .csv_log import check_columns, log_from_table
from .run_log import RunLog


def read_parquet(path: str | Path) -> RunLog:
    """The log of a Parquet file."""
    name, table = str(path), open_parquet(path)
    header = [str(column) for column in table.column_names]
    check_columns(header, name)
    columns = [parquet_numbers(table, j, name) for j in range(len(header))]
    return log_from_table(header, np.column_stack(columns), name, range(1, table.num_rows + 1))


def open_parquet(path: str | Path) -> Any:
    """Its table as Arrow has it."""
    arrow, parquet = _libraries()
    try:
        return parquet.ParquetFile(path).read()  # read_table would add columns for folders named `key=value`
    except (OSError, arrow.ArrowException) as error:
        raise LogError(Place(str(path)), "", f"can't be read as Parquet: {str(error).splitlines()[0]}") from error


def parquet_numbers(table: Any, j: int, name: str) -> Array:
    """A column (n,), NaN where it is null."""
    arrow, _ = _libraries()
    column, kind = str(table.column_names[j]), table.schema.field(j).type
    try:
        if not (arrow.types.is_floating(kind) or arrow.types.is_integer(kind) or arrow.types.is_null(kind)):
            raise ValueError
        values = np.asarray(table.column(j).cast(arrow.float64()).to_numpy())
    except (arrow.ArrowException, ValueError) as error:
        raise LogError(Place(name), column, f"holds {kind}, not numbers") from error
    if np.isinf(values).any():
        row = int(np.flatnonzero(np.isinf(values))[0])
        raise LogError(Place(name, row + 1), column, "is not a finite number")
    return values


def parquet_text(table: Any, j: int) -> list[str]:
    """The cells (n,) of a column that holds no numbers; Python has no type for dates to the nanosecond."""
    arrow, _ = _libraries()
    column = table.column(j)
    if arrow.types.is_temporal(column.type):
        column = column.cast(arrow.string())
    return [str(cell) for cell in column.to_pylist()]


def write_parquet(log: RunLog, path: str | Path) -> Path:
    arrow, parquet = _libraries()
    stream = io.BytesIO()
    columns = dict(zip(log.columns, log.table.T, strict=True))
    parquet.write_table(arrow.table({k: arrow.array(v, from_pandas=True) for k, v in columns.items()}), stream)
    return write_atomically(path, stream.getvalue())


def _libraries() -> tuple[Any, Any]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise UsageError("Parquet logs need pyarrow: in cartgrasp's clone, pip install '.[parquet]'") from error
    return pyarrow, pyarrow.parquet
