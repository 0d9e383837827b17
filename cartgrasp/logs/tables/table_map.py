"""`mine.csv.topics.yaml`: which columns of a table are a run, in which units, with which signs.

A value that ends with a question mark is a guess of `cartgrasp topics`: the map is refused until the mark is taken away
or another value stands there, and so is what was left blank.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from ruamel.yaml.comments import CommentedMap

from ...yaml_file import StrictModel, file_error, read_yaml, validate
from ..csv_log import PAGE
from ..mapped.run_map import ArmEntry, Location, MapFile, Mistake, Number, PoseEntry, Positive, RunMap, Triple
from ..run_log import CONTACT_COLUMNS, POSE_COLUMNS, VELOCITY_COLUMNS, WRENCH_COLUMNS
from .questions import guesses, without_marks
from .units import UNITS, unit_of

DIMENSIONS: Mapping[str, str] = {
    **dict.fromkeys(("x", "y", *CONTACT_COLUMNS), "length"),
    **dict.fromkeys(("vx", "vy"), "speed"),
    **dict.fromkeys(WRENCH_COLUMNS[:3], "force"),
    **dict.fromkeys(WRENCH_COLUMNS[3:], "moment"),
    "theta": "angle",
    "omega": "rate",
    "t": "time",
}
RADIUS_DIMENSIONS = {"length": "angle", "force": "moment"}
"""What a column with a `radius` holds: a wheel's angle times it is a way, a moment over it a force."""
GUESS_ERROR = "is a guess: take its question mark away if it is right, else put what is right"
GUESS_NOTE = "is a guess"
ARMS_NOT_STATED = "is not stated: {} if nobody touches the cart, else who does"
Component = Literal["fx", "fy", "fz", "tx", "ty", "tz"]


class TableFormat(StrictModel):
    """How a text file is a table: `header` is the line of the columns' names (none: they go by number, from 1), `first`
    the line of the first row; of the rows every so many is taken."""

    separator: Literal[",", ";", "\t", " ", "|"] = ","
    decimal: Literal[".", ","] = "."
    header: Annotated[int, Field(ge=1)] | None = 1
    first: Annotated[int, Field(ge=1)] = 2
    every: Annotated[int, Field(ge=1)] = 1


class ColumnEntry(StrictModel):
    """A column, by name or by number from 1, and what makes SI units of it: `sign * factor * (column in its unit)`,
    times or over a `radius` (m) if it turns about one, less its first value if `zero` is its start."""

    column: str | int | None = None
    unit: str | None = None
    sign: Literal[1, -1] = 1
    factor: Number = 1.0
    radius: Positive | None = None
    zero: Literal["start"] | None = None


class QuaternionEntry(StrictModel):
    """A heading that is the yaw of a quaternion: the columns of x, y, z and w, or of z and w where nothing tilts."""

    quaternion: Annotated[list[str | int], Field(min_length=2, max_length=4)]


class TimeEntry(StrictModel):
    """A column of times, or the rows' rate in Hz where there is none."""

    column: str | int | None = None
    unit: str | None = None
    rate: Annotated[float, Field(gt=0, le=1e6)] | None = None


Value = Number | ColumnEntry
"""A constant in SI units, or a column."""


class TablePart(StrictModel):
    """Another file than the one that is read, in the same folder or below, with its own clock."""

    file: str | None = None
    table: TableFormat = Field(default_factory=TableFormat)
    time: TimeEntry | None = None


class TablePose(PoseEntry, TablePart):
    """`frame` says along which axes velocities are: the world's, or those of what is tracked."""

    x: Value | None = None
    y: Value | None = None
    theta: Value | QuaternionEntry | None = None
    velocity: Literal["spline", "columns", "none"] = "none"
    vx: Value | None = None
    vy: Value | None = None
    omega: Value | None = None
    frame: Literal["world", "cart"] | None = None


class ContactColumns(StrictModel):
    """A contact point that is recorded, in {b}."""

    px: Value | None = None
    py: Value | None = None
    pz: Value | None = None


class TableArm(ArmEntry, TablePart):
    """What is not in `measures` is known to be zero, or is missing: then nothing that needs it is learned."""

    contact: Triple | ContactColumns | None = None
    measures: list[Component] | None = None
    unmeasured: Literal["zero", "missing"] | None = None
    fx: Value | None = None
    fy: Value | None = None
    fz: Value | None = None
    tx: Value | None = None
    ty: Value | None = None
    tz: Value | None = None


class TableMap(RunMap):
    """`table` and `time` are those of the file that is read."""

    pose: TablePose
    arms: Mapping[str, TableArm]
    table: TableFormat = Field(default_factory=TableFormat)
    time: TimeEntry | None = None

    def own_mistakes(self) -> Iterator[Mistake]:
        yield from _of_time(("time",), self.time)
        wanted = (*POSE_COLUMNS, *(VELOCITY_COLUMNS if self.pose.velocity == "columns" else ()))
        yield from _of_values(("pose",), self.pose, wanted)
        if self.pose.velocity == "columns" and self.pose.frame is None:
            yield ("pose", "frame"), "is not stated: world if vx and vy are along its axes, cart if along the cart's"
        yield from _of_part(("pose",), self.pose)
        for name, arm in self.arms.items():
            where = ("arms", name)
            yield from _of_part(where, arm)
            yield from _of_arm(where, arm)


