"""What a controller leaves when it is stopped, as a file to read and to go on from.

The cart is as it was last estimated, with each parameter's standard deviation, and moves as it did. Correlations of the
filter's belief, its recent samples and suspicions are not kept: a filter that goes on begins with these deviations.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from ruamel.yaml.comments import CommentedMap

from cartgrasp.cart_file import cart_from_document, cart_text
from cartgrasp.errors import UsageError
from cartgrasp.first_guess import FirstGuess
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion
from cartgrasp.writing import write_atomically
from cartgrasp.yaml_file import StrictModel, dump_yaml, parse_yaml, read_yaml, validate

from .hand import Hand, Phase, point_of

Coordinates = Annotated[list[float], Field(min_length=3, max_length=3)]
Components = Annotated[list[float], Field(min_length=6, max_length=6)]


class _HandEntry(StrictModel):
    point: Coordinates
    phase: Literal["holds", "unloads", "moves", "takes hold", "loads"] = "holds"
    share: Annotated[float, Field(ge=0, le=1)] = 1.0
    target: Coordinates | None = None
    taken: Annotated[float, Field(ge=0)] = 0.0
    wrench: Components

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        if self.target is None and self.phase in ("unloads", "moves"):
            raise ValueError(f"a hand that {self.phase} has no target; say where to")
        return self

    def hand(self) -> Hand:
        target = None if self.target is None else point_of(self.target)
        return Hand(point_of(self.point), Phase(self.phase), self.share, target, self.taken)


class _SavedEntry(StrictModel):
    time: float
    along: float | None = None
    pace: Annotated[float, Field(ge=0, le=1)] = 1.0
    stopped: bool = False
    pose: Coordinates | None = None
    velocity: list[float] | None = None
    cart: Any
    hands: Annotated[dict[str, _HandEntry], Field(min_length=1)]


@dataclass(frozen=True, eq=False)
class Saved:
    """At `time` (s), so far `along` the reference (s), at a `share` of its speed, or told to stop: the cart, and how
    sure its numbers are; the hands, and the wrenches (6,) in {a} that they gave; and how the cart moved, where that was
    known."""

    time: float
    along: float
    share: float
    is_stopped: bool
    cart: CartModel
    hands: Mapping[str, Hand]
    wrenches: Mapping[str, Array]
    motion: Motion | None = None

    def save(self, path: str | os.PathLike[str]) -> Path:
        hands = {name: _entry(hand, self.wrenches[name]) for name, hand in self.hands.items()}
        document: dict[str, Any] = {"time": self.time, "along": self.along, "pace": self.share}
        document |= {"stopped": True} if self.is_stopped else {}
        if self.motion is not None:
            document |= {"pose": self.motion.pose_sb.tolist(), "velocity": self.motion.velocity.tolist()}
        document |= {"cart": parse_yaml(cart_text(self.cart), "cart"), "hands": hands}
        return write_atomically(path, dump_yaml(CommentedMap(document)))


def read_saved(path: str | os.PathLike[str]) -> Saved:
    """A mistake is refused as `file:line:column: key: why`."""
    document = read_yaml(path)
    entry = validate(_SavedEntry, document, str(path))
    cart = cart_from_document(document["cart"], str(path), ["cart"])
    n_free = cart.constraints.n_free
    if (entry.pose is None) != (entry.velocity is None) or len(entry.velocity or [0.0] * n_free) != n_free:
        raise UsageError(
            f"{path}: velocity: {entry.velocity} beside pose {entry.pose}; give both, or neither: {n_free} numbers"
        )
    moves = entry.pose is not None
    return Saved(
        time=entry.time,
        along=entry.time if entry.along is None else entry.along,
        share=entry.pace,
        is_stopped=entry.stopped,
        cart=cart,
        motion=Motion(np.array(entry.pose), np.array(entry.velocity)) if moves else None,
        hands={name: one.hand() for name, one in entry.hands.items()},
        wrenches={name: np.array(one.wrench) for name, one in entry.hands.items()},
    )


def as_first_guess(estimate: Estimate) -> CartModel:
    """The cart as now estimated, with how sure that is: what does not vary is known."""
    told, before = estimate.parameters, estimate.structure.first_guess
    std = tuple((name, float(one.std)) for name, one in told.items() if one.std > 0)
    known = (*before.known, *(name for name, one in told.items() if not one.std > 0))
    sure = FirstGuess(tuple(pair for pair in std if pair[0] not in before.known), tuple(dict.fromkeys(known)))
    return replace(estimate.cart(), first_guess=sure)


def _entry(hand: Hand, wrench: Array) -> dict[str, Any]:
    entry: dict[str, Any] = {"point": list(hand.point), "wrench": np.asarray(wrench).tolist()}
    if hand.phase is not Phase.HOLDS:
        target = None if hand.target is None else list(hand.target)
        entry |= {"phase": hand.phase.value, "share": hand.share, "target": target, "taken": hand.taken}
    return entry
