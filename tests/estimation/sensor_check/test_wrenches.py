"""Force sensors that are reversed, turned, of another frame or unit: told per arm, and not told of sound ones."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog
from estimation.sensor_check import wrench_suspicions
from estimation.sensor_check.wrench_readings import RECORDED_WRENCH_UNITS, mountings
from estimation.sensor_check.wrenches import _has_signal, balances_of, judged_wrenches
from estimation.weak_form.balances import Balances

from .logs import CART, QUIET, RAIL, cart_of, found, on_rail, sealed, two_hands, with_wrenches

SEEDS = st.integers(0, 3)
LBF, KGF, FOOT = 4.4482216, 9.80665, 1.3558179


def told(log, cart=CART):
    return wrench_suspicions(Balances.of(log, cart), cart)


def times(*factors):
    return lambda wrench: wrench * np.array(factors)


def taken(*columns):
    return lambda wrench: wrench[:, list(columns)]


FAULTS = {
    "of the other side": ("sign", times(-1, -1, -1, -1, -1, -1)),
    "fx reversed": ("sign", times(-1, 1, 1, 1, 1, 1)),
    "fy reversed": ("sign", times(1, -1, 1, 1, 1, 1)),
    "half a turn": ("sign", times(-1, -1, 1, -1, -1, 1)),
    "tz reversed": ("sign", times(1, 1, 1, 1, 1, -1)),
    "x and y swapped": ("axes", taken(1, 0, 2, 4, 3, 5)),
    "a quarter turn": ("axes", lambda w: w[:, [1, 0, 2, 4, 3, 5]] * [1, -1, 1, 1, -1, 1]),
    "z ahead": ("axes", taken(1, 2, 0, 4, 5, 3)),
    "kgf": ("unit", times(*[1 / KGF] * 6)),
    "lbf": ("unit", times(*[1 / LBF] * 3, *[1 / FOOT] * 3)),
    "kN": ("unit", times(*[1e-3] * 6)),
    "N·cm": ("unit", times(1, 1, 1, 100, 100, 100)),
    "N·mm": ("unit", times(1, 1, 1, 1000, 1000, 1000)),
}


@pytest.mark.some(13)
@pytest.mark.long
@pytest.mark.parametrize("arms", [("left", "right"), ("left",)])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_of_the_arm_that_has_it(name, arms):
    kind, change = FAULTS[name]
    suspicions = told(with_wrenches(two_hands(0), change, arms))
    assert found(suspicions).keys() == {(kind, arm) for arm in arms}
    assert min(one.probability for one in suspicions) > 0.9


@pytest.mark.long
@settings(max_examples=8)
@given(SEEDS, st.sampled_from([name for name, (kind, _) in FAULTS.items() if kind != "unit"]), st.floats(0.4, 2.5))
def test_signs_and_axes_need_no_good_guess_of_the_mass(seed, name, guess):
    kind, change = FAULTS[name]
    suspicions = found(told(with_wrenches(two_hands(seed), change), cart_of(guess)))
    assert {key for key, p in suspicions.items() if p > 0.9} == {(kind, "left"), (kind, "right")}


@pytest.mark.long
@settings(max_examples=8)
@given(SEEDS, st.floats(0.34, 2.9))
def test_a_wrong_guess_of_the_mass_is_no_fault(seed, guess):
    """From a third to nearly three times."""
    assert told(two_hands(seed), cart_of(guess)) == ()


@pytest.mark.long
@settings(max_examples=8)
@given(SEEDS, st.floats(-0.1, 0.1), st.floats(0.75, 1.25), st.floats(-6.0, 6.0), st.integers(0, 5))
def test_small_faults_are_no_wrong_axes(seed, angle, gain, offset, rows):
    """A sensor turned by 0.1 rad, of another gain, with an offset, late by a few rows: effects with own names."""
    c, s = np.cos(angle), np.sin(angle)

    def change(wrench):
        turned = wrench.copy()
        turned[:, 0], turned[:, 1] = c * wrench[:, 0] + s * wrench[:, 1], c * wrench[:, 1] - s * wrench[:, 0]
        return gain * np.roll(turned, rows, axis=0) + offset * np.array([1, 1, 1, 0.1, 0.1, 0.1])

    assert told(with_wrenches(two_hands(seed), change, ("right",))) == ()


@pytest.mark.parametrize("name", ["of the other side", "fx reversed", "x and y swapped", "kN"])
def test_of_ten_seconds_much_is_told(name):
    kind, change = FAULTS[name]
    log = two_hands(0, duration=10.0)
    assert told(log) == ()
    assert {key for key, p in found(told(with_wrenches(log, change))).items() if p > 0.9} == {
        (kind, "left"),
        (kind, "right"),
    }


def test_what_is_only_noise_has_no_sign():
    """An offset is none either; a slow push far below the noise of a sample is one."""
    log = two_hands(0)
    random, slow = np.random.default_rng(1), 0.5 * np.sin(log.time)
    noise = random.normal(0, 1.0, (len(log.time), 6))
    columns = [noise[:, 0], noise[:, 1] + 5.0, noise[:, 2] + slow, slow, 0 * slow, 10 * noise[:, 5]]
    arms = log.arms | {"left": ArmLog(log.arms["left"].contact, np.column_stack(columns))}
    assert _has_signal(replace(log, arms=arms), "left").tolist() == [False, False, True, True, False, False]
    assert _has_signal(log, "left")[[0, 1, 5]].all()


def test_what_cannot_be_judged_is_said():
    log = two_hands(0, duration=4.0)
    assert judged_wrenches(Balances.of(log, CART), CART) == ((), "the cart moves too little, or for too short a time")
    assert judged_wrenches(Balances.of(two_hands(0), CART), CART) == ((), "")
    assert judged_wrenches(Balances.of(replace(log, arms={}), CART), CART) == ((), "")


@pytest.mark.some(4)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("begin", [3.0, 12.0, 20.0])
def test_somebody_who_pushes_is_no_fault_of_a_sensor(seed, begin):
    """Hands that give 60 N less for 9 s, since somebody else gives it. Before, eight of these were refused for units
    and axes."""
    log = two_hands(seed)
    other = np.outer((log.time > begin) & (log.time < begin + 9.0), [30.0, 0, 0, 0, 0, 0])
    cart, felt = cart_of(0.67), with_wrenches(log, lambda wrench: wrench - other)
    told = wrench_suspicions(Balances.of(felt, cart), cart)
    assert [one for one in told if one.is_refused] == []


@pytest.mark.parametrize("arms", [("left", "right"), ("left",)])
def test_forces_of_the_world_are_told(arms):
    log = two_hands(0)
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])

    def change(wrench):
        fx, fy, *rest = wrench.T
        return np.column_stack([c * fx - s * fy, s * fx + c * fy, *rest])

    assert found(told(with_wrenches(log, change, arms))).keys() == {("frame", arm) for arm in arms}


def test_on_a_rail_only_the_mass_speaks_of_units():
    """Kilogrammes are sure; pounds, of a guess that may be 1.65 times off, are told but stop nothing."""
    kilogrammes = told(with_wrenches(on_rail(), times(*[1 / KGF] * 6)), RAIL)
    assert kilogrammes[0].is_refused
    pounds = found(told(with_wrenches(on_rail(), times(*[1 / LBF] * 6)), RAIL))
    assert 0.25 < pounds["unit", "hand"] < 0.9


def test_the_words_tell_masses_and_the_cure():
    reversed_arm = told(with_wrenches(on_rail(), times(-1, 1, 1, 1, 1, 1)), RAIL)[0]
    assert "mass of -2" in reversed_arm.words
    assert reversed_arm.factor == -1.0
    in_kilonewtons = told(with_wrenches(on_rail(), times(*[1e-3] * 6)), RAIL)[0]
    assert in_kilonewtons.factor == 1000.0
    assert "kN" in in_kilonewtons.words
    assert "multiply forces by 1000" in in_kilonewtons.words


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "mm"), (100.0, "cm")])
def test_contact_points_in_another_unit_are_told(factor, unit):
    log = two_hands(0)
    arms = {name: ArmLog(factor * arm.contact, arm.wrench) for name, arm in log.arms.items()}
    suspicions = told(replace(log, arms=arms))
    assert found(suspicions).keys() == {("unit", "left"), ("unit", "right")}
    assert all(f"in {unit}:" in one.words and one.factor == pytest.approx(1 / factor) for one in suspicions)


def test_nothing_is_told_where_nothing_moves_or_pushes():
    log = two_hands(0)
    assert told(with_wrenches(log, lambda wrench: 0 * wrench)) == ()
    assert told(replace(log, pose=0 * log.pose, velocity=0 * log.velocity)) == ()
    assert told(replace(log, arms={})) == ()


def test_balances_are_those_of_the_plant():
    """With no noise what is left of both sides is in proportion, by the mass and the yaw inertia about {b}'s origin.
    The integrator's wrenches hold until the next row, so they are half a row early."""
    log = two_hands(0, QUIET)
    forward, sideways, turning = balances_of(Balances.of(log, CART).late(-0.005).every(0.4), CART)
    assert sideways is None
    about_origin = 2.0 + 24.0 * (0.3**2 + 0.05**2)
    for balance, wanted in ((forward, 24.0), (turning, about_origin)):
        wrench = np.einsum("kaij,ij->k", balance.signals, mountings()[0].taken)
        assert (balance.motion @ wrench) / (balance.motion @ balance.motion) == pytest.approx(wanted, rel=1e-3)


