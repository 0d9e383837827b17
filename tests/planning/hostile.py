"""Numbers that nobody should send: arms, carts, wrenches and contacts for planners that must bear them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from cartgrasp.arms import Arm, Friction
from cartgrasp.joint_torques import JointTorques

from .drawn import cart

SPECIAL = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 5e-324, 1e-12, 1e9, 1e15, -1.0)
NOT_NUMBERS = (None, "abc", (), (1.0, 2.0), [[1.0, 2.0, 3.0]], {}, 1j, (None, 0, 0), 10**400)


def number(rng, scale, share=0.05):
    """Mostly ordinary; a share is special, and a few are huge or tiny."""
    dice = rng.random()
    if dice < share:
        return float(rng.choice(SPECIAL))
    if dice < 2 * share:
        return float(rng.choice((-1, 1)) * 10 ** rng.uniform(-12, 12))
    return float(rng.uniform(-scale, scale))


def limit(rng, scale, share):
    """Zero, reversed (negative), infinite, NaN, huge or tiny for a share."""
    return number(rng, scale, share) if rng.random() < share else float(rng.uniform(0.05, 1.0) * scale)


def hostile_friction(rng, share):
    dice = rng.random()
    if dice < 0.3:
        return None
    sides = "exact" if dice < 0.4 else int(rng.choice([3, 4, 8]))
    return Friction(abs(number(rng, 1.0, share)) if rng.random() < 0.9 else number(rng, 1.0, share), sides)


def hostile_arms(rng, share):
    """One to four arms, of which some stand at one point, on the origin or a metre up from each other; may raise
    what `Arm` and `Friction` document."""
    arms, shared = [], [number(rng, 0.5, share) for _ in range(3)]
    for i in range(int(rng.integers(1, 5))):
        kind = rng.random()
        point = shared if kind < 0.2 else (0.0, 0.0, 1.0) if kind < 0.3 else [number(rng, 0.5, share) for _ in range(3)]
        more = {"segment": [point, [number(rng, 0.5, share) for _ in range(3)]]} if rng.random() < 0.1 else {}
        arms.append(
            Arm(
                f"arm{i}",
                () if more else [point],
                yaw=number(rng, 3.0, share),
                force_limit=[limit(rng, 60.0, share) for _ in range(3)],
                moment_limit=[limit(rng, 8.0, share) for _ in range(3)],
                friction=hostile_friction(rng, share),
                weights=[abs(limit(rng, 10.0, share)) for _ in range(6)],
                **hostile_strength(rng, share),
                **more,
            )
        )
    return arms


def hostile_strength(rng, share):
    """Push only, a payload, joints: with a share of odd numbers, each for a few arms."""
    more = {}
    if rng.random() < 0.1:
        more["push_only"] = True
    if rng.random() < 0.1:
        more["payload"] = limit(rng, 5.0, share)
    if rng.random() < 0.1:
        jacobian = [[number(rng, 1.0, share / 40) for _ in range(7)] for _ in range(6)]
        most = np.array([limit(rng, 30.0, share / 7) for _ in range(7)])
        more["joints"] = JointTorques(np.array(jacobian), rng.uniform(-0.3, 1.0, 7) * np.minimum(most, 10.0), most)
    return more


def hostile_cart(rng):
    """Axles up to a kilometre away."""
    return cart(int(rng.integers(0, 3)), float(rng.choice([0.0, 0.3, -0.3, 1e-9, 1e3])))


def hostile_wrench(rng):
    dice = rng.random()
    if dice < 0.02:
        return NOT_NUMBERS[int(rng.integers(len(NOT_NUMBERS)))]
    scale = 10.0 ** rng.uniform(-9, 9) if dice < 0.2 else 1.0
    return [number(rng, scale * size) for size in (80.0, 20.0, 12.0)]


def hostile_contacts(rng, arms):
    """None at times, some arms at times, an unknown arm at times, rubbish at times."""
    dice = rng.random()
    if dice < 0.5:
        return None
    if dice < 0.52:
        return NOT_NUMBERS[int(rng.integers(1, len(NOT_NUMBERS)))]
    contacts = {a.name: [number(rng, 0.5) for _ in range(3)] for a in arms if rng.random() < 0.8}
    return contacts | ({"nobody": (0.0, 0.0, 0.0)} if rng.random() < 0.02 else {})


def hostile_estimate(rng):
    if rng.random() < 0.8:
        return None
    motion = SimpleNamespace(pose_sb=np.array([number(rng, 5.0) for _ in range(3)]), velocity=np.zeros(2))
    parameters = {"mass": SimpleNamespace(value=number(rng, 30.0))}
    return SimpleNamespace(time=number(rng, 0.2), motion=motion, parameters=parameters)
