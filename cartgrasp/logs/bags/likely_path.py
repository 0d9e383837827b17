"""The transforms that most likely tell a cart's pose, by the names that ROS gives to mobile bases (REP 105)."""

from __future__ import annotations

from collections.abc import Mapping

from .topic_samples import Key
from .transform_tree import BadTreeError, Link, TransformTree, is_static, with_static

BASE_FRAMES = ("base_link", "base_footprint")


def likely_path(counts: Mapping[Key, int]) -> list[Link]:
    """From the frame without parent down to the base, else to the frame that is sent most often; none where nothing
    moves."""
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
