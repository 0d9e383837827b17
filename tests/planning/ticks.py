"""Ticks of a controller that sends a planner whatever comes: arms, estimates, contacts and wrenches, good and bad.

What is drawn comes with a verdict: `GOOD` must be taken, `BAD` must be refused, `EITHER` is for the planner to say.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

import cartgrasp as cg
from cartgrasp.motion import Motion
from planning import (
    InternalForce,
    LeastInternalForce,
    LeastJointTorque,
    Lexicographic,
    LoadShare,
    Nothing,
    Skid,
    Smoothness,
    TipOver,
    WeightedWrench,
    WorstArm,
)

from .contacts.test_contact_choice_with_cart_limits import WHEELS, joints

GOOD, BAD, EITHER = "good", "bad", "either"
PLAIN_LIMITS = {"force_limit": (60, 60, 40), "moment_limit": (8, 8, 6)}


class Sent(NamedTuple):
    """What is sent, and whether it must be taken."""

    value: Any = None
    verdict: str = GOOD


class Tick(NamedTuple):
    wrench: Sent
    contacts: Sent
    estimate: Sent
    arms: Sent


def drawn_cart(rng):
    rows = int(rng.choice([0, 1, 1, 2]))
    constraints = cg.RollingConstraints(float(rng.uniform(-0.3, 0.3)) if rows else None, no_rotation=rows == 2)
    wheels = WHEELS if rows else tuple(cg.Wheel("caster", w.x, w.y, 0.04) for w in WHEELS)
    height = float(rng.uniform(0.2, 0.8))
    return cg.CartModel(drawn_inertia(rng), constraints, wheels=wheels, com_height=height)


def drawn_inertia(rng):
    com = (float(rng.uniform(0.1, 0.6)), float(rng.uniform(-0.15, 0.15)))
    return cg.Inertia(float(rng.uniform(10, 80)), com, float(rng.uniform(0.5, 4)))


def drawn_cart_limits(rng, cart):
    limits = [TipOver(float(rng.uniform(0, 20)))] if rng.random() < 0.4 else []
    limits += [InternalForce(float(rng.uniform(0, 20)), tuple(rng.normal(size=3)))] if rng.random() < 0.3 else []
    limits += [Skid(float(rng.uniform(0.2, 0.9)))] if cart.constraints.n_rows == 1 and rng.random() < 0.4 else []
    return limits


def drawn_objective(rng, names):
    shares = rng.dirichlet(np.ones(len(names)))
    every = [
        None,
        Smoothness(float(rng.uniform(0, 5))),
        WorstArm(float(rng.uniform(0.1, 20))),
        LeastInternalForce(float(rng.uniform(0, 3)), tuple(rng.normal(size=3))),
        LeastJointTorque(float(rng.uniform(0, 2))),
        LoadShare(dict(zip(names, (shares / shares.sum()).tolist(), strict=True)), 3.0),
        Smoothness(0.5, WorstArm(5.0)),
        Lexicographic(WorstArm(1.0, Nothing()), WeightedWrench()),
        Lexicographic(LeastInternalForce(1.0, base=Nothing()), Smoothness(1.0)),
    ]
    return every[int(rng.integers(len(every)))]


def some_limit(rng, size):
    """Mostly ordinary; at times zero, infinite, tiny or large."""
    return rng.choice([0.0, np.inf, 1e-6, 1e5]) if rng.random() < 0.1 else rng.uniform(0.1, 1.0) * size


def drawn_arm(rng, name, n_points=None):
    n_points = int(rng.choice([1, 1, 1, 2, 3])) if n_points is None else n_points
    points = rng.uniform((-0.4, -0.4, 0.8), (-0.2, 0.4, 1.2), (n_points, 3))
    kind, more = rng.random(), {}
    if kind < 0.1:
        points = np.array([[-0.25, 0.1, 1.0]])  # as that of others
    elif kind < 0.2:
        more["segment"] = [(-0.25, -0.2, 1.0), (-0.25, 0.2, 1.0)]
    if rng.random() < 0.15:
        more["reach"] = cg.Reach.box(points.min(axis=0) - 0.05, points.max(axis=0) + 0.05)
        more.pop("segment", None)
    friction = None
    if rng.random() < 0.4:
        friction = cg.Friction(float(rng.choice([0.0, 1e-3, 0.4, 0.9])), rng.choice([3, 4, 8]))
    return cg.Arm(
        name,
        () if "segment" in more else points.tolist(),
        yaw=float(rng.uniform(-1, 1)),
        force_limit=[some_limit(rng, 90.0) for _ in range(3)],
        moment_limit=[some_limit(rng, 9.0) for _ in range(3)],
        friction=friction,
        weights=rng.uniform(0.5, 12, 6),
        push_only=bool(rng.random() < 0.2),
        payload=float(rng.choice([np.inf, np.inf, 3.0, 0.0])),
        wrench_rate=rng.choice([np.inf, np.inf, 300.0, 1e4]) * rng.uniform(0.5, 2.0, 6),
        joints=joints(rng) if rng.random() < 0.3 else None,
        **more,
    )


# --- what is sent ---------------------------------------------------------------------------------------------


def drawn_tick(rng, mirror):
    return Tick(sent_wrench(rng), sent_contacts(rng, mirror), sent_estimate(rng, mirror), sent_arms(rng, mirror))


def sent_wrench(rng):
    dice = rng.random()
    if dice < 0.05:
        odd = [
            (np.nan, 0, 0),
            (0, np.inf, 0),
            (1e10, 0, 0),
            (1e300,) * 3,
            None,
            "abc",
            ["1", "2", "3"],
            np.array([1j, 0, 0]),
            np.array(5.0),
            np.ones((3, 1)),
            (1, 2),
            {},
            np.array(["2020", "2021", "2022"], dtype="datetime64[Y]"),
            (None, 0, 0),
            10**400,
        ]
        return Sent(odd[int(rng.integers(len(odd)))], BAD)
    wrench = rng.uniform((-60, -20, -15), (100, 20, 15)) * rng.choice([1.0, 1.0, 1.0, 0.1, 10.0])
    if dice < 0.15:
        few = np.zeros(6)
        few[::2] = wrench
        odd = [
            np.zeros(3),
            np.full(3, -0.0),
            np.full(3, 5e-324),
            1e-12 * wrench,
            1e5 * np.clip(wrench, -9, 9),
            wrench.astype(np.float32),
            wrench.astype(object),
            few[::2],
            [True, False, True],
            [int(w) for w in wrench],
        ]
        return Sent(odd[int(rng.integers(len(odd)))])
    wrench.setflags(write=bool(rng.random() < 0.5))
    return Sent(wrench)


def sent_contacts(rng, mirror):
    dice, names = rng.random(), list(mirror.arms)
    if dice < 0.5:
        return Sent()
    if dice < 0.55:
        name = names[0]
        odd = [
            [(0, 0, 0)] * len(names),
            np.zeros((len(names), 3)),
            {name: (np.nan, 0, 0)},
            {name: (0, 0)},
            {name: None},
            {name: (0, 2e6, 0)},
            {name: np.array([1j, 0, 0])},
            {name: ("0", "0", "0")},
            {"nobody": (0, 0, 0)},
            dict.fromkeys(names, (0, 0, 1e9)),
            dict.fromkeys(names, (0, 0, np.inf)),
            {None: (0, 0, 0)},
            "left",
            7,
        ]
        return Sent(odd[int(rng.integers(len(odd)))], BAD)
    given = {
        name: rng.uniform((-0.5, -0.5, 0.7), (0.3, 0.5, 1.3)) for name in names if dice > 0.7 or rng.random() < 0.5
    }
    if rng.random() < 0.1:
        given = dict.fromkeys(names, np.array([-0.25, 0.0, 1.0]))
    return Sent(given)


def sent_arms(rng, mirror):
    dice, names = rng.random(), mirror.names
    if dice < 0.8:
        return Sent()
    if dice < 0.85:
        far = cg.Arm(names[0], [(0.0, 0.0, 1.0)], reach=cg.Reach.box((5, 5, 5), (6, 6, 6)))
        one = drawn_arm(rng, names[0])
        odd = [[], [None], "left", 7, names, {names[0]: one}, [one, one], [drawn_arm(rng, "nobody")], [far]]
        return Sent(odd[int(rng.integers(len(odd)))], BAD)
    new = [drawn_arm(rng, name, 1 if len(names) > 2 else None) for name in names if rng.random() < 0.7]
    return Sent(new, BAD if not new or mirror.objective_refuses(new) else GOOD)


def sent_estimate(rng, mirror):
    """Of the planner's cart with other numbers; late, from the future, or no estimate at all."""
    dice, cart = rng.random(), mirror.structure
    if dice < 0.55:
        return Sent()
    velocity = rng.normal(size=cart.constraints.n_free) * rng.choice([0.0, 0.3, 1.0])
    model, motion, late = cart.with_inertia(drawn_inertia(rng)), Motion(rng.normal(size=3), velocity), mirror.newest
    time = float(rng.uniform(-0.4, 0.5)) + (late if np.isfinite(late) else 0.0)
    covariance = drawn_covariance(rng, model)
    good = {
        "time": time,
        "motion": motion,
        "parameters": {"mass": SimpleNamespace(value=1.0)},
        "health": "",
        "structure": model,
        "model_parameters": model.parameters,
        "covariance": covariance,
    }
    if dice < 0.85:
        return Sent(cg.Estimate(**good))
    return _odd_estimate(rng, mirror, good)


