"""The manoeuvre that tells effects apart, against columns written by hand, and what to record next."""

from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import (
    DirectionalDrag,
    FloorSlope,
    ForceBias,
    ForceScale,
    PayloadChange,
    QuadraticDrag,
    RollingResistance,
    TimeDelay,
    ViscousDrag,
)
from cartgrasp.inertia import Inertia
from cartgrasp.information import WrenchNoise
from cartgrasp.model import CartModel
from estimation.discrepancy.next_experiments import MORE_MOTION, next_experiments
from estimation.discrepancy.separating import ENOUGH, Hands, _apart, _motions, rivals_named, separating
from estimation.teaching_motions import PERIOD

MASS, G = 24.0, 9.81
RAIL = CartModel(
    Inertia(MASS, (0.0, 0.0), 2.0), RollingConstraints(0.0, no_rotation=True), (ViscousDrag(linear=3.0, angular=1.0),)
)
CART = CartModel(Inertia(MASS, (0.3, 0.05), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
ONE = Hands({"hand": np.array([-0.3, 0.1, 1.0])}, WrenchNoise(force=3.0, moment=0.1, rate=100.0))
TWO = Hands({"left": np.array([-0.3, 0.2, 1.0]), "right": np.array([-0.3, -0.2, 1.0])}, WrenchNoise())

ADDED = {
    "rolling_resistance": RollingResistance(coefficient=0.02),
    "directional_drag": DirectionalDrag(forward=0.0, backward=4.0),
    "quadratic_drag": QuadraticDrag(coefficient=6.0),
    "force_bias": ForceBias(fx=3.0),
    "force_scale": ForceScale(gain=1.1),
    "time_delay": TimeDelay(delay=0.03),
}


def column(name, u, a):
    """On a straight line, what each adds to the forward force; of usual signs."""
    force = MASS * a + 3.0 * u
    columns = {
        "rolling_resistance": 0.02 * MASS * G * np.sign(u) * (np.abs(u) > 0),
        "directional_drag": 4.0 * np.minimum(u, 0.0),
        "quadratic_drag": 6.0 * u * np.abs(u),
        "force_bias": 3.0 * np.ones_like(u),
        "force_scale": 0.1 * force,
        "time_delay": 0.03 * np.gradient(force, PERIOD),
    }
    return columns[name]


RIVALS = ("rolling_resistance", "quadratic_drag", "force_bias", "time_delay")


@pytest.mark.parametrize(("name", "rival"), [(name, rival) for name in ADDED for rival in RIVALS if name != rival])
def test_deviations_are_those_of_a_fit_by_hand(name, rival):
    """What least squares on acceleration, speed and the rival leave of the effect, over 3 N at a hundred rows a second;
    on rails, on all motions. Near rest our step is steep, not a jump."""
    for motion in _motions(RAIL):
        u = motion.twist_b[:, 0]
        a = np.gradient(u, PERIOD)
        columns = np.column_stack([a, u, column(rival, u, a)])
        columns = columns[:, np.linalg.norm(columns, axis=0) > 1e-9]
        here = column(name, u, a)
        left = here - columns @ np.linalg.lstsq(columns, here, rcond=1e-9)[0]
        expected = np.linalg.norm(left) * np.sqrt(100.0 * PERIOD) / 3.0
        found = _apart(motion, RAIL, ADDED[name], rivals_named(rival, RAIL, ONE), ONE)
        assert found == pytest.approx(expected, rel=0.12, abs=0.4), motion.says


def test_a_slope_and_a_bias_differ_along_another_heading():
    """Straight on, or on one heading alone, they are one."""
    sloping = CART.with_effect(FloorSlope(grade_x=0.01))
    found = separating(sloping, "floor_slope", ["force_bias"], TWO)
    assert "curve" in found.says or "turn" in found.says
    assert found.deviations > 10
    assert separating(RAIL.with_effect(FloorSlope(grade_x=0.01)), "floor_slope", ["force_bias"], ONE) is None


def test_the_simplest_of_motions_that_are_nearly_as_good_is_told():
    resisting = CART.with_effect(RollingResistance(coefficient=0.02))
    found = separating(resisting, "rolling_resistance", ["force_bias", "quadratic_drag"], TWO)
    known = {}
    for motion in _motions(CART):
        groups = [rivals_named(name, CART, TWO) for name in ("force_bias", "quadratic_drag")]
        known[motion.says] = min(_apart(motion, CART, RollingResistance(coefficient=0.02), g, TWO) for g in groups)
    assert known[found.says] == pytest.approx(found.deviations)
    assert found.deviations >= ENOUGH * max(known.values())
    earlier = list(known)[: list(known).index(found.says)]
    assert all(known[says] < ENOUGH * max(known.values()) for says in earlier)


def test_what_acts_at_a_time_or_on_the_wheels_has_none():
    loaded = CART.with_effect(PayloadChange(time=3.0, mass=5.0))
    assert separating(loaded, "payload_change", ["rolling_resistance"], TWO) is None
    resisting = CART.with_effect(RollingResistance(coefficient=0.02))
    for other in ("payload_change", "wheel_misalignment", "rolling_resistance"):
        assert separating(resisting, "rolling_resistance", [other], TWO) is None


def test_only_a_cart_that_may_goes_sideways():
    free = CartModel(Inertia(MASS, (0.0, 0.0), 2.0), RollingConstraints(None))
    assert {m.says for m in _motions(free)} - {m.says for m in _motions(CART)} == {
        "push it sideways to and fro",
        "push it sideways while it turns",
    }
    assert not any("turn" in m.says or "curve" in m.says for m in _motions(RAIL))


def diagnosis(names, hidden=0, verdict="explained", laws=(), arms=("hand",)):
    arm = SimpleNamespace(contact=np.tile([-0.3, 0.1, 1.0], (9, 1)))
    effect = SimpleNamespace(name="rolling_resistance", label="", confusable_with=tuple(names))
    balances = SimpleNamespace(log=SimpleNamespace(arms=dict.fromkeys(arms, arm)))
    return SimpleNamespace(
        effects=(effect,),
        cart=CART.with_effect(RollingResistance(coefficient=0.02)),
        checks=(SimpleNamespace(noise=SimpleNamespace(force=3.0, moment=0.1), rate=100.0),),
        final=SimpleNamespace(logs=(balances,), laws=laws),
        withdrawn=(),
        isolability={str(k): SimpleNamespace(is_shown=k >= hidden) for k in range(10)},
        verdict=verdict,
    )


def test_what_to_record_next():
    (told,) = next_experiments(diagnosis(["floor_slope", "force_bias"]))
    assert told.startswith("to tell rolling_resistance from floor_slope or force_bias: ")
    assert int(told.split("by ")[1].split()[0]) > 5
    assert next_experiments(diagnosis(["floor_slope", "floor_patch", "force_bias"])) == (told,)
    assert next_experiments(diagnosis(["payload_change"], hidden=6)) == (MORE_MOTION,)
    assert next_experiments(diagnosis(["floor_slope"], arms=())) == (MORE_MOTION,)
    assert next_experiments(diagnosis([])) == ()
    (told,) = next_experiments(diagnosis(["rolling_resistance"]))
    assert told.startswith("push with one arm alone")
    assert "twice" in next_experiments(diagnosis([], verdict="unexplained"))[0]
    laws = (SimpleNamespace(name="travelled distance"),)
    assert "another travelled distance" in next_experiments(diagnosis([], verdict="unexplained", laws=laws))[0]