def test_the_table_of_mountings_is_whole():
    """The sound one is the identity, and each takes one component for each of fx, fy and tz."""
    sound, *wrong = mountings()
    assert np.argwhere(sound.taken).tolist() == [[0, 0], [1, 1], [2, 5]]
    assert {one.kind for one in wrong} == {"sign", "axes", "frame"}
    assert all(np.abs(one.taken).sum(axis=1).tolist() == [1, 1, 1] for one in wrong)
    assert 0.05 < sum(one.odds for one in wrong) < 0.2
    assert next(iter(RECORDED_WRENCH_UNITS.values())) == (1.0, 1.0)


@pytest.mark.long
@pytest.mark.some(4)
@pytest.mark.parametrize("guess", [0.4, 1.0, 2.5])
@pytest.mark.parametrize(
    ("case", "seed"),
    [
        ("force_bias", 0),
        ("force_misalignment", 1),
        ("payload_change", 1),
        ("caster_realignment", 2),
        ("force_scale", 0),
    ],
)
def test_hidden_effects_raise_no_alarm_whatever_the_guess(case, seed, guess):
    log, cart = sealed(case, seed)
    inertia = cart.inertia
    off = cart.with_inertia(replace(inertia, mass=guess * inertia.mass, about_com=guess * inertia.about_com))
    assert told(log, off) == ()
