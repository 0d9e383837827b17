"""The constants of the discrepancy engine, in three groups, and the values that an ablation gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
from typing import Any

import numpy as np

ROOT = "estimation"
FOLDERS = ("weak_form", "discrepancy")


class Group(Enum):
    DECIDES = "a"
    """Which names are told, or what verdict."""
    ASSUMES = "b"
    """How wrong models and sensors are, and what is believed beforehand: it enters likelihoods."""
    WORKS_OUT = "c"
    """Numerics, grids, effort, the refusal of logs that can't be read, words: no verdict depends on it but by
    resolution."""
    RULES = "r"
    """Whole rules: functions (`rules.py`)."""


@dataclass(frozen=True)
class Constant:
    """Of a module of `estimation`; `NAME[key]` is a number in a table. `off` switches its rule off (None: nothing
    does, or it is no rule). `is_diagnosed` is false where `identify` alone reads it, so that no diagnosis changes.
    """

    module: str
    name: str
    group: Group
    off: Any
    why: str
    is_diagnosed: bool = True

    @property
    def attribute(self) -> str:
        """Of its module."""
        return self.name.partition("[")[0]

    @property
    def entry(self) -> str:
        """Of a table; empty where it is none's."""
        return self.name.partition("[")[2].removesuffix("]")

    @property
    def full_name(self) -> str:
        """Without the folder: no two files of the folders have one name."""
        return f"{self.module.rpartition('.')[2]}.{self.name}"

    @property
    def value(self) -> Any:
        """As it is now."""
        found = getattr(import_module(f"{ROOT}.{self.module}"), self.attribute)
        return found[self.entry] if self.entry else found

    def moved(self, move: str) -> Any:
        """Its value `off`, or times a factor that a move says; None where there is no such value."""
        return self.off if move == OFF else times(self.value, float(move))


OFF = "off"
MOVES = (OFF, "0.7", "1.3")


def times(value: Any, factor: float) -> Any:
    """A number, or all of a tuple or an array, times a factor; integers rounded, and moved by one at least. None of
    what is no number."""
    if isinstance(value, bool | str | Mapping):
        return None
    if isinstance(value, int):
        step = round(value * factor) - value
        return value + (step or (1 if factor > 1 else -1))
    if isinstance(value, float):
        return value * factor
    if isinstance(value, np.ndarray):
        return value * factor
    if isinstance(value, tuple) and value:
        moved = tuple(times(one, factor) for one in value)
        return None if None in moved else moved
    return None
