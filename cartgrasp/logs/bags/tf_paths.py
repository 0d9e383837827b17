"""Which transforms of a bag make up those that a topic map asks for: the very one where it is there, else a chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..mapped.timed_samples import MapPlace
from .bag import Bag
from .messages import TF_TYPES
from .topic_map import TopicMapFile
from .topic_samples import Key, links_in
from .transform_tree import BadTreeError, Link, NoPathError, TransformTree, arrow, usual, with_static


@dataclass
class TfPaths:
    """`lost` holds what was left out where the bag is salvaged."""

    bag: Bag
    map_file: TopicMapFile
    is_salvage: bool
    lost: list[str] = field(default_factory=list)

    def find(self, asked: Mapping[MapPlace, Key]) -> dict[MapPlace, list[Link]]:
        topics = {near for topic, _ in asked.values() for near in self._near(topic)}
        counts = links_in(self.bag, topics, set(asked.values())) if asked else {}
        paths = {where: [Link(k)] if k in counts else self._chain(where, k, counts) for where, k in asked.items()}
        pose = ("pose",)
        if pose in paths and all(link.is_static for link in paths[pose]):
            ends = " and ".join(asked[pose][1])
            raise self.map_file.refuse(pose, f"nothing moves between {ends}: {paths[pose][0].name} is static")
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
            self.lost += [
                f"{t} {arrow(f)}: {n} transforms; most others are {link.name}" for (t, f), n in others.items()
            ]
        return path
