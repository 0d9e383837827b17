"""What a bag holds, and a topic map proposed for it; what only its owner can know is left for them to fill in."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import printable
from ...frames import Array
from ..mapped.planar_pose import planar
from ..mapped.timed_samples import MAX_MEASUREMENT
from .bag import Bag
from .messages import (
    DECODERS,
    NS_PER_S,
    ODOMETRY_TYPE,
    POSE_TYPE,
    TF_TYPES,
    WRENCH_TYPE,
    BadMessageError,
    Sample,
    decode,
)
from .topic_samples import frames_of
from .transform_tree import arrow, frames_on, likely_path

MAX_NOISE_SAMPLES = 20_000
"""Samples of a topic that its noise is read off."""
MIN_NOISE_SAMPLES = 20


@dataclass
class TopicContent:
    """A topic, or one transform of a TF topic: its messages by time of receipt, ns; and the first of its samples."""

    topic: str
    kind: str
    frames: tuple[str, str] | None = None
    count: int = 0
    first: int = 0
    last: int = 0
    is_stamped: bool = False
    numbers: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, received: int, sample: Sample | None) -> None:
        self.first = min(self.first, received) if self.count else received
        self.last = max(self.last, received) if self.count else received
        self.count += 1
        if sample is not None:
            self.is_stamped |= sample.stamp != 0
            if len(self.numbers) < MAX_NOISE_SAMPLES:
                self.numbers.append(sample.numbers)

    @property
    def name(self) -> str:
        return self.topic if self.frames is None else f"{self.topic} {self.frames[0]} → {self.frames[1]}"

    @property
    def rate(self) -> float | None:
        """Hz."""
        return (self.count - 1) / (self.last - self.first) * NS_PER_S if self.last > self.first else None

    def as_dict(self, start: int) -> dict[str, Any]:
        """First and last in s from the bag's start."""
        frames = {} if self.frames is None else {"frame": self.frames[0], "child": self.frames[1]}
        times = {"rate": self.rate, "first": (self.first - start) / NS_PER_S, "last": (self.last - start) / NS_PER_S}
        return {"topic": self.topic, "type": self.kind, **frames, "count": self.count, **times}


def contents_of(bag: Bag) -> list[TopicContent]:
    """Every topic by name; of TF topics every transform too. Messages that can't be decoded are only counted."""
    found: dict[tuple[str, tuple[str, str] | None], TopicContent] = {
        (topic, None): TopicContent(topic, kind) for topic, kind in bag.kinds.items()
    }
    for message in bag.messages():
        samples: Sequence[Sample] = ()
        if message.kind in DECODERS:
            with suppress(BadMessageError):
                samples = decode(message.raw, message.kind, bag.is_ros1)
        is_tf = message.kind in TF_TYPES
        found[message.topic, None].add(message.received, samples[0] if samples and not is_tf else None)
        for sample in samples if is_tf else ():
            frames = frames_of(sample)
            key = (message.topic, frames)
            if key not in found:
                found[key] = TopicContent(message.topic, message.kind, frames)
            found[key].add(message.received, sample)
    return [found[key] for key in sorted(found, key=lambda key: (key[0], key[1] or ("", "")))]


