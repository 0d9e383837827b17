"""`cart_limits` of `PROBLEM.yaml` and `study.yaml`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel

from ..limits import CartLimit, PushedCart
from .problem_schema import CART_LIMITS, CartLimitsEntry
from .refusing import Refuse


def cart_limits_of(
    entry: CartLimitsEntry, pushed_by: tuple[CartModel, Sequence[Arm]], where: list[str | int], refuse: Refuse
) -> tuple[CartLimit, ...]:
    """The limits that stand at a place of a document, for a cart and its arms."""
    limits = {key: partial(CART_LIMITS[key], **dict(values)) for key, values in entry if values is not None}
    return limits_for(limits, pushed_by, lambda key, why: refuse([*where, key], why))


def limits_for(
    limits: Mapping[str, Callable[[], CartLimit]],
    pushed_by: tuple[CartModel, Sequence[Arm]],
    refuse: Callable[[str, str], UsageError],
) -> tuple[CartLimit, ...]:
    """Limits that a cart and its arms can have; one that they can't is refused by its key."""
    found, (cart, arms) = [], pushed_by
    pushed = PushedCart(cart, None, arms)
    for key, make in limits.items():
        try:
            found.append(make())
            found[-1].rows(pushed)
        except UsageError as error:
            raise refuse(key, str(error)) from error
    return tuple(found)
