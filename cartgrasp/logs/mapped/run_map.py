"""What every map says of a run, be it of a bag's topics or of a table's columns; strict, with exact places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import Field
from ruamel.yaml.comments import CommentedMap

from ...checks import MAX_DISTANCE, angle
from ...errors import FileError, UsageError, printable
from ...yaml_file import StrictModel, file_error, validate

MAX_MAP_NUMBER = 1e6
"""m, rad, kg: what is beyond is no unit of these."""
Number = Annotated[float, Field(ge=-MAX_MAP_NUMBER, le=MAX_MAP_NUMBER)]
Triple = Annotated[list[Number], Field(min_length=3, max_length=3)]
Positive = Annotated[float, Field(gt=0)]
Bounded = Annotated[float, Field(gt=0, le=MAX_MAP_NUMBER)]
Latency = Annotated[float, Field(ge=-10, le=10)]
Location = tuple[str, ...]
Mistake = tuple[Location, str]


class PoseNoise(StrictModel):
    """One standard deviation of a pose: m and rad."""

    position: Bounded
    heading: Bounded


class PoseEntry(StrictModel):
    """The cart's pose; `body` is the pose x, y, yaw of {b} in the frame that is tracked."""

    latency: Latency = 0.0
    body: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: Literal["spline", "twist", "columns", "none"] = "none"
    noise: PoseNoise | None = None


class SensorEntry(StrictModel):
    """Pose of the sensor's frame in {a}: m, and roll, pitch, yaw about fixed axes in rad."""

    position: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    rpy: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])


class ToolEntry(StrictModel):
    """What hangs between sensor and cart: kg, and its centre of mass in the sensor's frame, m."""

    mass: Bounded
    com: Triple


class ArmEntry(StrictModel):
    """One arm's force sensor; `contact` is in {b}, m, and one that moves is a mapping."""

    contact: Triple | StrictModel | None = None
    force: Literal["on_cart", "on_sensor"] | None = None
    latency: Latency = 0.0
    sensor: SensorEntry = Field(default_factory=SensorEntry)
    tool: ToolEntry | None = None
    tare: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None


class RunMap(StrictModel):
    """`clock` is `pose` or an arm, whose times are the log's, or a rate in Hz. The arms are stated, be there none
    (`{}`: nobody touches the cart)."""

    pose: PoseEntry
    arms: Mapping[str, ArmEntry]
    clock: str | Annotated[float, Field(gt=0, le=10_000)] = "pose"
    max_gap: Positive = 0.1

    def own_mistakes(self) -> Iterator[Mistake]:
        """What is wrong, or blank, in what one kind of map has and others have not."""
        return iter(())

    def mistakes(self) -> Iterator[Mistake]:
        """Where, and why: all that is blank first."""
        for name, arm in self.arms.items():
            where = ("arms", name)
            if not name or "." in name:
                yield where, "an arm's name has no dot and is not empty"
            if arm.contact is None:
                yield (*where, "contact"), "is not stated: give [x, y, z] of the contact point in {b}, m"
            if isinstance(arm.contact, list) and max(map(abs, arm.contact)) > MAX_DISTANCE:
                yield (*where, "contact"), f"{arm.contact} is beyond {MAX_DISTANCE:g} m; lengths are in m"
            yield from _of_angles((*where, "sensor", "rpy"), arm.sensor.rpy)
            if arm.force is None:
                why = "is not stated: on_cart if positive numbers are what the arm does to the cart, else on_sensor"
                yield (*where, "force"), why
            if arm.tare is not None and not arm.tare[0] < arm.tare[1]:
                yield (*where, "tare"), "begins after it ends; give [from, to] in s"
        yield from _of_angles(("pose", "body"), self.pose.body[2:])
        yield from self.own_mistakes()
        if isinstance(self.clock, str) and self.clock != "pose" and self.clock not in self.arms:
            yield ("clock",), f"{self.clock!r} is neither pose nor an arm, nor a rate in Hz"
        if self.pose.velocity == "spline" and self.pose.noise is None:
            yield ("pose", "noise"), "is missing; a velocity by spline needs it: {position: m, heading: rad}"


def _of_angles(where: Location, angles: Sequence[float]) -> Iterator[Mistake]:
    for one in angles:
        try:
            angle(".".join(where), one)
        except UsageError as error:
            yield where, str(error).partition(": ")[2]


Map = TypeVar("Map", bound=RunMap)


class MapFile(Generic[Map]):
    """A map with the file that it is from, for what turns out to be wrong only beside the data. All that is blank or
    wrong is told at once; `page` names the documentation that explains."""

    def __init__(
        self, kind: type[Map], document: CommentedMap, name: str, page: str = "", unsure: Sequence[Mistake] = ()
    ) -> None:
        self.document, self.name, self.page = document, name, page
        self.map = validate(kind, document, name)
        if found := [*unsure, *self.map.mistakes()]:
            raise self._refuse_all(found)

    def refuse(self, location: Location, why: str) -> FileError:
        return file_error(self.document, self.name, location, printable(why))

    def _refuse_all(self, found: Sequence[Mistake]) -> FileError:
        (first, why), *rest = found
        if not rest:
            return self.refuse(first, why + (f"; {self.page} explains" if self.page else ""))
        others = [self.refuse(*one) for one in rest]
        also = "; ".join(f"line {one.place.line}: {one.key}: {one.why}" for one in others)
        return self.refuse(first, f"{why}. Beside it, {also}" + (f". {self.page} explains" if self.page else ""))
