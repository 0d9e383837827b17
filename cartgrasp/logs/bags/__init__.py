"""ROS bags as run logs, and run logs as MCAP; no ROS is needed."""

from __future__ import annotations

from .bag import Bag
from .opening import map_of, map_path_of, open_bag, read_bag
from .topic_map import TopicMap, load_topic_map, topic_map_from_text
from .writing import write_mcap

__all__ = [
    "Bag",
    "TopicMap",
    "load_topic_map",
    "map_of",
    "map_path_of",
    "open_bag",
    "read_bag",
    "topic_map_from_text",
    "write_mcap",
]
