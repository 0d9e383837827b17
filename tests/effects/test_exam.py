"""The exam that every effect of the vocabulary sits, each in all of its forms (`drawn.py`). A new one in KNOWN_EFFECTS
is examined without a test of its own. It only says below what its parameters are in (CONTRACT), whether it can give
energy (GIVES_ENERGY), and, if it is dry friction, how it is when the cart stands (COULOMB)."""

from __future__ import annotations

from dataclasses import fields, replace
from random import Random

import numpy as np
import pytest
from hypothesis import Phase, assume, find, given, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample
from scipy.optimize import lsq_linear

from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import LearnedForce, SensorEffect
from cartgrasp.effects.effect import Gate, HandMotion
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from tests.core.differences import assert_partials
from tests.core.drawn import numbers, vectors

from .drawn import (
    CONSTRAINT_EFFECTS,
    EFFECTS,
    FIXED,
    FORCE_EFFECTS,
    INERTIA_EFFECTS,
    SENSOR_EFFECTS,
    effects,
    title,
    trials,
    without,
)

GIVES_ENERGY = {
    "viscous_drag": False,
    "rolling_resistance": False,
    "stribeck_friction": False,
    "quadratic_drag": False,
    "directional_drag": False,
    "floor_slope": True,
    "floor_patch": False,
    "caster_realignment": False,
    "wheel_drag_imbalance": True,  # a moment whose wheel's place is not known
    "external_push": True,
    "load_slosh": True,  # gives back what it took
    "end_stop": True,  # so does its spring
}
SIGNED = ("directional_drag", "learned_force")
"""They give none while no value is negative."""
CONTRACT = {
    "viscous_drag": {"linear": "N·s/m", "angular": "N·m·s/rad"},
    "rolling_resistance": {"coefficient": "-"},
    "stribeck_friction": {"breakaway": "N", "speed": "m/s"},
    "quadratic_drag": {"coefficient": "N·s²/m²"},
    "directional_drag": {"forward": "N·s/m", "backward": "N·s/m"},
    "floor_slope": {"grade_x": "-", "grade_y": "-"},
    "floor_patch": {"x_min": "m", "x_max": "m", "y_min": "m", "y_max": "m", "coefficient": "-"},
    "caster_realignment": {"swivel_torque": "N·m", "trail": "m"},
    "wheel_drag_imbalance": {"force": "N", "moment": "N·m"},
    "wheel_misalignment": {"angle": "rad"},
    "lateral_slip": {"cornering_stiffness": "N/rad"},
    "payload_change": {"time": "s", "mass": "kg", "x": "m", "y": "m"},
    "force_bias": {"fx": "N", "fy": "N", "tz": "N·m"},
    "force_scale": {"gain": "-"},
    "force_misalignment": {"angle": "rad"},
    "load_slosh": {"mass": "kg", "frequency": "Hz", "damping": "-"},
    "time_delay": {"delay": "s"},
    "contact_offset": {"x": "m", "y": "m"},
    "tool_inertia": {"mass": "kg", "x": "m", "y": "m", "z": "m"},
    "pose_offset": {"x": "m", "y": "m", "yaw": "rad"},
    "external_push": {"start": "s", "duration": "s", "force": "N", "moment": "N·m"},
    "end_stop": {"position": "m", "restitution": "-", "stiffness": "N/m", "damping": "N·s/m"},
}
BEYOND_CONTRACT = {
    "stribeck_friction": {"by_wheels": "-"},
    "caster_realignment": {"x": "m", "scrub_torque": "N·m", "smoothing_rate": "rad/s"},
    "end_stop": {"side": "-"},
}
COULOMB = {
    *("rolling_resistance", "stribeck_friction", "floor_patch", "caster_realignment", "wheel_drag_imbalance"),
}
NOT_ESTIMATED_ONLINE = {
    *("stribeck_friction.speed", "stribeck_friction.by_wheels", "caster_realignment.trail", "payload_change.time"),
    "caster_realignment.x",
    *("external_push.start", "external_push.duration", "time_delay.delay"),
    *("tool_inertia.z", "contact_offset.x"),
    *("wheel_misalignment.angle", "lateral_slip.cornering_stiffness"),
    *("load_slosh.frequency", "load_slosh.damping"),
    *(f"end_stop.{name}" for name in ("position", "side", "restitution", "stiffness", "damping")),
    *(f"floor_patch.{edge}" for edge in ("x_min", "x_max", "y_min", "y_max")),
}
PARTIALS = {
    "pose_sb": "by_pose",
    "velocity_b": "by_velocity",
    "phi": "by_phi",
    "memory": "by_memory",
    "parameters": "by_parameters",
}


