"""A reference as a file: stretches of constant acceleration from rest to rest, and the pose where they begin.

says: roll forwards at 0.8 m/s, turn left on the spot    # optional
start: [0.0, 0.0, 0.0]                                   # m, m, rad; optional
stretches:
  - {duration: 1.6, acceleration: 0.5}
  - {duration: 1.6, acceleration: -0.5}
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from .checks import number, pose
from .errors import UsageError
from .writing import write_atomically
from .yaml_file import StrictModel, dump_yaml, file_error, read_yaml, validate

REST_SPEED_TOLERANCE = 1e-9
"""m/s and rad/s."""
STORED_DIGITS = 6
MAX_REFERENCE_SPEED = 100.0
"""m/s and rad/s: beyond, numbers are not in SI units."""

MAX_STRETCH_DURATION, MAX_STRETCH_ACCELERATION = 1e5, 100.0
"""s or m; m/s² or rad/s²: what is beyond is a slip of units."""


@dataclass(frozen=True)
class Stretch:
    """For `duration` (s), constant rates of forward speed (m/s²) and of yaw rate (rad/s²)."""

    duration: float
    acceleration: float = 0.0
    yaw_acceleration: float = 0.0

    def __post_init__(self) -> None:
        number("stretch: duration", self.duration, 0.0, MAX_STRETCH_DURATION, "give s")
        for name, unit in (("acceleration", "m/s²"), ("yaw_acceleration", "rad/s²")):
            most = MAX_STRETCH_ACCELERATION
            number(f"stretch: {name}", getattr(self, name), -most, most, f"give {unit}")


@dataclass(frozen=True)
class StoredReference:
    """From rest at `start`, (x, y, theta) in {s}, to rest; `says` what to do."""

    stretches: tuple[Stretch, ...]
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    says: str = ""

    @property
    def duration(self) -> float:
        return sum(stretch.duration for stretch in self.stretches)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """As YAML that `read_reference` reads, in few digits where these end at rest, too."""
        document = CommentedMap({"says": self.says} if self.says else {})
        document["start"] = CommentedSeq(round(float(value), STORED_DIGITS) for value in self.start)
        document["start"].fa.set_flow_style()
        rounded = [Stretch(*(round(float(v), STORED_DIGITS) for v in vars(one).values())) for one in self.stretches]
        is_whole = all(one.duration for one in rounded) and _ends_at_rest(rounded)
        document["stretches"] = [_entry(stretch) for stretch in (rounded if is_whole else self.stretches)]
        return write_atomically(path, dump_yaml(document))


class _StretchEntry(StrictModel):
    duration: float = Field(gt=0.0, le=3600.0)
    acceleration: float = 0.0
    yaw_acceleration: float = 0.0


class _ReferenceEntry(StrictModel):
    says: str = ""
    start: list[float] = Field(default=[0.0, 0.0, 0.0], min_length=3, max_length=3)
    stretches: list[_StretchEntry] = Field(min_length=1)


def read_reference(path: str | os.PathLike[str]) -> StoredReference:
    """A mistake is refused as `file:line:column: key: why`."""
    document, name = read_yaml(path), str(path)
    entry = validate(_ReferenceEntry, document, name)
    speed = yaw_rate = 0.0
    stretches: list[Stretch] = []
    for i, one in enumerate(entry.stretches):
        speed, yaw_rate = speed + one.duration * one.acceleration, yaw_rate + one.duration * one.yaw_acceleration
        if max(abs(speed), abs(yaw_rate)) > MAX_REFERENCE_SPEED:
            why = f"leads to {speed:g} m/s and {yaw_rate:g} rad/s; speeds are in m/s, times in s"
            raise file_error(document, name, ["stretches", i], why)
        try:
            stretches.append(Stretch(one.duration, one.acceleration, one.yaw_acceleration))
        except UsageError as error:
            raise file_error(document, name, ["stretches", i], str(error)) from error
    if max(abs(speed), abs(yaw_rate)) > REST_SPEED_TOLERANCE:
        why = f"end with {speed:g} m/s and {yaw_rate:g} rad/s; they must end at rest"
        raise file_error(document, name, ["stretches"], why)
    try:
        start = pose("start", entry.start)
    except UsageError as error:
        raise file_error(document, name, ["start"], str(error)) from error
    return StoredReference(tuple(stretches), start, entry.says)


def _ends_at_rest(stretches: Sequence[Stretch]) -> bool:
    speed = sum(one.duration * one.acceleration for one in stretches)
    yaw_rate = sum(one.duration * one.yaw_acceleration for one in stretches)
    return max(abs(speed), abs(yaw_rate)) <= REST_SPEED_TOLERANCE


def _entry(stretch: Stretch) -> CommentedMap:
    """Without what is zero."""
    entry = CommentedMap({name: float(value) for name, value in vars(stretch).items() if value})
    entry.fa.set_flow_style()
    return entry