def drawn_covariance(rng, model):
    """Of phi; well below its values, of full rank."""
    scale = np.array([0.5, 0.1, 0.1, 0.2]) * 10 ** rng.uniform(-2, 0)
    root = scale[:, None] * (np.eye(4) + 0.3 * rng.normal(size=(4, 4)))
    return root @ root.T


def _odd_estimate(rng, mirror, good):
    phi, velocity, covariance = good["model_parameters"], good["motion"].velocity, good["covariance"]
    other = cg.RollingConstraints(None if mirror.structure.constraints.n_rows else 0.0)
    odd = [  # (changes, refused whatever the planner, refused where there are limits of the cart)
        ({"time": np.nan}, True),
        ({"time": None}, True),
        ({"motion": None}, True),
        ({"motion": Motion(np.full(3, np.nan), velocity)}, True),
        ({"motion": Motion(np.zeros(3), None)}, True),
        ({"parameters": {"mass": SimpleNamespace(value=np.inf)}}, True),
        ({"parameters": None}, True),
        ({"motion": Motion(np.zeros(3), np.zeros(7))}, False),
        ({"motion": Motion(np.zeros(3), velocity + 1e200)}, mirror.structure.constraints.n_rows == 2 and EITHER),
        ({"motion": Motion(1.0, velocity)}, False),
        ({"model_parameters": phi * [-1, 1, 1, 1]}, False),
        ({"model_parameters": phi * 0}, False),
        ({"model_parameters": phi * [1, 1, 1, 0]}, False),
        ({"model_parameters": phi * np.nan}, False),
        ({"model_parameters": phi * 1e300}, False),
        ({"model_parameters": phi[:3]}, False),
        ({"model_parameters": None}, False),
        ({"structure": None}, False),
        ({"structure": cg.CartModel(mirror.structure.inertia, other)}, False),
    ]
    wrong = [
        None,
        covariance * np.nan,
        -covariance,
        covariance[:2],
        covariance + 1j,
        "abc",
        np.eye(4) - 0.9,
        [[1], [2, 3]],
    ]
    if mirror.confidence is not None and rng.random() < 0.5:
        if rng.random() < 0.5:
            odd = [({"covariance": w}, False) for w in wrong]
        else:
            wide = [covariance * 10 ** rng.uniform(1, 12), covariance * 0, covariance * 1e-300, np.ones((4, 4)) * 1e-6]
            covariance = wide[int(rng.integers(len(wide)))]
            return Sent(cg.Estimate(**(good | {"covariance": covariance})), EITHER)
    if rng.random() < 0.2 and np.isfinite(mirror.newest):
        return Sent(cg.Estimate(**(good | {"time": mirror.newest - float(rng.uniform(0.51, 1e6))})), "stale")
    changes, always = odd[int(rng.integers(len(odd)))]
    # what isn't looked at without limits of the cart is no reason to refuse there
    is_bad = always is not EITHER and (always or any(isinstance(one, Skid | TipOver) for one in mirror.cart_limits))
    return Sent(cg.Estimate(**(good | changes)), BAD if is_bad else EITHER)
