"""`topics.yaml`: which topics of a bag are a run, in which frames, and with which signs; strict, with exact places."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from ruamel.yaml.comments import CommentedMap

from ...errors import FileError, printable
from ...yaml_file import StrictModel, file_error, parse_yaml, read_yaml, validate

LARGEST = 1e6
"""m, rad, kg: what is beyond is no unit of these."""
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Triple = Annotated[list[Number], Field(min_length=3, max_length=3)]
Positive = Annotated[float, Field(gt=0)]
Bounded = Annotated[float, Field(gt=0, le=LARGEST)]
FARTHEST = 2**62
Latency = Annotated[float, Field(ge=-10, le=10)]


class PoseNoise(StrictModel):
    """One standard deviation of a pose: m and rad."""

    position: Bounded
    heading: Bounded


class PoseEntry(StrictModel):
    """Where the cart's pose comes from; `body` is the pose x, y, yaw of {b} in the frame that is tracked."""

    topic: str
    frame: str | None = None
    child: str | None = None
    latency: Latency = 0.0
    body: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: Literal["spline", "twist", "none"] = "none"
    noise: PoseNoise | None = None


class ContactEntry(StrictModel):
    """A contact point that moves: the position of `child` in `frame`, which is {b}, from a TF topic."""

    topic: str
    frame: str
    child: str


class SensorEntry(StrictModel):
    """Pose of the sensor's frame in {a}: m, and roll, pitch, yaw about fixed axes in rad."""

    position: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    rpy: Triple = Field(default_factory=lambda: [0.0, 0.0, 0.0])


class ToolEntry(StrictModel):
    """What hangs between sensor and cart: kg, and its centre of mass in the sensor's frame, m."""

    mass: Bounded
    com: Triple


class ArmEntry(StrictModel):
    """One arm's force sensor."""

    topic: str
    contact: Triple | ContactEntry | None
    force: Literal["on_cart", "on_sensor"] | None
    latency: Latency = 0.0
    sensor: SensorEntry = Field(default_factory=SensorEntry)
    tool: ToolEntry | None = None
    tare: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None


class TopicMap(StrictModel):
    """All of it; `clock` is `pose` or an arm, whose stamps are the log's, or a rate in Hz; `epoch` its zero in ns. The
    arms are stated, be there none (`{}`: nobody touches the cart)."""

    pose: PoseEntry
    arms: dict[str, ArmEntry]
    stamps: Literal["header", "receive"] = "header"
    clock: str | Annotated[float, Field(gt=0, le=10_000)] = "pose"
    max_gap: Positive = 0.1
    epoch: Annotated[int, Field(ge=-FARTHEST, le=FARTHEST)] | None = None


class MapFile:
    """A topic map with the file that it is from, for what turns out to be wrong only beside the bag."""

    def __init__(self, document: CommentedMap, name: str) -> None:
        self.document, self.name = document, name
        self.map = validate(TopicMap, document, name)
        self._check()

    def refuse(self, location: tuple[str, ...], why: str) -> FileError:
        return file_error(self.document, self.name, location, printable(why))

    def _check(self) -> None:
        for name, arm in self.map.arms.items():
            where = ("arms", name)
            if not name or "." in name:
                raise self.refuse(where, "an arm's name has no dot and is not empty")
            if arm.contact is None:
                raise self.refuse((*where, "contact"), "is not stated: give [x, y, z] of the contact point in {b}, m")
            if arm.force is None:
                why = "is not stated: on_cart if positive numbers are what the arm does to the cart, else on_sensor"
                raise self.refuse((*where, "force"), why)
            if arm.tare is not None and not arm.tare[0] < arm.tare[1]:
                raise self.refuse((*where, "tare"), "begins after it ends; give [from, to] in s")
        wrenches = [arm.topic for arm in self.map.arms.values()]
        for name, arm in self.map.arms.items():
            if wrenches.count(arm.topic) > 1:
                raise self.refuse(("arms", name, "topic"), f"{arm.topic} is that of another arm too")
        clock = self.map.clock
        if isinstance(clock, str) and clock != "pose" and clock not in self.map.arms:
            raise self.refuse(("clock",), f"{clock!r} is neither pose nor an arm, nor a rate in Hz")
        if self.map.pose.velocity == "spline" and self.map.pose.noise is None:
            raise self.refuse(
                ("pose", "noise"), "is missing; a velocity by spline needs it: {position: m, heading: rad}"
            )


def load_topic_map(path: str | os.PathLike[str]) -> MapFile:
    """The map of a `topics.yaml`; a mistake is refused as `file:line:column: key: why`."""
    return MapFile(read_yaml(path), str(path))


def topic_map_from_text(text: str, name: str = "topics.yaml") -> MapFile:
    return MapFile(parse_yaml(text, name), name)


def beside(bag: Path) -> tuple[Path, Path]:
    """Where a bag's own map lies, and where that of all bags in its folder."""
    return bag.with_name(f"{bag.name}.topics.yaml"), (bag if bag.is_dir() else bag.parent) / "topics.yaml"
