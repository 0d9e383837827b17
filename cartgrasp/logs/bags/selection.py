"""The samples that a topic map asks of a bag, each on the log's time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...yaml_file import did_you_mean
from ..mapped.planar_pose import MAX_TILT, planar, tilt
from ..mapped.processing_steps import ProcessingSteps
from ..mapped.reading import MappedSamples
from ..mapped.timed_samples import MapPlace, TimedSamples, step_figures
from .bag import Bag
from .faults import far_stamps, other_frames, other_values, without
from .messages import NS_PER_S, ODOMETRY_TYPE, POSE_TYPE, TF_TYPES, WRENCH_TYPE
from .topic_map import ContactEntry, TopicMapFile
from .topic_samples import ALL_FRAMES, Frames, Key, TopicSamples, links_in, read_samples
from .transform_chain import common_span, composed
from .transform_tree import BadTreeError, Link, NoPathError, TransformTree, arrow, is_static, usual, with_static


@dataclass
class Selection:
    """By the place in the map: ("pose",), ("arms", NAME) and ("arms", NAME, "contact"). `left_out` is what of TF fits
    into no tree, where the bag is salvaged."""

    bag: Bag
    map_file: TopicMapFile
    is_salvage: bool
    steps: ProcessingSteps = field(default_factory=ProcessingSteps)
    left_out: list[str] = field(default_factory=list)

    def read(self) -> MappedSamples:
        keys = dict(self._keys())
        self._check_topics(keys)
        paths = self._paths(keys)
        links = {link.key: link for path in paths.values() for link in path}
        wanted: dict[str, set[Frames] | None] = {}
        for topic, frames in links:
            wanted[topic] = None if frames == ALL_FRAMES else (wanted.get(topic) or set()) | {frames}
        found = read_samples(self.bag, wanted, self.is_salvage)
        self.bag.lost.extend(self.left_out)
        for key, link in links.items():
            if key not in found or not len(found[key]):
                why = "has no messages" + (" that can be read" if self.is_salvage else "")
                raise self.bag.refuse(why, link.name)
            found[key] = self._of_one_run(found[key])
        epoch = self.map_file.map.epoch
        if epoch is None:
            moving = [(w, k.key) for w, path in paths.items() if len(w) < 3 for k in path if not k.is_static]
            epoch = max(int(self._stamps(where, found[key]).min()) for where, key in moving)
        self.steps.add("log", "its zero", epoch_ns=epoch, stamps=self.map_file.map.stamps)
        samples = {where: self._along(where, path, found, epoch) for where, path in paths.items()}
        pose = samples["pose",]
        off = tilt(pose.numbers)
        if off > MAX_TILT:
            why = f"its frame's z is up to {np.degrees(off):.0f}° off the vertical; name a frame whose z points up"
            raise self.map_file.refuse(("pose", "topic"), why)
        samples |= self._planar(pose)
        return MappedSamples(str(self.bag.path), self.map_file, samples, self.steps, off, self.bag.lost)

    def _planar(self, pose: TimedSamples) -> dict[MapPlace, TimedSamples]:
        """Poses (n, 3) of the tracked frame, and the twist (n, 3) of it in itself if the map wants that."""
        found: dict[MapPlace, TimedSamples] = {("pose",): TimedSamples(pose.time, planar(pose.numbers))}
        if self.map_file.map.pose.velocity == "twist":
            found["velocity",] = TimedSamples(pose.time, pose.numbers[:, [7, 8, 12]])
        return found

    def _paths(self, keys: Mapping[MapPlace, Key]) -> dict[MapPlace, list[Link]]:
        """What makes up each that is asked for: a topic, the very transform where it is there, else a chain."""
        asked = {where: key for where, key in keys.items() if key[1] != ALL_FRAMES}
        topics = {near for topic, _ in asked.values() for near in self._near(topic)}
        counts = links_in(self.bag, topics, set(asked.values())) if asked else {}
        paths = {where: [Link(key)] for where, key in keys.items()}
        for where, key in asked.items():
            if key not in counts:
                paths[where] = self._chain(where, key, counts)
            if where == ("pose",) and all(link.is_static for link in paths[where]):
                why = f"nothing moves between {' and '.join(key[1])}: {paths[where][0].name} is static"
                raise self.map_file.refuse(where, why)
        return paths

    def _near(self, topic: str) -> list[str]:
        """The TF topics whose transforms belong to one tree."""
        return [near for near in dict.fromkeys(with_static(topic)) if self.bag.kinds.get(near) in TF_TYPES]

    def _chain(self, where: MapPlace, key: Key, counts: Mapping[Key, int]) -> list[Link]:
        topic, (frame, child) = key
        near = self._near(topic)
        tree = {key: count for key, count in counts.items() if key[0] in near}
        try:
            path = TransformTree(usual(tree) if self.is_salvage else tree).path(frame, child)
        except BadTreeError as error:
            raise self.bag.refuse(str(error), topic) from error
        except NoPathError as error:
            raise self.map_file.refuse(where, f"{' with '.join(near)} of {self.bag.path} {error}") from error
        for link in path:
            others = {k: n for k, n in tree.items() if k[1][1] == link.key[1][1] and k != link.key}
            self.left_out += [
                f"{t} {arrow(f)}: {n} transforms; most others are {link.name}" for (t, f), n in others.items()
            ]
        return path

    def _along(self, where: MapPlace, path: list[Link], found: dict[Key, TopicSamples], epoch: int) -> TimedSamples:
        """What is asked for itself, or composed of what is there."""
        if path == [Link(path[0].key)]:
            return self._clocked(where, path[0].topic, found[path[0].key], epoch)
        samples = [self._clocked(where, link.name, found[link.key], epoch) for link in path]
        if moving := [(link, one) for link, one in zip(path, samples, strict=True) if not one.is_static]:
            self._check_moving(where, moving)
        return composed(".".join(where), path, samples, self.map_file.map.max_gap, self.steps)

    def _check_moving(self, where: MapPlace, moving: list[tuple[Link, TimedSamples]]) -> None:
        for link, samples in moving:
            if len(samples.time) < 2:
                raise self.bag.refuse("was sent once; one that holds for ever is one of tf_static", link.name)
            step = samples.usual_step
            if step > self.map_file.map.max_gap:
                why = f"{link.name} has a transform every {step:.3g} s, so all would be gaps; state a longer one"
                raise self.map_file.refuse(("max_gap",), why)
        start, end = common_span([samples for _, samples in moving])
        if start > end:
            said = ", ".join(f"{link.name} from {c.span()[0]:.3f} to {c.span()[1]:.3f} s" for link, c in moving)
            raise self.bag.refuse(f"the transforms of {'.'.join(where)} have no time in common: {said}")

    def _keys(self) -> Iterator[tuple[MapPlace, Key]]:
        map_ = self.map_file.map
        pose = map_.pose
        yield ("pose",), (pose.topic, (_frame(pose.frame), _frame(pose.child)))
        for name, arm in map_.arms.items():
            yield ("arms", name), (arm.topic, ALL_FRAMES)
            if isinstance(arm.contact, ContactEntry):
                contact = arm.contact
                yield ("arms", name, "contact"), (contact.topic, (_frame(contact.frame), _frame(contact.child)))

    def _check_topics(self, keys: dict[MapPlace, Key]) -> None:
        if not self.bag.kinds:
            raise self.bag.refuse("has no topic" + (" that can be read" if self.is_salvage else ""))
        for where, (topic, _) in keys.items():
            place = (*where, "topic")
            if topic not in self.bag.kinds:
                known = did_you_mean(topic, self.bag.kinds)
                raise self.map_file.refuse(place, f"{self.bag.path} has no topic {topic}{known}")
            kind = self.bag.kinds[topic]
            of_role = {1: (ODOMETRY_TYPE, POSE_TYPE, *TF_TYPES), 2: (WRENCH_TYPE,), 3: TF_TYPES}[len(where)]
            if kind not in of_role:
                raise self.map_file.refuse(place, f"{topic} holds {kind}; needed is {' or '.join(of_role)}")
        pose = self.map_file.map.pose
        is_tf = self.bag.kinds[pose.topic] in TF_TYPES
        for key, value in (("frame", pose.frame), ("child", pose.child)):
            if is_tf and value is None:
                raise self.map_file.refuse(("pose",), f"{key} is missing; a TF topic holds many transforms")
            if not is_tf and value is not None:
                raise self.map_file.refuse(("pose", key), f"is for TF topics; {pose.topic} has one pose")
        if pose.velocity == "twist" and self.bag.kinds[pose.topic] != ODOMETRY_TYPE:
            raise self.map_file.refuse(("pose", "velocity"), f"{pose.topic} holds no twist; use spline or none")

    def _of_one_run(self, samples: TopicSamples) -> TopicSamples:
        samples = without(samples, other_frames(samples), self.bag, self.is_salvage)
        if is_static(samples.topic):
            return without(samples, other_values(samples), self.bag, self.is_salvage)
        if self.map_file.map.stamps == "receive":
            return samples
        return without(samples, far_stamps(samples, self.map_file.map.max_gap), self.bag, self.is_salvage)

    def _stamps(self, where: MapPlace, samples: TopicSamples) -> NDArray[np.int64]:
        """ns, with the topic's latency taken off."""
        late = round(self._latency(where) * NS_PER_S)
        if self.map_file.map.stamps == "receive" or is_static(samples.topic):
            return samples.received - late
        if not samples.stamp.any() and samples.received.any():
            raise self.map_file.refuse(("stamps",), f"the headers of {samples.topic} have no stamps; use receive")
        return samples.stamp - late

    def _latency(self, where: MapPlace) -> float:
        map_ = self.map_file.map
        if len(where) == 2:
            return map_.arms[where[1]].latency
        return map_.pose.latency if where == ("pose",) else 0.0

    def _clocked(self, where: MapPlace, of: str, samples: TopicSamples, epoch: int) -> TimedSamples:
        """Sorted by time, the first of those with the same stamp."""
        stamps = self._stamps(where, samples)
        order = np.argsort(stamps, kind="stable")
        first = np.append(True, np.diff(stamps[order]) > 0)
        time = (stamps[order][first] - epoch) / NS_PER_S
        figures: dict[str, float | int | str] = {
            "role": ".".join(where),
            "samples": len(samples),
            "latency_s": self._latency(where),
            "out_of_order": int((np.diff(stamps) < 0).sum()),
            "repeated_stamps": int((~first).sum()),
            "missing": int(np.isnan(samples.numbers).all(axis=1).sum()),
        }
        self.steps.add(of, samples.kind, **figures, **step_figures(time))
        return TimedSamples(time, samples.numbers[order][first], is_static(samples.topic))


def _frame(name: str | None) -> str:
    return (name or "").lstrip("/")
