"""The compiled closed loop against the loop that knows its parts by their roles alone: one run, two roads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.arms import Arm
from cartgrasp.effects import (
    CasterRealignment,
    ForceBias,
    LearnedForce,
    LoadSlosh,
    PayloadChange,
    RollingResistance,
    ViscousDrag,
)
from cartgrasp.inertia import Inertia
from cartgrasp.joint_torques import JointTorques
from cartgrasp.model import CartModel
from cartgrasp.simulation.sensors import SensorNoise
from cartgrasp.studies.compiled_loop.loop import compiled_run, covers
from cartgrasp.studies.scenario import FIRST_GUESS, MUJOCO_PLANT, PAPER, Scenario
from cartgrasp.studies.shopping_cart import FIRM_GAINS, WHEELS
from estimation import FilterNoise
from planning import Choosing, RegraspTimes
from planning.references import chain, pause, speed_change, straight, turn

CURVES = chain(speed_change(0.6, 0.4), turn(0.8, 0.5), turn(-0.8, 0.5), speed_change(-0.6, 0.4), pause(0.5))
TOLERANCE = 1e-9


def arms(force=120.0):
    places = {"left": (0.2, 0.1), "right": (-0.2, -0.1)}
    limits = {"force_limit": (force, 40.0, 40.0), "moment_limit": (15.0, 15.0, 15.0)}
    return tuple(Arm(name, [(-0.25, y, 1.0) for y in ys], **limits) for name, ys in places.items())


def scenario(seed, **changes):
    """A drawn cart, with rolling resistance that both know of."""
    random = np.random.default_rng(seed)
    mass, x, y = random.uniform(15, 45), random.normal(0.3, 0.05), random.normal(0.0, 0.05)
    effects = ViscousDrag(*random.uniform(0.5, 4.0, 2)), RollingResistance(random.uniform(0.005, 0.03))
    believed = ViscousDrag(3.0, 1.0), RollingResistance(0.02)
    given = Scenario(
        truth=CartModel(Inertia(mass, (x, y), random.uniform(1.5, 3.0)), effects=effects, wheels=WHEELS),
        guess=CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=believed, wheels=WHEELS),
        arms=arms(),
        stretches=CURVES,
        sensors=SensorNoise(),
        noise=FilterNoise(),
        gains=FIRM_GAINS,
        seed=seed,
    )
    return replace(given, **changes)


def relative(found, expected):
    """The largest difference, by the largest number; NaN are at the same places."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    assert np.array_equal(np.isnan(found), np.isnan(expected))
    return float(np.nanmax(np.abs(found - expected), initial=0.0) / max(np.nanmax(np.abs(expected), initial=0.0), 1e-6))


def agree(one, other):
    assert one.statuses == other.statuses
    assert one.healths == other.healths[-1:]
    assert one.log.columns == other.log.columns
    assert relative(one.log.table, other.log.table) < TOLERANCE
    for name in ("pose", "velocity", "reference_pose", "reference_velocity", "com_covariance"):
        assert relative(getattr(one, name), getattr(other, name)) < TOLERANCE, name
    assert (one.caster_headings is None) == (other.caster_headings is None)
    if one.caster_headings is not None:
        assert relative(one.caster_headings, other.caster_headings) < TOLERANCE
    for arm, wrenches in other.wrenches.items():
        assert relative(one.wrenches[arm], wrenches) < TOLERANCE, arm
    assert list(one.parameters) == list(other.parameters)
    assert one.identifiable == other.identifiable
    for name, series in other.parameters.items():
        found = one.parameters[name]
        assert found.unit == series.unit
        assert (found.truth is None) == (series.truth is None)
        for part in ("value", "std") if series.truth is None else ("value", "std", "truth"):
            assert relative(getattr(found, part), getattr(series, part)) < TOLERANCE, (name, part)


