"""What a controller is given and asks for, checked: each mistake in one sentence, with its cure."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.checks import check_kind, check_known, shown
from cartgrasp.contacts import points_of
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.roles import ContactChoice, Estimator, Planner, ReferencePath


def check_for_cart(reference: ReferencePath, cart: CartModel) -> None:
    """A path that says of which cart it is, is of one that rolls as this does."""
    constraints = getattr(reference, "constraints", cart.constraints)
    if constraints.n_free != cart.constraints.n_free:
        raise UsageError(
            f"controller: reference: it is of a cart that rolls otherwise than {cart.name}: {constraints} and "
            f"{cart.constraints}; write PathReference(…, constraints=cart.constraints)"
        )


def check_learns_from(estimator: Estimator, names: frozenset[str], cart: CartModel) -> None:
    """Its arms, where it says which these are, are those that push; so is its cart, which is pushed."""
    if isinstance(estimator, type):
        raise UsageError(f"controller: estimator: {estimator.__name__} is a class; write {estimator.__name__}(cart)")
    learned = getattr(estimator, "cart", cart)
    if not np.array_equal(learned.basis_b, cart.basis_b):
        raise UsageError(
            f"controller: estimator: its cart, {learned.name}, rolls otherwise than {cart.name}: {learned.constraints} "
            f"and {cart.constraints}; make it for the same cart"
        )
    heard = getattr(estimator, "arms", None)
    if heard is not None and set(heard) != names:
        raise UsageError(
            f"controller: estimator: it adds up the wrenches of {', '.join(sorted(heard))}, and the arms are "
            f"{', '.join(sorted(names))}; name them alike"
        )


def check_period(planner: Planner, period: float) -> None:
    """A planner that counts rates of change and held wrenches by its period is called as often."""
    counted = getattr(planner, "period", period)
    if not math.isclose(counted, period):
        raise UsageError(
            f"controller: period: {period:g} s, and the planner's is {counted:g} s, by which rates of change count; "
            "give both the same"
        )


def made_estimator(maker: Callable[[CartModel], Any], cart: CartModel) -> Estimator:
    """What a maker makes of a cart."""
    made = maker(cart)
    if not callable(getattr(made, "update", None)):
        raise UsageError(f"controller: estimator: what it makes of a cart, {shown(made)}, is no estimator")
    return made  # type: ignore[no-any-return]


def check_chosen(chosen: ContactChoice, names: Collection[str]) -> None:
    """What a source of contacts says, at every tick."""
    if not isinstance(chosen, ContactChoice):
        raise UsageError(f"controller: contacts: {shown(chosen)} is none; return ContactChoice({{arm: (3,)}}, why)")
    if chosen.contacts.keys() != names:
        check_known("controller: contacts", chosen.contacts, names)
        raise _not_all("contacts", chosen.contacts, names)
    for name, point in chosen.contacts.items():
        if len(point) != 3 or not all(map(math.isfinite, point)):
            points_of(f"controller: contacts: {name}", [point])


def checked_contacts(held: Mapping[str, ArrayLike] | None, arms: Sequence[Arm]) -> dict[str, Array]:
    """Contacts of all arms, or of none."""
    if held is None:
        return {}
    check_kind("controller: held", held, Mapping, "write {'left': (-0.25, 0.2, 1.0)}")
    names = [arm.name for arm in arms]
    if set(held) != set(names):
        raise _not_all("held", held, names)
    return {name: np.array(points_of(f"controller: held: {name}", [held[name]])[0]) for name in names}


def _not_all(what: str, given: Iterable[str], names: Iterable[str]) -> UsageError:
    named = ", ".join(sorted(names))
    return UsageError(f"controller: {what}: {', '.join(given)} are not the arms {named}; name all of them")