TableMapFile = MapFile[TableMap]


def tables_beside(path: Path, topics: str | Path) -> list[Path]:
    """The tables that a table's map names as `file:`."""
    map_ = load_table_map(topics).map
    return [path.parent / part.file for part in (map_.pose, *map_.arms.values()) if part.file is not None]


def load_table_map(path: str | Path) -> TableMapFile:
    document, name = read_yaml(path), str(path)
    pose = document.get("pose")
    if isinstance(pose, CommentedMap) and "topic" in pose:
        why = "is for bags, and a table is no bag; a table's map names columns: `cartgrasp topics FILE` proposes one"
        raise file_error(document, name, ("pose", "topic"), why)
    unsure = [
        (where, f"{said} {GUESS_NOTE if i else GUESS_ERROR}") for i, (where, said) in enumerate(guesses(document))
    ]
    if document.get("arms", 0) is None:
        unsure.append((("arms",), ARMS_NOT_STATED))
    return MapFile(TableMap, without_marks(document, name), name, PAGE, unsure)


@dataclass(frozen=True)
class Question:
    """At `where` stands a guess (`said`), or nothing."""

    where: Location
    said: str | None
    why: str


def open_questions(document: CommentedMap, name: str) -> list[Question]:
    """All guesses, and all that is blank or wrong."""
    found = [Question(where, said.removesuffix("?"), GUESS_NOTE) for where, said in guesses(document)]
    if document.get("arms", 0) is None:
        found.append(Question(("arms",), None, ARMS_NOT_STATED))
    model = validate(TableMap, without_marks(deepcopy(document), name), name)
    return [*found, *(Question(where, None, why) for where, why in model.mistakes())]


def _of_part(where: Location, part: TablePart) -> Iterator[Mistake]:
    if part.file is not None:
        yield from _of_time((*where, "time"), part.time)
    elif part.time is not None:
        yield (*where, "time"), "is for a sensor with a file of its own; say file: too"


def _of_time(where: Location, time: TimeEntry | None) -> Iterator[Mistake]:
    if time is None or (time.column is None and time.rate is None):
        yield where, "is not stated: {column: NAME, unit: s}, or {rate: Hz} where rows have no time"
    elif time.column is not None and time.rate is not None:
        yield (*where, "rate"), "is for rows without times; keep it, or column"
    elif time.rate is None:
        yield from _of_unit((*where, "unit"), time.unit, "time")


def _of_arm(where: Location, arm: TableArm) -> Iterator[Mistake]:
    if isinstance(arm.contact, ContactColumns):
        yield from _of_values((*where, "contact"), arm.contact, CONTACT_COLUMNS)
    if not arm.measures:
        yield (*where, "measures"), f"is not stated: which of {', '.join(WRENCH_COLUMNS)} the sensor has"
        return
    yield from _of_values(where, arm, arm.measures)
    for name in WRENCH_COLUMNS:
        if getattr(arm, name) is not None and name not in arm.measures:
            yield (*where, name), "is not among what the sensor measures; add it there, or take it away here"
    rest = [name for name in WRENCH_COLUMNS if name not in arm.measures]
    if rest and arm.unmeasured is None:
        why = f"is not stated: zero if {', '.join(rest)} are known to be nothing, else missing"
        yield (*where, "unmeasured"), why


def _of_values(where: Location, entry: StrictModel, names: tuple[str, ...] | list[Component]) -> Iterator[Mistake]:
    taken: dict[str | int, str] = {}
    for name in names:
        value = getattr(entry, name)
        column = value.column if isinstance(value, ColumnEntry) else None
        if column is not None and taken.setdefault(column, name) != name:
            yield (*where, name, "column"), f"{column} is {taken[column]} already; one column holds one quantity"
        if value is None or (isinstance(value, ColumnEntry) and value.column is None):
            yield (*where, name), "is not stated: {column: NAME, unit: UNIT}, or a number if it is constant"
        elif isinstance(value, QuaternionEntry):
            if len(value.quaternion) == 3:
                yield (*where, name, "quaternion"), "needs the columns of x, y, z and w, or of z and w alone"
        elif isinstance(value, ColumnEntry):
            dimension = DIMENSIONS[name]
            if value.radius is not None and dimension not in RADIUS_DIMENSIONS:
                yield (*where, name, "radius"), "is for ways (of an angle) and forces (of a moment) alone"
            else:
                yield from _of_unit((*where, name, "unit"), value.unit, dimension_of(name, value))


def _of_unit(where: Location, unit: str | None, dimension: str) -> Iterator[Mistake]:
    known = ", ".join(UNITS[dimension])
    if unit is None:
        yield where, f"is not stated: one of {known}"
    elif unit_of(unit, dimension) is None:
        yield where, f"{unit} is no unit of {dimension} that is known; known are {known}"


def dimension_of(name: str, value: ColumnEntry) -> str:
    """The dimension of what the column holds: with a `radius`, an angle for a length and a moment for a force."""
    dimension = DIMENSIONS[name]
    return RADIUS_DIMENSIONS.get(dimension, dimension) if value.radius is not None else dimension
