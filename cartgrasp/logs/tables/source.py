"""The samples that a table's map asks of its columns, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...frames import Array, unwrapped
from ..csv_log import clock_fault
from ..mapped.planar_pose import MAX_TILT, QUATERNION_NORM_TOLERANCE
from ..mapped.processing_steps import ProcessingSteps
from ..mapped.reading import MappedSamples, MapReading
from ..mapped.timed_samples import MAX_MEASUREMENT, MapPlace, TimedSamples, step_figures
from ..run_log import CONTACT_COLUMNS, POSE_COLUMNS, VELOCITY_COLUMNS, WRENCH_COLUMNS
from .table_file import Table, read_table
from .table_map import (
    ColumnEntry,
    ContactColumns,
    QuaternionEntry,
    TableArm,
    TableMapFile,
    TablePart,
    TimeEntry,
    Value,
    dimension_of,
    load_table_map,
)
from .units import UNITS, unit_of


def read_table_log(path: Path, topics: str | Path) -> MapReading:
    """A table's log with how it came about."""
    return TableSource(path, load_table_map(topics)).read().log()


@dataclass
class TableSource:
    """Columns of a file, and of others that the map names."""

    path: Path
    map_file: TableMapFile
    steps: ProcessingSteps = field(default_factory=ProcessingSteps)
    tables: dict[Path, Table] = field(default_factory=dict)

    def read(self) -> MappedSamples:
        map_ = self.map_file.map
        found: dict[MapPlace, TimedSamples] = {}
        pose = map_.pose
        has_velocity = pose.velocity == "columns"
        names = (*POSE_COLUMNS, *(VELOCITY_COLUMNS if has_velocity else ()))
        samples = self._clocked(("pose",), pose, {name: getattr(pose, name) for name in names}, pose.latency)
        tracked = samples.numbers[:, :3]
        tracked[:, 2] = unwrapped(tracked[:, 2])
        found["pose",] = TimedSamples(samples.time, tracked)
        if has_velocity:
            found["velocity",] = TimedSamples(samples.time, samples.numbers[:, 3:])
        if map_.clock != "pose":  # to which a blank is no sample
            found = {where: samples.whole for where, samples in found.items()}
        for name, arm in map_.arms.items():
            found |= self._arm(name, arm)
        is_in_world = pose.frame == "world"
        return MappedSamples(str(self.path), self.map_file, found, self.steps, is_velocity_in_world=is_in_world)

    def _arm(self, name: str, arm: TableArm) -> dict[MapPlace, TimedSamples]:
        where = ("arms", name)
        rest = 0.0 if arm.unmeasured == "zero" else np.nan
        values = {part: getattr(arm, part) if part in (arm.measures or ()) else rest for part in WRENCH_COLUMNS}
        found: dict[MapPlace, TimedSamples] = {where: self._clocked(where, arm, values, arm.latency)}
        if isinstance(arm.contact, ContactColumns):
            points = {part: getattr(arm.contact, part) for part in CONTACT_COLUMNS}
            found[*where, "contact"] = self._clocked((*where, "contact"), arm, points, arm.latency).whole
        return found

    def _clocked(
        self, where: MapPlace, part: TablePart, values: Mapping[str, Value | QuaternionEntry], latency: float
    ) -> TimedSamples:
        """Rows in which nothing stands, nor a time, are the end of a shorter column."""
        path, layout, entry = self.path, self.map_file.map.table, self.map_file.map.time
        if part.file is not None:
            path, layout, entry = self.path.parent / part.file, part.table, part.time
            if Path(part.file).is_absolute() or ".." in Path(part.file).parts:
                raise self.map_file.refuse((*where[:2], "file"), "name a file in the same folder, or below it")
        assert entry is not None
        if path not in self.tables:
            self.tables[path] = read_table(path, layout)
        table = self.tables[path]
        columns = [_numbers(table, name, value) for name, value in values.items()]
        time = _time(table, entry, layout.every)
        by_column = {name: value for name, value in values.items() if isinstance(value, ColumnEntry)}
        recorded = [column for column, name in zip(columns, values, strict=True) if name in by_column]
        present = np.isfinite(time) | (np.isfinite(np.array(recorded)).any(axis=0) if recorded else False)
        lines = np.array(table.lines)[present]
        time, numbers = time[present], np.column_stack(columns)[present]
        _check_clock(table, entry, time, lines)
        said = {name: _said(value) for name, value in by_column.items()}
        figures: dict[str, Any] = {"role": ".".join(where), "samples": len(time), "latency_s": latency, **said}
        figures |= step_figures(time)
        self.steps.add(Path(table.name).name, "columns", **figures)
        return TimedSamples(time - latency, numbers)


