"""The tree that transforms make of frames, each with one parent, and the path between two of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from difflib import get_close_matches
from typing import NamedTuple

from .topic_samples import Frames, Key

MAX_FRAMES_SHOWN = 10
BASE_FRAMES = ("base_link", "base_footprint")
"""Names that ROS gives to mobile bases (REP 105)."""


class Link(NamedTuple):
    """One transform on a path; `is_turned` where the path goes from its child to its parent."""

    key: Key
    is_turned: bool = False

    @property
    def topic(self) -> str:
        return self.key[0]

    @property
    def is_static(self) -> bool:
        return is_static(self.topic)

    @property
    def name(self) -> str:
        """A topic, and of TF the frames."""
        return f"{self.topic} {arrow(self.key[1])}" if any(self.key[1]) else self.topic


class BadTreeError(ValueError):
    """Transforms that are no tree."""


class NoPathError(ValueError):
    """Frames that are not there, or in trees of their own."""


class TransformTree:
    """`parents` holds the transforms that lead to each frame: one, where it is a tree."""

    def __init__(self, links: Iterable[Key]) -> None:
        self.parents: dict[str, list[Key]] = {}
        for key in sorted(links):
            self.parents.setdefault(key[1][1], []).append(key)

    @property
    def frames(self) -> list[str]:
        return sorted({frame for keys in self.parents.values() for _, frames in keys for frame in frames})

    def above(self, frame: str, until: Collection[str] = ()) -> list[Key]:
        """The transforms from a frame up to one of `until`, else to the one without parent."""
        walked: list[Key] = []
        seen = [frame]
        while seen[-1] not in until and seen[-1] in self.parents:
            key, *others = self.parents[seen[-1]]
            if others:
                said = " and ".join(f"{parent} in {topic}" for topic, (parent, _) in (key, *others))
                why = f"the frame {seen[-1]} has two parents, {said}"
                raise BadTreeError(f"{why}; `cartgrasp convert --salvage` keeps the one that came most often")
            seen.append(key[1][0])
            if seen[-1] in seen[:-1]:
                loop = seen[seen.index(seen[-1]) :]
                raise BadTreeError(f"the frames {arrow(reversed(loop))} are a loop")
            walked.append(key)
        return walked

    def path(self, frame: str, child: str) -> list[Link]:
        """The transforms whose product, in this order, is the pose of `child` in `frame`."""
        for name in (frame, child):
            if name not in self.frames:
                near = get_close_matches(name, self.frames, n=len(self.frames) or 1, cutoff=0.0)
                raise NoPathError(f"has no frame {name}, but {_some(near)}")
        if frame == child:
            raise NoPathError(f"can't say where {frame} is in itself; name two frames")
        down = self.above(child, {frame})
        below = [child, *(parent for _, (parent, _) in down)]
        up = self.above(frame, below)
        meeting = up[-1][1][0] if up else frame
        if meeting not in below:
            tops = " nor ".join(_top(*each) for each in ((frame, meeting), (child, below[-1])))
            why = f"holds no chain from {frame} to {child}: neither {tops} has a parent"
            raise NoPathError(f"{why}; its frames are {_some(self.frames)}")
        return [Link(key, True) for key in up] + [Link(key) for key in reversed(down[: below.index(meeting)])]


def usual(counts: Mapping[Key, int]) -> set[Key]:
    """For each child frame, the transform that came most often."""
    most: dict[str, Key] = {}
    for key in sorted(counts):
        child = key[1][1]
        if child not in most or counts[key] > counts[most[child]]:
            most[child] = key
    return set(most.values())


def likely_path(counts: Mapping[Key, int]) -> list[Link]:
    """The transforms that most likely tell a cart's pose: from the frame without parent down to the base, else to the
    frame that is sent most often; none where nothing moves."""
    moving = {key: count for key, count in counts.items() if not is_static(key[0])}
    if not moving:
        return []
    busiest = max(moving, key=lambda key: moving[key])
    tree = TransformTree(key for key in counts if key[0] in with_static(busiest[0]))
    bases = [frame for base in BASE_FRAMES for frame in tree.frames if frame.rpartition("/")[2] == base]
    try:
        path = [Link(key) for key in reversed(tree.above(bases[0] if bases else busiest[1][1]))]
    except BadTreeError:
        path = []
    return path if not all(link.is_static for link in path) else [Link(busiest)]


def frames_on(path: Iterable[Link]) -> list[str]:
    """The frames that a path goes through, in its order."""
    found: list[str] = []
    for link in path:
        ends: Frames = (link.key[1][1], link.key[1][0]) if link.is_turned else link.key[1]
        found += ends[len(found) > 0 :]
    return found


def arrow(frames: Iterable[str]) -> str:
    return " → ".join(frames)


def is_static(topic: str) -> bool:
    """Whether its transforms hold for the whole recording, whenever they were sent."""
    return topic.rpartition("/")[2] == "tf_static"


def with_static(topic: str) -> tuple[str, str]:
    """A TF topic and the one of static transforms beside it."""
    namespace, slash, _ = topic.rpartition("/")
    return topic, f"{namespace}{slash}tf_static"


def _top(frame: str, top: str) -> str:
    return top if top == frame else f"{top} (above {frame})"


def _some(names: list[str]) -> str:
    rest = f" and {len(names) - MAX_FRAMES_SHOWN} more" if len(names) > MAX_FRAMES_SHOWN else ""
    return (", ".join(names[:MAX_FRAMES_SHOWN]) or "none") + rest
