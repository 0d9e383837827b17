"""Logs for the tests of what sensors do: carts of `runs`' own integrator, held by two hands with wrenches of all kinds,
and made wrong afterwards."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from benchmarks.sealed.cases import draw_case
from benchmarks.sealed.generate import simulate as run_scene
from benchmarks.sealed.rough import rough
from benchmarks.sealed.scenes import random_of
from cartgrasp.cart_file import cart_from_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel

from ..runs import STEP, integrate, record, weave

PLANT = (24.0, 0.3, 0.05, 2.0, 3.0, 1.2, 0.0)
"""Mass, dx, dy, inertia, linear and angular drag, Coulomb coefficient."""
CART = CartModel(Inertia(24.0, (0.3, 0.05), 2.0))
RAIL = CartModel(Inertia(24.0, (0.0, 0.0), 2.0), RollingConstraints(no_rotation=True))
NOISE = 0.0005, 0.005, 3.0
QUIET = 0.0, 0.0, 0.0


def cart_of(mass_factor):
    """The cart file's cart, if it is off by a factor."""
    return CartModel(Inertia(24.0 * mass_factor, (0.3, 0.05), 2.0 * mass_factor))


def hands_of(wrenches):
    """Two hands that give reduced wrenches (n, 2) together, with side forces and twists of their own besides."""
    time = STEP * np.arange(len(wrenches))
    points = {"left": np.array([-0.4, 0.25, 1.0]), "right": np.array([-0.45, -0.3, 1.0])}
    hands, turned = {}, np.zeros(len(time))
    for k, (name, point) in enumerate(points.items()):
        wrench = np.zeros((len(time), 6))
        phases = np.arange(6) + 1.7 * k
        rates = 2.0 + 0.9 * np.arange(6) + 0.4 * k
        size = np.array([0.0, 12.0, 6.0, 1.0, 1.0, 4.0])
        wrench[:] = size * np.sin(time[:, None] * rates + phases)
        hands[name] = point, wrench
        turned += point[0] * wrench[:, 1] + wrench[:, 5]
    (left, right), rest = points.values(), wrenches[:, 1] - turned
    hands["left"][1][:, 0] = (rest + right[1] * wrenches[:, 0]) / (right[1] - left[1])
    hands["right"][1][:, 0] = wrenches[:, 0] - hands["left"][1][:, 0]
    return hands


@lru_cache(maxsize=4)
def two_hands(seed=0, noise=NOISE, duration=40.0):
    """A sound log of `PLANT`."""
    truth, wrenches = integrate(PLANT, weave, duration)
    return record(truth, hands_of(wrenches), noise, seed)


def to_and_fro(time, state):
    """Feedback on the speed."""
    return 60.0 * (0.5 * np.sin(0.8 * time) - state[3]), 0.0


@lru_cache(maxsize=2)
def on_rail(seed=0, noise=NOISE, duration=30.0):
    """A sound log without turns, one hand at the origin, to and fro."""
    plant = (24.0, 0.0, 0.0, 2.0, 3.0, 1.2, 0.01)
    truth, wrenches = integrate(plant, to_and_fro, duration)
    wrench = np.zeros((len(truth), 6))
    wrench[:, 0] = wrenches[:, 0]
    log = record(truth, {"hand": (np.zeros(3), wrench)}, noise, seed)
    return replace(log, pose=log.pose * [1, 0, 0], velocity=log.velocity * [1, 0, 0])


@lru_cache(maxsize=8)
def sealed(case, seed, is_rough=False):
    """A log of the sealed generator, with its cart."""
    from benchmarks.sealed.carts import cart_file

    scene = draw_case(case, seed, "rich")
    if is_rough:
        scene = rough(scene, random_of(f"{case} rough", seed, "rich"))
    header, table, _ = run_scene(scene, random_of(f"{case} sensors", seed, "rich"))
    columns = dict(zip(header, table.T, strict=True))

    def of(*names):
        return np.column_stack([columns[name] for name in names])

    velocity = of("vx", "vy", "omega") if "vx" in columns else None
    arms = {
        name: ArmLog(of(*(f"{name}.p{c}" for c in "xyz")), of(*(f"{name}.{k}{c}" for k in ("f", "t") for c in "xyz")))
        for name in scene.arms
    }
    viscous = not any(t.name == "viscous_drag" for t in scene.truths)
    cart = cart_from_text(cart_file(scene.world, scene.believed, viscous), "sealed")
    return RunLog(columns["t"], of("x", "y", "theta"), velocity, arms), cart


def late(log, lag, gain=1.0):
    """The log with velocities that come `lag` s late and `gain` times too large."""
    moved = [np.interp(log.time - lag, log.time, column) for column in log.velocity.T]
    return replace(log, velocity=gain * np.column_stack(moved))


def with_wrenches(log, change, arms=None):
    """The log with wrenches (n, 6) of some arms, all by default, changed."""
    arms = log.arms if arms is None else arms
    return replace(
        log, arms={k: ArmLog(a.contact, change(a.wrench) if k in arms else a.wrench) for k, a in log.arms.items()}
    )


def found(suspicions):
    """Probabilities by kind and where."""
    return {(one.kind, one.where): one.probability for one in suspicions}