def _numbers(table: Table, name: str, value: Value | QuaternionEntry) -> Array:
    if isinstance(value, QuaternionEntry):
        return _yaw(table, value)
    if not isinstance(value, ColumnEntry):
        return np.full(len(table.lines), float(value))
    assert value.column is not None
    numbers = in_si(table.column(value.column), name, value)
    if (np.abs(numbers) > MAX_MEASUREMENT).any():
        i = int(np.nanargmax(np.abs(numbers)))
        raise table.refuse(value.column, f"{numbers[i]:.3g} in SI units is no measurement", table.lines[i])
    return numbers


def _time(table: Table, entry: TimeEntry, every: int) -> Array:
    """The time of each row (n,), s."""
    if entry.rate is not None:
        return np.asarray(np.arange(len(table.lines)) * (every / entry.rate))
    assert entry.column is not None
    return table.column(entry.column) * UNITS["time"][unit_of(entry.unit or "", "time") or "s"]


def in_si(numbers: Array, name: str, value: ColumnEntry) -> Array:
    """A column (n,) as the map says that it is to be read."""
    dimension = dimension_of(name, value)
    found = numbers * UNITS[dimension][unit_of(value.unit or "", dimension) or ""]
    if value.radius is not None and dimension == "angle":
        found = unwrapped(found) * value.radius
    elif value.radius is not None:
        found = found / value.radius
    found = value.sign * value.factor * found
    if value.zero == "start" and np.isfinite(found).any():
        found = found - found[np.isfinite(found)][0]
    return np.asarray(found)


def yaw_of(quaternion: Array) -> Array:
    """Headings (n,), rad, of quaternions x, y, z, w (n, 4), or z, w (n, 2)."""
    z, w = quaternion[:, -2:].T
    x, y = quaternion[:, :2].T if quaternion.shape[1] == 4 else (0.0, 0.0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z))


def _yaw(table: Table, entry: QuaternionEntry) -> Array:
    rows = np.column_stack([table.column(column) for column in entry.quaternion])
    tilt = np.arccos(np.clip(1 - 2 * (rows[:, :-2] ** 2).sum(axis=1), -1, 1))
    if (tilt > MAX_TILT).any():
        i = int(np.nanargmax(tilt))
        why = f"the frame is {np.degrees(tilt[i]):.0f}° off the vertical; a heading needs one whose z points up"
        raise table.refuse(entry.quaternion[0], why, table.lines[i])
    odd = np.abs(np.linalg.norm(rows, axis=1) - 1) > QUATERNION_NORM_TOLERANCE
    if odd.any():
        i = int(np.argmax(odd))
        why = f"the quaternion's norm is {np.linalg.norm(rows[i]):.3g}, not 1"
        raise table.refuse(entry.quaternion[0], why, table.lines[i])
    return yaw_of(rows)


def _said(value: ColumnEntry) -> str:
    parts = [str(value.column), value.unit or ""]
    if value.radius:
        how = "over" if value.unit and unit_of(value.unit, "moment") else "times"
        parts.append(f"{how} {value.radius:g} m")
    if value.sign * value.factor != 1:
        parts.append(f"times {value.sign * value.factor:g}")
    return " ".join(part for part in parts if part)


def _check_clock(table: Table, entry: TimeEntry, time: Array, lines: NDArray[np.int64]) -> None:
    column = "t" if entry.column is None else entry.column
    if not len(time):
        raise table.refuse(column, "no row has a time")
    if fault := clock_fault(time, "times"):
        raise table.refuse(column, fault[1], int(lines[fault[0]]))
