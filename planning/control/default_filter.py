"""The one place where planning knows of estimation: the filter of a controller that is given none.

It is imported when such a controller is made, and known by its role alone; `tests/test_architecture.py` allows this
arrow and no other.
"""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp.arms import Arm
from cartgrasp.model import CartModel
from cartgrasp.roles import Estimator


def default_filter(cart: CartModel, arms: Sequence[Arm]) -> Estimator:
    from estimation import CartFilter

    return CartFilter(cart, [arm.name for arm in arms], yaws={arm.name: arm.yaw for arm in arms})
