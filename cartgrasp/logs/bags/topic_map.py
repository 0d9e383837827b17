"""`topics.yaml` of a bag: which of its topics are a run, in which frames, and with which signs."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from ...yaml_file import StrictModel, parse_yaml, read_yaml
from ..mapped.run_map import ArmEntry, MapFile, Mistake, PoseEntry, RunMap, Triple

MAX_EPOCH_NS = 2**62


class TopicPose(PoseEntry):
    """A topic's poses; of a TF topic those of `child` in `frame`."""

    topic: str
    frame: str | None = None
    child: str | None = None
    velocity: Literal["spline", "twist", "none"] = "none"


class ContactEntry(StrictModel):
    """A contact point that moves: the position of `child` in `frame`, which is {b}, from a TF topic."""

    topic: str
    frame: str
    child: str


class TopicArm(ArmEntry):
    """A topic's wrenches."""

    topic: str
    contact: Triple | ContactEntry | None = None


class TopicMap(RunMap):
    """`epoch` is the log's zero in ns."""

    pose: TopicPose
    arms: Mapping[str, TopicArm]
    stamps: Literal["header", "receive"] = "header"
    epoch: Annotated[int, Field(ge=-MAX_EPOCH_NS, le=MAX_EPOCH_NS)] | None = None

    def own_mistakes(self) -> Iterator[Mistake]:
        wrenches = [arm.topic for arm in self.arms.values()]
        for name, arm in self.arms.items():
            if wrenches.count(arm.topic) > 1:
                yield ("arms", name, "topic"), f"{arm.topic} is that of another arm too"


TopicMapFile = MapFile[TopicMap]


def load_topic_map(path: str | os.PathLike[str]) -> TopicMapFile:
    """The map of a `topics.yaml`; a mistake is refused as `file:line:column: key: why`."""
    return MapFile(TopicMap, read_yaml(path), str(path))


def topic_map_from_text(text: str, name: str = "topics.yaml") -> TopicMapFile:
    return MapFile(TopicMap, parse_yaml(text, name), name)


def beside(bag: Path) -> tuple[Path, Path]:
    """Where a bag's own map lies, and where that of all bags in its folder."""
    return bag.with_name(f"{bag.name}.topics.yaml"), (bag if bag.is_dir() else bag.parent) / "topics.yaml"
