"""`PROBLEM.yaml` of `cartgrasp plan`: strict to read, exact about places."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field
from ruamel.yaml.comments import CommentedMap

from cartgrasp.arms import EXACT, Arm, Friction
from cartgrasp.cart_file import cart_from_document, load_cart
from cartgrasp.contacts import ContactSet, Segment
from cartgrasp.errors import FileError, UsageError
from cartgrasp.model import CartModel
from cartgrasp.yaml_file import StrictModel, file_error, read_yaml, validate

NO_LIMIT = (float("inf"),) * 3
WEIGHTS = (1.0, 1.0, 1.0, 10.0, 10.0, 10.0)


def _limit(value: float) -> float:
    if not abs(value) < float("inf"):
        raise ValueError(f"{value} is not a finite number; leave the key out for no limit")
    return _not_negative(value)


def _not_negative(value: float) -> float:
    if value < 0:
        raise ValueError(f"{value:g} is negative; a number >= 0 is needed")
    return value


NotNegative = Annotated[float, AfterValidator(_not_negative)]
LimitValue = Annotated[float, Field(allow_inf_nan=True), AfterValidator(_limit)]
Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
LimitTriple = Annotated[list[LimitValue], Field(min_length=3, max_length=3)]


class _LimitsEntry(StrictModel):
    force: LimitTriple | None = None
    moment: LimitTriple | None = None


class _FrictionEntry(StrictModel):
    mu: NotNegative
    sides: Any = 4


class _ArmEntry(StrictModel):
    name: str
    contacts: list[Triple] = Field(default_factory=list)
    segment: Annotated[list[Triple], Field(min_length=2, max_length=2)] | None = None
    yaw: float = 0.0
    limits: _LimitsEntry = _LimitsEntry()
    friction: _FrictionEntry | None = None
    weights: list[NotNegative] = Field(default_factory=lambda: [*WEIGHTS], min_length=6, max_length=6)


class _ProblemEntry(StrictModel):
    cart: Any
    wrench: Triple
    arms: list[_ArmEntry] = Field(min_length=1)
    min_hand_distance: NotNegative = 0.0


@dataclass(frozen=True)
class Problem:
    """A cart, its arms, and the wrench (fx, fy, tau) wanted on the cart in {b}."""

    cart: CartModel
    arms: tuple[Arm, ...]
    wrench: tuple[float, float, float]
    min_hand_distance: float


def read_problem(path: str | os.PathLike[str]) -> Problem:
    """A mistake is refused as `file:line:column: key: why`."""
    document, name = read_yaml(path), str(path)
    entry = validate(_ProblemEntry, document, name)

    def refuse(location: list[str | int], why: str) -> FileError:
        return file_error(document, name, location, why)

    arms: list[Arm] = []
    for i, arm in enumerate(entry.arms):
        if arm.name in [other.name for other in arms]:
            raise refuse(["arms", i, "name"], f"{arm.name} stands twice; names must differ")
        arms.append(_arm(arm, ["arms", i], refuse))
    fx, fy, tau = entry.wrench
    cart = _cart(entry.cart, document, Path(path), refuse)
    return Problem(cart, tuple(arms), (fx, fy, tau), entry.min_hand_distance)


Refuse = Callable[[list[str | int], str], FileError]


def _cart(entry: Any, document: CommentedMap, path: Path, refuse: Refuse) -> CartModel:
    if isinstance(entry, str):
        return load_cart(path.parent / entry)
    if isinstance(entry, dict):
        return cart_from_document(document["cart"], str(path), ["cart"])
    raise refuse(["cart"], f"{entry!r} is neither the path of a cart file nor a mapping")


def _arm(entry: _ArmEntry, where: list[str | int], refuse: Refuse) -> Arm:
    if not entry.contacts and entry.segment is None:
        raise refuse([*where, "contacts"], "an arm needs `contacts`, a `segment`, or both; add one")
    points = tuple((x, y, z) for x, y, z in entry.contacts)
    segments: tuple[Segment, ...] = ()
    if entry.segment is not None:
        (x, y, z), (x2, y2, z2) = entry.segment
        segments = (Segment((x, y, z), (x2, y2, z2)),)
    friction = _friction(entry.friction, [*where, "friction", "sides"], refuse)
    try:
        return Arm(
            entry.name,
            ContactSet(points, segments),
            yaw=entry.yaw,
            force_limit=entry.limits.force or NO_LIMIT,
            moment_limit=entry.limits.moment or NO_LIMIT,
            friction=friction,
            weights=entry.weights,
        )
    except UsageError as error:
        raise refuse([*where, "name"], str(error)) from error


def _friction(entry: _FrictionEntry | None, where: list[str | int], refuse: Refuse) -> Friction | None:
    if entry is None:
        return None
    sides = entry.sides
    if sides != EXACT and not (isinstance(sides, int) and not isinstance(sides, bool) and 3 <= sides <= 256):
        raise refuse(where, f"{sides!r} is neither a whole number of 3 to 256 nor `exact`")
    return Friction(entry.mu, sides)
