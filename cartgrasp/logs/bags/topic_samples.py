"""The samples of a bag's topics as arrays, in the order in which they came."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...frames import Array
from ..mapped.planar_pose import QUATERNION_NORM_TOLERANCE
from ..mapped.timed_samples import MAX_MEASUREMENT
from .bag import SALVAGE_HINT, Bag, Message
from .messages import WRENCH_TYPE, BadMessageError, Sample, decode

Frames = tuple[str, str]
Key = tuple[str, Frames]
ALL_FRAMES: Frames = ("", "")
MAX_STAMP_NS = 2**62


@dataclass(frozen=True)
class TopicSamples:
    """Message numbers, header stamps and times of receipt in ns, each (n,), and numbers (n, k); `kind`: their type.
    `frames` (n,) are places in `names`: the frame in which, and that of which, each sample is."""

    topic: str
    kind: str
    message: NDArray[np.int64]
    stamp: NDArray[np.int64]
    received: NDArray[np.int64]
    numbers: Array
    frames: NDArray[np.int64]
    names: tuple[Frames, ...]

    def __len__(self) -> int:
        return len(self.stamp)

    def only(self, rows: NDArray[np.bool_]) -> TopicSamples:
        columns = ("message", "stamp", "received", "numbers", "frames")
        return replace(self, **{name: getattr(self, name)[rows] for name in columns})

    def wrong(self) -> tuple[NDArray[np.bool_], str]:
        """Samples that are no measurements, and why the first is none; NaN is a missing one."""
        too_large = (np.abs(self.numbers) > MAX_MEASUREMENT).any(axis=1)
        with np.errstate(over="ignore"):
            norm = np.ones(len(self)) if self.kind == WRENCH_TYPE else np.linalg.norm(self.numbers[:, 3:7], axis=1)
        odd = np.abs(norm - 1) > QUATERNION_NORM_TOLERANCE
        if too_large.any() and not odd[: int(np.argmax(too_large))].any():
            row = self.numbers[int(np.argmax(too_large))]
            return too_large | odd, f"holds {row[np.nanargmax(np.abs(row))]:g}, which is no measurement"
        why = f"its quaternion has the norm {norm[int(np.argmax(odd))]:.3g}, not 1" if odd.any() else ""
        return too_large | odd, why


@dataclass
class _GrowingSamples:
    kind: str
    rows: list[tuple[int, int, int, int]] = field(default_factory=list)
    numbers: list[tuple[float, ...]] = field(default_factory=list)
    names: dict[Frames, int] = field(default_factory=dict)

    def add(self, message: Message, sample: Sample, frames: Frames) -> None:
        place = self.names.setdefault(frames, len(self.names))
        self.rows.append((message.number, sample.stamp, message.received, place))
        self.numbers.append(sample.numbers)

    def done(self, topic: str) -> TopicSamples:
        rows = np.array(self.rows, dtype=np.int64)
        numbers = np.array(self.numbers)
        numbers[np.isnan(numbers)] = np.nan  # damaged bits may be one that warns wherever it is used
        return TopicSamples(
            topic, self.kind, rows[:, 0], rows[:, 1], rows[:, 2], numbers, rows[:, 3], tuple(self.names)
        )


def read_samples(bag: Bag, wanted: Mapping[str, set[Frames] | None], is_salvage: bool) -> dict[Key, TopicSamples]:
    """By topic and frames: of a TF topic the frames that are wanted, of other topics all, under ALL_FRAMES."""
    growing: dict[Key, _GrowingSamples] = {}
    broken: Counter[str] = Counter()
    for message in bag.messages(wanted):
        try:
            if not 0 <= message.received < MAX_STAMP_NS:
                raise BadMessageError(f"received at {message.received} ns, which is no time")
            samples = decode(message.raw, message.kind, bag.is_ros1)
        except BadMessageError as error:
            if not is_salvage:
                raise bag.refuse(f"message {message.number}: {error}; {SALVAGE_HINT}", message.topic) from error
            broken[message.topic] += 1
            continue
        frames = wanted[message.topic]
        for sample in samples:
            frame = frames_of(sample)
            if frames is None or frame in frames:
                key = (message.topic, ALL_FRAMES if frames is None else frame)
                if key not in growing:
                    growing[key] = _GrowingSamples(message.kind)
                growing[key].add(message, sample, frame)
    found = {}
    for key, parts in growing.items():
        samples_of = parts.done(key[0])
        wrong, why = samples_of.wrong()
        if wrong.any() and not is_salvage:
            number = samples_of.message[int(np.argmax(wrong))]
            raise bag.refuse(f"message {number}: {why}; {SALVAGE_HINT}", key[0])
        broken[key[0]] += int(wrong.sum())
        found[key] = samples_of.only(~wrong)
    bag.lost.extend(f"{topic}: {count} samples are damaged" for topic, count in broken.items() if count)
    return found


def links_in(bag: Bag, topics: Collection[str], enough: Collection[Key]) -> Counter[Key]:
    """How many transforms of which frames TF topics hold; no further than until `enough` were there."""
    found: Counter[Key] = Counter()
    missing = set(enough)
    for message in bag.messages(topics):
        try:
            samples = decode(message.raw, message.kind, bag.is_ros1)
        except BadMessageError:
            continue
        keys = [(message.topic, frames_of(sample)) for sample in samples]
        found.update(keys)
        missing.difference_update(keys)
        if not missing:
            break
    return found


def frames_of(sample: Sample) -> Frames:
    """Without the slashes that ROS 1 once wrote before them."""
    return sample.frame.lstrip("/"), sample.child.lstrip("/")
