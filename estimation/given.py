"""What an estimator is given is checked once, when it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import NoneType

from cartgrasp.checks import angle, check_kind, listed
from cartgrasp.model import CartModel

from .noise import FilterNoise
from .prior import Prior

Given = tuple[CartModel, Sequence[str] | None, FilterNoise, Prior, Mapping[str, float]]
"""Cart, arms, noise, prior and yaws."""


def given(
    cart: CartModel,
    arms: Sequence[str] | None,
    noise: FilterNoise | None,
    prior: Prior | None,
    yaws: Mapping[str, float] | None,
) -> Given:
    """With what is usual in the place of None."""
    check_kind("filter: cart", cart, CartModel, 'load it first: load_cart("cart.yaml")')
    if arms is not None:
        arms = listed("filter: arms", arms, str, 'write their names: arms=["left", "right"]')
    check_kind("filter: noise", noise, (FilterNoise, NoneType), "write FilterNoise(force=3.0)")
    check_kind("filter: prior", prior, (Prior, NoneType), "write Prior(mass=0.4)")
    check_kind("filter: yaws", yaws, (Mapping, NoneType), 'write yaws={"left": 0.0}')
    by_arm = {arm: angle(f"filter: yaws: {arm}", yaw) for arm, yaw in (yaws or {}).items()}
    return cart, arms, noise or FilterNoise(), prior or Prior(), by_arm