def proposed_map(contents: Sequence[TopicContent], name: str) -> str | None:
    """A `topics.yaml`, or None where no topic holds a pose."""
    full = [c for c in contents if c.count]
    wrenches = [c for c in full if c.kind == WRENCH_TYPE]
    poses = [c for c in full if c.kind == ODOMETRY_TYPE] or [c for c in full if c.kind == POSE_TYPE]
    transforms = {(c.topic, c.frames): c for c in full if c.frames is not None}
    path = [] if poses else likely_path({key: c.count for key, c in transforms.items()})
    poses = poses or [transforms[link.key] for link in path if not link.is_static]
    if not poses:
        return None
    pose = max(poses, key=lambda c: c.count)
    slowest = min([pose, *wrenches], key=lambda c: c.rate or 0.0)
    names = _arm_names([c.topic for c in wrenches])
    clock = "pose" if slowest is pose else names[slowest.topic]
    used = [*(poses if path else [pose]), *wrenches]
    stamps = "header" if all(c.is_stamped for c in used) else "receive"
    least = min(c.rate or 0.0 for c in used)
    gap = max(0.1, 5 / least) if least else 0.1
    lines = [
        f"# Which topics of {name} are a run. Fill in what is blank, and check the rest.",
        f"stamps: {stamps}           # or {'receive' if stamps == 'header' else 'header'}",
        f"clock: {clock}             # the topic whose stamps are the log's: the slowest; or a rate in Hz",
        f"max_gap: {gap:.3g}             # s; longer gaps are left out, never bridged",
        *_pose_lines(pose, frames_on(path)),
        "arms:" if wrenches else "arms: {}               # no topic holds a wrench: nobody touches the cart",
    ]
    for content in wrenches:
        lines += [
            f"  {_quoted(names[content.topic])}:",
            f"    topic: {_quoted(content.topic)}",
            "    contact:            # [x, y, z] of the contact point in the cart's frame {b}, m",
            "    force:              # on_cart: what the arm does to the cart; on_sensor: what the sensor feels",
            "    latency: 0.0        # s, taken off the stamps",
            "    sensor: {position: [0.0, 0.0, 0.0], rpy: [0.0, 0.0, 0.0]}   # its pose in {a}, m, rad",
            "    # tool: {mass: 0.8, com: [0.0, 0.0, 0.05]}   # between sensor and cart: kg; m in the sensor's frame",
            "    # tare: [0.0, 1.0]  # s from the log's zero: the hand off the cart, all still",
        ]
    return "\n".join(lines) + "\n"


def _pose_lines(pose: TopicContent, frames: Sequence[str]) -> list[str]:
    """`pose` moves fastest of the transforms between the frames, if it is one."""
    noise = _noise(pose)
    velocity = "twist" if pose.kind == ODOMETRY_TYPE else "none"
    lines = ["pose:", f"  topic: {_quoted(pose.topic)}"]
    if frames:
        lines += [f"  frame: {_quoted(frames[0])}", f"  child: {_quoted(frames[-1])}"]
    if len(frames) > 2:
        lines.append(f"  # composed along {printable(arrow(frames))}")
    lines += [
        "  latency: 0.0          # s, taken off the stamps",
        "  body: [0.0, 0.0, 0.0] # pose x, y, yaw of the cart's frame {b} in the frame that is tracked: m, rad",
        f"  velocity: {velocity:<12}  # twist (of an Odometry), none, or spline (estimators need none)",
    ]
    if noise is not None:
        said = f"{{position: {noise[0]:.2g}, heading: {noise[1]:.2g}}}"
        lines.append(f"  noise: {said}   # m, rad, one standard deviation: as its third differences say")
    return lines


def _noise(pose: TopicContent) -> tuple[float, float] | None:
    """Noise of position (m) and heading (rad); None where there are too few samples, or where one has no noise."""
    if len(pose.numbers) < MIN_NOISE_SAMPLES:
        return None
    numbers = np.array([numbers[:7] for numbers in pose.numbers])
    samples = planar(numbers[(np.abs(numbers) <= MAX_MEASUREMENT).all(axis=1)])
    if len(samples) < MIN_NOISE_SAMPLES:
        return None
    x, y, heading = (_noise_floor(samples[:, k]) for k in range(3))
    position = max(x, y)
    return (position, heading) if position > 0 and heading > 0 else None


def _noise_floor(channel: Array) -> float:
    """White noise of variance s² has third differences of variance 20 s²; the median is robust to jumps."""
    return float(1.4826 * np.median(np.abs(np.diff(channel, 3))) / 20**0.5)


def _arm_names(topics: Sequence[str]) -> dict[str, str]:
    """The part of each topic in which it differs from the others, without dots."""
    parts = [[p for p in topic.split("/") if p] for topic in topics]
    names = {}
    for topic, own in zip(topics, parts, strict=True):
        others = [set(p) for p in parts if p is not own]
        differing = [p for p in own if not all(p in other for other in others)] if others else own[:1]
        names[topic] = ("_".join(differing) or "arm").replace(".", "_")
    if len(set(names.values())) < len(names):
        names = {topic: topic.strip("/").replace("/", "_").replace(".", "_") or "arm" for topic in topics}
    return {topic: name if name != "pose" else "pose_arm" for topic, name in names.items()}


def _quoted(word: str) -> str:
    """The word as YAML takes it, whatever is in it."""
    is_plain = word.isascii() and word.replace("/", "").replace("_", "").isalnum() and not word[:1].isdigit()
    is_word = word.lower() in ("true", "false", "null", "yes", "no", "on", "off", "nan", "inf")
    return word if is_plain and not is_word else json.dumps(word)