SLOW_SENSORS = SensorNoise(pose_period=0.03, velocity_period=None, wrench_period=0.02)
WITH_CASTERS = (ViscousDrag(2.0, 0.4), RollingResistance(0.015), CasterRealignment(swivel_torque=0.1))
LOADED = (ViscousDrag(2.0, 0.4), PayloadChange(time=2.5, mass=8.0, x=0.4, y=0.1))
KNOWN_LAWS = (
    ViscousDrag(2.0, 0.4),
    LearnedForce("world_force", "time", direction=1.0, period=3.0, amplitudes=(4.0, 2.0), label="gusts"),
    LearnedForce("drag", "place", knots=(0.3, 0.6, 0.9), amplitudes=(0.0, 4.0, 1.0), label="patch"),
)
FLAT_SPOT = LearnedForce("forward_force", "travelled_distance", lever=0.27, period=0.525, amplitudes=(4.0, 2.0))
CASES = {
    "drawn": {},
    "regrasps": {"contacts": "periodic", "choosing": Choosing(every=1.0)},
    "sensors of their own rates": {"sensors": SLOW_SENSORS},
    "casters nobody knows of": {
        "truth": CartModel(Inertia(30.0, (0.36, 0.05), 2.6), effects=WITH_CASTERS, wheels=WHEELS)
    },
    "casters that both know of": {
        "truth": CartModel(Inertia(30.0, (0.36, 0.05), 2.6), effects=WITH_CASTERS, wheels=WHEELS),
        "guess": CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=WITH_CASTERS, wheels=WHEELS),
    },
    "a load is put on": {"truth": CartModel(Inertia(22.0, (0.32, 0.02), 2.1), effects=LOADED, wheels=WHEELS)},
    "weak arms": {"arms": arms(force=7.0), "duration": 2.5},
    "back and forth": {
        "stretches": chain(straight(1.0, 0.5), straight(-1.0, 0.5)),
        "known": frozenset({"viscous_drag"}),
        "duration": 4.0,  # then round-off grows by half in each step: friction is made up for where it fades
    },
    "laws": {
        "truth": CartModel(Inertia(25.0, (0.3, 0.02), 2.2), effects=(*KNOWN_LAWS, FLAT_SPOT), wheels=WHEELS),
        "guess": CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=KNOWN_LAWS, wheels=WHEELS),
    },
    "another rate": {"period": 0.02, "plant_timestep": 0.004},
}


@pytest.mark.parametrize("case", CASES)
def test_both_loops_agree(case):
    given = scenario(len(case), **{"duration": 3.0, **CASES[case]})
    assert covers(given)
    found = compiled_run(given)
    agree(found, given.run())
    if case == "weak arms":
        assert {"relaxed", "optimal"} <= set(found.statuses)


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(12))
def test_both_loops_agree_over_whole_runs(seed):
    given = scenario(seed, stretches=chain(CURVES, CURVES, CURVES), duration=30.0)
    agree(compiled_run(given), given.run())


def test_a_run_does_not_depend_on_those_before():
    """To the last bit."""
    given, other = scenario(1, duration=2.0), scenario(2, duration=2.0, arms=arms(force=7.0))
    alone = compiled_run(given)
    compiled_run(other)
    again = compiled_run(given)
    assert np.array_equal(alone.log.table, again.log.table)
    assert np.array_equal(alone.pose, again.pose)
    for name, series in alone.parameters.items():
        assert np.array_equal(series.value, again.parameters[name].value)
        assert np.array_equal(series.std, again.parameters[name].std)


class AnyPosture:
    """One joint that bears whatever is asked."""

    def joints_at(self, contact, yaw):
        return JointTorques(np.ones((6, 1)), [0.0], [np.inf])


def test_what_is_left_to_the_other_loop():
    given = scenario(0)
    assert covers(given)
    biased = replace(given.truth, effects=(*given.truth.effects, ForceBias(fx=1.0)))
    swinging = replace(given.guess, effects=(*WITH_CASTERS, LoadSlosh(1.0)))
    for changes in (
        {"estimation": FIRST_GUESS},
        {"estimation": PAPER},
        {"plant": MUJOCO_PLANT},
        *({"contacts": way} for way in ("least-effort", "teach", "schedule")),
        {"contacts": "periodic", "regrasp": RegraspTimes()},
        {"truth": biased},
        {"guess": swinging},
        {"arms": tuple(Arm(arm.name, arm.contacts, wrench_rate=(100.0,) * 6) for arm in given.arms)},
        {"arms": tuple(Arm(arm.name, arm.contacts, joints=AnyPosture()) for arm in given.arms)},
    ):
        assert not covers(replace(given, **changes)), changes
