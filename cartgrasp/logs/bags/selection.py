"""The samples that a topic map asks of a bag, each on the log's time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...frames import Array
from ...yaml_file import did_you_mean
from .bag import Bag
from .faults import far_stamps, other_frames, without
from .messages import ODOMETRY, OLD_TRANSFORMS, POSE, TRANSFORMS, WRENCH
from .steps import Steps
from .topic_map import ContactEntry, MapFile
from .topic_samples import ALL, Frames, Key, TopicSamples, read_samples, transforms_of

NANO = 1_000_000_000
TF = (TRANSFORMS, OLD_TRANSFORMS)
Place = tuple[str, ...]


@dataclass(frozen=True)
class Clocked:
    """Times (n,) in s from the log's zero, strictly increasing, and numbers (n, k)."""

    time: Array
    numbers: Array

    def span(self) -> tuple[float, float]:
        return float(self.time[0]), float(self.time[-1])


@dataclass
class Selection:
    """By the place in the map: ("pose",), ("arms", NAME) and ("arms", NAME, "contact")."""

    bag: Bag
    map_file: MapFile
    is_salvage: bool
    steps: Steps = field(default_factory=Steps)

    def read(self) -> dict[Place, Clocked]:
        keys = dict(self._keys())
        self._check_topics(keys)
        wanted: dict[str, set[Frames] | None] = {}
        for topic, frames in keys.values():
            wanted[topic] = None if frames == ALL else (wanted.get(topic) or set()) | {frames}
        found = read_samples(self.bag, wanted, self.is_salvage)
        for where, key in keys.items():
            self._check_found(where, key, found)
        for key in set(keys.values()):
            found[key] = self._of_one_run(found[key])
        epoch = self.map_file.map.epoch
        if epoch is None:
            firsts = {where: int(self._stamps(where, found[key]).min()) for where, key in keys.items()}
            epoch = max(first for where, first in firsts.items() if len(where) < 3)
        self.steps.add("log", "its zero", epoch_ns=epoch, stamps=self.map_file.map.stamps)
        return {where: self._clocked(where, found[key], epoch) for where, key in keys.items()}

    def _keys(self) -> Iterator[tuple[Place, Key]]:
        map_ = self.map_file.map
        pose = map_.pose
        yield ("pose",), (pose.topic, (_frame(pose.frame), _frame(pose.child)))
        for name, arm in map_.arms.items():
            yield ("arms", name), (arm.topic, ALL)
            if isinstance(arm.contact, ContactEntry):
                contact = arm.contact
                yield ("arms", name, "contact"), (contact.topic, (_frame(contact.frame), _frame(contact.child)))

    def _check_topics(self, keys: dict[Place, Key]) -> None:
        if not self.bag.kinds:
            raise self.bag.refuse("has no topic" + (" that can be read" if self.is_salvage else ""))
        for where, (topic, _) in keys.items():
            place = (*where, "topic")
            if topic not in self.bag.kinds:
                known = did_you_mean(topic, self.bag.kinds)
                raise self.map_file.refuse(place, f"{self.bag.path} has no topic {topic}{known}")
            kind = self.bag.kinds[topic]
            of_role = {1: (ODOMETRY, POSE, *TF), 2: (WRENCH,), 3: TF}[len(where)]
            if kind not in of_role:
                raise self.map_file.refuse(place, f"{topic} holds {kind}; needed is {' or '.join(of_role)}")
        pose = self.map_file.map.pose
        is_tf = self.bag.kinds[pose.topic] in TF
        for key, value in (("frame", pose.frame), ("child", pose.child)):
            if is_tf and value is None:
                raise self.map_file.refuse(("pose",), f"{key} is missing; a TF topic holds many transforms")
            if not is_tf and value is not None:
                raise self.map_file.refuse(("pose", key), f"is for TF topics; {pose.topic} has one pose")
        if pose.velocity == "twist" and self.bag.kinds[pose.topic] != ODOMETRY:
            raise self.map_file.refuse(("pose", "velocity"), f"{pose.topic} holds no twist; use spline or none")

    def _check_found(self, where: Place, key: Key, found: dict[Key, TopicSamples]) -> None:
        topic, frames = key
        if key not in found or not len(found[key]):
            if frames != ALL:
                there = ", ".join(f"{a} → {b}" for a, b in transforms_of(self.bag, topic)) or "none"
                why = f"{topic} of {self.bag.path} holds no transform from {frames[0]} to {frames[1]}, but {there}"
                raise self.map_file.refuse(where, why)
            raise self.bag.refuse("has no messages" + (" that can be read" if self.is_salvage else ""), topic)

    def _of_one_run(self, samples: TopicSamples) -> TopicSamples:
        samples = without(samples, other_frames(samples), self.bag, self.is_salvage)
        if self.map_file.map.stamps == "receive" or is_static(samples.topic):
            return samples
        return without(samples, far_stamps(samples, self.map_file.map.max_gap), self.bag, self.is_salvage)

    def _stamps(self, where: Place, samples: TopicSamples) -> NDArray[np.int64]:
        """ns, with the topic's latency taken off."""
        late = round(self._latency(where) * NANO)
        if self.map_file.map.stamps == "receive" or is_static(samples.topic):
            return samples.received - late
        if not samples.stamp.any() and samples.received.any():
            raise self.map_file.refuse(("stamps",), f"the headers of {samples.topic} have no stamps; use receive")
        return samples.stamp - late

    def _latency(self, where: Place) -> float:
        map_ = self.map_file.map
        if len(where) == 2:
            return map_.arms[where[1]].latency
        return map_.pose.latency if where == ("pose",) else 0.0

    def _clocked(self, where: Place, samples: TopicSamples, epoch: int) -> Clocked:
        """Sorted by time, the first of those with the same stamp."""
        stamps = self._stamps(where, samples)
        order = np.argsort(stamps, kind="stable")
        first = np.append(True, np.diff(stamps[order]) > 0)
        time = (stamps[order][first] - epoch) / NANO
        figures: dict[str, float | int | str] = {
            "role": ".".join(where),
            "samples": len(samples),
            "latency_s": self._latency(where),
            "out_of_order": int((np.diff(stamps) < 0).sum()),
            "repeated_stamps": int((~first).sum()),
            "missing": int(np.isnan(samples.numbers).all(axis=1).sum()),
        }
        if len(time) > 1:
            figures |= {"median_step_s": float(np.median(np.diff(time))), "largest_gap_s": float(np.diff(time).max())}
        self.steps.add(samples.topic, samples.kind, **figures)
        return Clocked(time, samples.numbers[order][first])


def is_static(topic: str) -> bool:
    """Whether its transforms hold for the whole recording, whenever they were sent."""
    return topic.rpartition("/")[2] == "tf_static"


def _frame(name: str | None) -> str:
    return (name or "").lstrip("/")