def gives_energy(effect):
    """A law does, unless it is a drag of positive amplitudes."""
    if isinstance(effect, LearnedForce):
        return effect.acts_on != "drag" or bool(effect.cycle)
    return GIVES_ENERGY.get(effect.name, True)


def is_coulomb(effect):
    return effect.acts_on == "drag" if isinstance(effect, LearnedForce) else effect.name in COULOMB


every_effect = pytest.mark.parametrize("kind", EFFECTS, ids=title)
every_fixed_effect = pytest.mark.parametrize("kind", FIXED, ids=title)
every_force = pytest.mark.parametrize("kind", FORCE_EFFECTS, ids=title)
every_change = pytest.mark.parametrize("kind", INERTIA_EFFECTS, ids=title)
every_constraint = pytest.mark.parametrize("kind", CONSTRAINT_EFFECTS, ids=title)
every_sensor = pytest.mark.parametrize("kind", SENSOR_EFFECTS, ids=title)
spatial_wrenches = vectors(6, -80.0, 80.0)
fewer = settings(max_examples=settings.default.max_examples // 3)


def test_the_exam_knows_every_effect():
    assert {kind.name for kind in FIXED} == set(CONTRACT), "give each a row of CONTRACT: its parameters' units"
    forces = {kind.name for kind in FORCE_EFFECTS} - {"learned_force"}
    assert forces == set(GIVES_ENERGY), "give each force a row of GIVES_ENERGY"


@every_force
def test_a_force_acts_somewhere(kind):
    first = settings(max_examples=500, database=None, phases=[Phase.generate])
    try:
        assert find(trials(kind), lambda trial: bool(trial.wrench().any()), settings=first, random=Random(0))
    except NoSuchExample:
        pytest.fail(f"{title(kind)} gives no wrench anywhere: what does its file in kernels/effects/ add?")


@every_fixed_effect
def test_speaks_the_contracts_language(kind):
    told = CONTRACT.get(kind.name, {}) | BEYOND_CONTRACT.get(kind.name, {})
    assert {p.name: p.unit for p in kind.parameters} == told, "its row of CONTRACT has its parameters' units"
    assert [f.name for f in fields(kind) if f.name != "label"] == [p.name for p in kind.parameters]
    assert len(kind.signature.split()) > 4
    for parameter in kind.parameters:
        assert parameter.typical > 0
        assert parameter.lower <= parameter.absent <= parameter.upper
        assert getattr(kind, parameter.name) == parameter.absent


def test_where_and_when_are_not_estimated_online():
    fixed = {f"{k.name}.{p.name}" for k in EFFECTS for p in k.parameters if not p.estimated}
    assert fixed == NOT_ESTIMATED_ONLINE, "what has `estimated=False` stands in NOT_ESTIMATED_ONLINE"


@pytest.mark.parametrize("kind", [kind for kind in (*FORCE_EFFECTS, *INERTIA_EFFECTS) if kind in FIXED], ids=title)
def test_a_search_has_what_to_begin_with(kind):
    """In balances of forces. What it takes for linear, a filter estimates; what is not linear has values to try."""
    if kind.searched and kind.gate is Gate.ALWAYS:
        left_out = [one.name for one in kind.parameters if not (one.estimated or one.grid)]
        assert not left_out, f"give {left_out} a `grid`, or the effect `searched = False`"


@every_constraint
@given(data=st.data(), state=vectors(5, -2.0, 2.0), wrench=vectors(3, -80.0, 80.0))
def test_a_constraint_is_as_it_was_where_its_effect_is_absent(kind, data, state, wrench):
    effect = data.draw(effects(kind))
    cart = CartModel(Inertia(20.0, (0.3, 0.1), 2.0))
    expected = cart.state_rate(state, wrench)
    np.testing.assert_array_equal(cart.with_effect(without(effect)).state_rate(state, wrench), expected)


@every_constraint
@given(data=st.data(), nu=vectors(2, -2.0, 2.0), wrench=vectors(3, -80.0, 80.0))
def test_partials_of_the_rate_under_a_constraint(kind, data, nu, wrench):
    assume(np.abs(nu[0]) > 1e-3)  # creep bends there
    effect = data.draw(effects(kind))
    cart = CartModel(Inertia(20.0, (0.3, 0.1), 2.0), effects=(effect,))
    state = cart.state((0.1, 0.2, 0.3), nu)
    rate = cart.rate(state, wrench)
    assert_partials(rate.by_state, lambda s: cart.state_rate(s, wrench), state)
    assert_partials(rate.by_wrench, lambda w: cart.state_rate(state, w), wrench)
    assert_partials(rate.by_parameters, lambda p: cart.state_rate(state, wrench, p), cart.parameters)


@every_constraint
@given(data=st.data())
def test_a_constraint_effect_needs_fixed_wheels(kind, data):
    with pytest.raises(UsageError, match=f"^{kind.name}.*no fixed wheels; add the constraint no_lateral_slip"):
        CartModel(Inertia(20.0, (0.3, 0.1), 2.0), RollingConstraints(None), (data.draw(effects(kind)),))
    rail = CartModel(Inertia(20.0, (0.3, 0.1), 2.0), RollingConstraints(0.2, no_rotation=True), (kind,))
    assert rail.basis_b.shape == (3, 1)
    assert rail.basis_b[2] == 0
    np.testing.assert_array_equal(rail.rolling.across_b @ rail.basis_b[:2], np.zeros(1))


@every_force
@given(data=st.data())
def test_partials_of_the_wrench(kind, data):
    trial = data.draw(trials(kind))
    at = {
        "pose_sb": trial.situation.pose_sb,
        "velocity_b": trial.situation.velocity_b,
        "phi": trial.situation.phi,
        "memory": trial.memory,
        "parameters": trial.values,
    }
    for method in ("wrench_b", "memory_rate") if len(trial.memory) else ("wrench_b",):
        contribution = trial.contribution(method)
        for argument, name in PARTIALS.items():
            analytic = getattr(contribution, name)
            analytic = np.zeros((1, len(at[argument]))) if analytic is None else analytic
            if argument == "parameters" and getattr(trial.effect, "trail", None) == 0.0:
                assert not analytic[..., 1].any()  # a trail of 0 stands for the listed one
                continue

            def value(moved, method=method, argument=argument):
                return trial.contribution(method, **{argument: moved}).value

            assert_partials(analytic, value, at[argument])


@every_change
@given(data=st.data(), time=numbers(-40, 40))
def test_partials_of_a_change_of_phi(kind, data, time):
    effect = data.draw(effects(kind))
    assume(abs(time - effect.time) > 1e-3)  # it jumps there
    change = effect.phi_change(time, effect.values)
    assert_partials(change.by_parameters, lambda v: effect.phi_change(time, v).value, effect.values)


@every_sensor
@given(data=st.data(), wrench=spatial_wrenches, rates=vectors(8, -2.0, 2.0))
def test_partials_and_inverse_of_a_sensor(kind, data, wrench, rates):
    effect = data.draw(effects(kind))
    hand = HandMotion.of(rates[:3], rates[3:6], np.append(rates[6:], 1.0))
    corrected = effect.corrected(wrench, effect.values, hand)
    by_memory = np.eye(6) if corrected.by_memory is None else corrected.by_memory
    assert_partials(by_memory, lambda w: effect.corrected(w, effect.values, hand).value, wrench)
    assert_partials(corrected.by_parameters, lambda v: effect.corrected(wrench, v, hand).value, effect.values)
    recorded = effect.recorded(wrench, effect.values, hand)
    np.testing.assert_allclose(effect.corrected(recorded, effect.values, hand).value, wrench, atol=1e-12)
    at_rest = effect.corrected(wrench, effect.values).value
    assert kind.feels_motion or np.array_equal(corrected.value, at_rest)
    assert kind.moves_pose or not effect.pose_tb(effect.values).any()


@every_force
@fewer
@given(data=st.data())
def test_a_force_is_zero_where_it_is_absent(kind, data):
    trial = data.draw(trials(kind))
    absent = replace(trial, effect=without(trial.effect))
    contribution = absent.contribution()
    assert not contribution.value.any()
    for partial in (
        contribution.by_pose,
        contribution.by_velocity,
        contribution.by_phi,
        contribution.by_memory,
    ):
        assert partial is None or not partial.any()


@every_change
@given(time=numbers(-40, 40))
def test_a_change_of_phi_is_zero_where_it_is_absent(kind, time):
    assert not kind.phi_change(time, without(kind).values).value.any()


@every_sensor
@given(data=st.data(), wrench=spatial_wrenches)
def test_a_sensor_is_true_where_its_effect_is_absent(kind, data, wrench):
    absent = without(data.draw(effects(kind)))
    np.testing.assert_array_equal(absent.recorded(wrench, absent.values), wrench)
    np.testing.assert_array_equal(absent.corrected(wrench, absent.values).value, wrench)


@pytest.mark.parametrize("kind", [k for k in FORCE_EFFECTS if not gives_energy(k)], ids=title)
@given(data=st.data())
def test_dissipation_never_gives_energy(kind, data):
    """But for rounding, of what adds up and of what an effect works out from its values."""
    trial = data.draw(trials(kind, at_least=0.0 if kind.name in SIGNED else -np.inf))
    velocity = trial.situation.velocity_b
    parts = trial.wrench() * velocity
    rounded = np.abs(parts).sum() + np.abs(trial.effect.values).max() * np.abs(velocity).sum()
    assert parts.sum() <= 1e-14 * rounded


@pytest.mark.parametrize("kind", [k for k in FORCE_EFFECTS if title(k) != "learned_force drag speed"], ids=title)
@fewer
@given(data=st.data())
def test_stiction_reaches_what_rolling_would_give_and_fades(kind, data):
    """At rest the columns, each taken from -1 to 1 times, hold any wrench that the effect has when moving."""
    trial = data.draw(trials(kind))
    at_rest = replace(trial, situation=replace(trial.situation, velocity_b=np.zeros(3)))
    columns = at_rest.contribution("stiction")
    assert (columns is not None) == is_coulomb(kind)
    if columns is None:
        return
    moving = trial.wrench()
    fit = lsq_linear(columns, moving, bounds=(-1.0, 1.0), method="bvls")  # which ends on the bounds
    np.testing.assert_allclose(columns @ fit.x, moving, atol=1e-4 * (1 + np.abs(columns).sum()))
    assert not replace(at_rest, effect=without(trial.effect)).contribution("stiction").any()
    # no wheel stands still while rolling and turning so, and a caster that already points along one of both motions
    # swivels in the other; level s²/v² is left of each
    fast = [replace(trial.situation, velocity_b=np.array([50.0, turn * 20.0, turn])) for turn in (1.0, -1.0)]
    left = [np.abs(replace(trial, situation=situation).contribution("stiction")) for situation in fast]
    assert np.minimum(*left).max() <= 1e-3 * np.abs(columns).max()


@every_force
@fewer
@given(data=st.data())
def test_broadcasting_equals_looping(kind, data):
    """Three situations against two sets of parameters; time, pose, velocity, phi and memory stacked."""
    trial = data.draw(trials(kind))
    others = [data.draw(trials(kind)) for _ in range(2)]
    rows = [
        trial,
        *(replace(o, situation=replace(o.situation, wheels=trial.situation.wheels)) for o in others),
    ]
    n = len(trial.memory)
    memory = np.array([np.resize(np.append(row.memory, 0.1), n) for row in rows])
    stacked = replace(
        trial.situation,
        time=np.array([row.situation.time for row in rows]),
        pose_sb=np.array([row.situation.pose_sb for row in rows]),
        velocity_b=np.array([row.situation.velocity_b for row in rows]),
        phi=np.array([row.situation.phi for row in rows]),
    )
    values = np.array([trial.values, others[0].values])
    for method in ("wrench_b", "memory_rate"):
        together = getattr(trial.effect, method)(stacked, memory, values[:, None])
        for i, own in enumerate(values):
            for j, row in enumerate(rows):
                alone = getattr(trial.effect, method)(row.situation, memory[j], own)
                for name in ("value", *PARTIALS.values()):
                    one, many = getattr(alone, name), getattr(together, name)
                    assert (one is None) == (many is None)
                    if one is not None:
                        many = np.broadcast_to(many, (2, 3, *one.shape))
                        np.testing.assert_allclose(many[i, j], one, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", INERTIA_EFFECTS + SENSOR_EFFECTS, ids=title)
@given(data=st.data(), stack=st.lists(spatial_wrenches, min_size=3, max_size=3))
def test_broadcasting_of_sensors_and_inertia_equals_looping(kind, data, stack):
    drawn = [data.draw(effects(kind)) for _ in range(2)]
    values = np.array([effect.values for effect in drawn])

    def contribution(at, parameters):
        if isinstance(kind, SensorEffect):
            return drawn[0].corrected(at, parameters)
        return drawn[0].phi_change(at if np.ndim(at) < 2 else at[:, 0], parameters)

    for at in (np.array(stack), np.array(stack)[:1]):
        together = contribution(at, values[:, None])
        for i, own in enumerate(values):
            for j, one in enumerate(at):
                alone = contribution(one if isinstance(kind, SensorEffect) else one[0], own)
                np.testing.assert_allclose(together.value[i, j], alone.value, atol=1e-12)
                many = np.broadcast_to(together.by_parameters, (2, len(at), *alone.by_parameters.shape))
                np.testing.assert_allclose(many[i, j], alone.by_parameters, atol=1e-12)


@every_fixed_effect
def test_values_outside_the_bounds_are_refused(kind):
    for parameter in kind.parameters:
        wrong = [np.nan, np.inf, -np.inf]
        wrong += [np.nextafter(parameter.lower, -np.inf)] if np.isfinite(parameter.lower) else []
        wrong += [np.nextafter(parameter.upper, np.inf)] if np.isfinite(parameter.upper) else []
        for value in wrong:
            with pytest.raises(UsageError, match=rf"^{kind.name}\.{parameter.name}: .*(finite|outside)"):
                replace(kind, **{parameter.name: value})
    for low, high in kind.ordered:
        with pytest.raises(UsageError, match=rf"{kind.name}\.{low}: 2 is above {high} = 1"):
            replace(kind, **{low: 2.0, high: 1.0})


@every_effect
@fewer
@given(data=st.data())
def test_with_values_brings_them_inside_the_bounds(kind, data):
    wanted = [data.draw(numbers(-100, 100)) for _ in kind.parameters]
    names = [p.name for p in kind.parameters]
    for low, high in kind.ordered:
        i, j = names.index(low), names.index(high)
        wanted[i], wanted[j] = sorted((wanted[i], wanted[j]))
    effect = replace(kind, label="left").with_values(wanted)
    assert effect.label == "left"
    for parameter, value, got in zip(kind.parameters, wanted, effect.values, strict=True):
        assert got == min(max(value, parameter.lower), parameter.upper)


@every_effect
@fewer
@given(data=st.data())
def test_cart_file_round_trip(kind, data):
    effect = data.draw(effects(kind))
    cart = CartModel(Inertia(200.0, (0.3, 0.1), 200.0), effects=(effect,))  # so that a load can be taken off
    assert cart_from_text(cart_text(cart)) == cart
    assert cart.parameter_names[4:] == effect.keys
