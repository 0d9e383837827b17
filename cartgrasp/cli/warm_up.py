"""`cartgrasp warm-up`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from threading import Thread
from typing import Any

from estimation import CartFilter, DisturbedFilter, RegressorEstimator
from planning import WrenchPlanner

from ..arms import Arm
from ..compile_notice import compiling, kernel_listener
from ..compiling import ENTRY_KERNELS
from ..inertia import Inertia
from ..model import CartModel
from ..wheels import Wheel
from .output import KernelProgressLines, print_json, told_on

FOREIGN_EFFECT_KERNELS = frozenset({"predict", "take", "topple"})
"""Kernels for carts that have effects without kernels."""
WARM_UP_CONTACTS = [(-0.25, 0.2, 1.0), (-0.25, 0.1, 1.0)]
WARM_UP_WHEELS = (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.6, 0.0, 0.05))
WARM_UP_CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), wheels=WARM_UP_WHEELS)
HELPER_CODE = f"from {__name__} import prepare_regression; prepare_regression()"


def run(as_json: bool) -> int:
    """Whatever the cart and the arms, kernels are the same."""
    kernels = asked_for()
    told = KernelProgressLines(len(kernels))
    with kernel_listener(told):
        prepare()
    ready = sum(bool(kernel.overloads) for kernel in kernels)
    if as_json:
        print_json({"kernels": ready, "compiled": told.count})
    else:
        print(f"{ready} kernels are ready: {told.count} were compiled, {ready - told.count} were found")
    return 0


def prepare(kind: type[CartFilter] | type[DisturbedFilter] = DisturbedFilter) -> None:
    """What a kind of filter, planner and model call; another process helps, which begins with other kernels."""
    helper = subprocess.Popen([sys.executable, "-c", HELPER_CODE], stdout=subprocess.PIPE, text=True)
    listener = Thread(target=_tell_of, args=(helper, compiling))
    listener.start()
    with told_on("preparing kernels"):
        for places in (WARM_UP_CONTACTS[:1], WARM_UP_CONTACTS):
            WrenchPlanner(WARM_UP_CART, [Arm("hand", places)]).warm_up()
        WARM_UP_CART.dynamics.warm_up()
        kind(WARM_UP_CART).warm_up()
        listener.join()


def _tell_of(helper: subprocess.Popen[str], tell: Callable[[str], None]) -> None:
    """Tells the kernels that a helper compiles."""
    with helper:
        for line in helper.stdout or ():
            tell(line.strip())


def prepare_regression() -> None:
    """What the helper does: the filter's regression takes about as long as all else."""
    with kernel_listener(lambda kernel: print(kernel, flush=True)):
        RegressorEstimator(WARM_UP_CART).warm_up()


def asked_for() -> list[Any]:
    """The kernels for carts whose effects all have some."""
    for room in (
        "cartgrasp.kernels.entries",
        "planning.kernels.choice",
        "estimation.online.disturbance.disturbed_filter",
    ):
        import_module(room)
    ours = (kernel for kernel in ENTRY_KERNELS if ".kernels." in kernel.py_func.__module__)
    return [kernel for kernel in ours if kernel.py_func.__name__ not in FOREIGN_EFFECT_KERNELS]
