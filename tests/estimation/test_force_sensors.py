"""Force sensors that are reversed, turned, of another frame or unit: told per arm, and not told of sound ones."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.cart_file import cart_from_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation.sensor_check import check_sensors
from estimation.sensor_check.prior import MOUNTINGS, UNITS
from estimation.sensor_check.wrench.arm_faults import arm_suspicions, sure_reading, with_reading
from estimation.sensor_check.wrench.balance import balances
from estimation.sensor_check.wrench.casters import caster_forces
from estimation.sensor_check.wrench.mountings import mountings
from estimation.sensor_check.wrench.sensor_readings import readings_of, sensor_check

from .sensor_logs import CART, RAIL, cart_of, found, on_rail, sealed, two_hands, with_wrenches

SEEDS = st.integers(0, 3)
HARD = {"sign", "unit", "axes", "frame"}
LBF, KGF, FOOT = 4.4482216, 9.80665, 1.3558179


def times(*factors):
    return lambda wrench: wrench * np.array(factors)


def taken(*columns):
    return lambda wrench: wrench[:, list(columns)]


FAULTS = {
    "of the other side": ("sign", times(-1, -1, -1, -1, -1, -1)),
    "fx reversed": ("sign", times(-1, 1, 1, 1, 1, 1)),
    "fy reversed": ("sign", times(1, -1, 1, 1, 1, 1)),
    "half a turn": ("sign", times(-1, -1, 1, -1, -1, 1)),
    "tz reversed": ("axes", times(1, 1, 1, 1, 1, -1)),
    "z down": ("axes", times(1, -1, -1, 1, -1, -1)),
    "x and y swapped": ("axes", taken(1, 0, 2, 4, 3, 5)),
    "a quarter turn": ("axes", lambda w: w[:, [1, 0, 2, 4, 3, 5]] * [1, -1, 1, 1, -1, 1]),
    "z ahead": ("axes", taken(1, 2, 0, 4, 5, 3)),
    "kgf": ("unit", times(*[1 / KGF] * 6)),
    "lbf": ("unit", times(*[1 / LBF] * 3, *[1 / FOOT] * 3)),
    "kN": ("unit", times(*[1e-3] * 6)),
    "N·cm": ("unit", times(1, 1, 1, 100, 100, 100)),
    "N·mm": ("unit", times(1, 1, 1, 1000, 1000, 1000)),
}


@pytest.mark.parametrize("arms", [("left", "right"), ("left",)])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_of_the_arm_that_has_it(name, arms):
    kind, change = FAULTS[name]
    told = found(check_sensors(with_wrenches(two_hands(0), change, arms), CART))
    assert set(told) == {(kind, arm) for arm in arms}
    assert min(told.values()) > 0.9


@settings(max_examples=25)
@given(SEEDS, st.sampled_from([name for name, (kind, _) in FAULTS.items() if kind != "unit"]), st.floats(0.4, 2.5))
def test_signs_and_axes_need_no_good_guess_of_the_mass(seed, name, guess):
    kind, change = FAULTS[name]
    told = found(arm_suspicions(with_wrenches(two_hands(seed), change), cart_of(guess)))
    assert told.keys() == {(kind, "left"), (kind, "right")}
    assert min(told.values()) > 0.9


@settings(max_examples=25)
@given(SEEDS, st.floats(0.4, 2.5))
def test_a_wrong_guess_of_the_mass_is_no_fault(seed, guess):
    assert arm_suspicions(two_hands(seed), cart_of(guess)) == ()


@settings(max_examples=25)
@given(SEEDS, st.floats(-0.1, 0.1), st.floats(0.75, 1.25), st.floats(-6.0, 6.0), st.integers(0, 5))
def test_small_faults_are_no_wrong_axes(seed, angle, gain, offset, rows):
    """A sensor turned by 0.1 rad, of another gain, with an offset, late by a few rows: effects with own names."""
    c, s = np.cos(angle), np.sin(angle)

    def change(wrench):
        turned = wrench.copy()
        turned[:, 0], turned[:, 1] = c * wrench[:, 0] + s * wrench[:, 1], c * wrench[:, 1] - s * wrench[:, 0]
        return gain * np.roll(turned, rows, axis=0) + offset * np.array([1, 1, 1, 0.1, 0.1, 0.1])

    assert arm_suspicions(with_wrenches(two_hands(seed), change, ("right",)), CART) == ()


@settings(max_examples=15)
@given(SEEDS, st.booleans())
def test_forces_of_the_world_are_told(seed, one):
    log = two_hands(seed)
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])

    def change(wrench):
        fx, fy, *rest = wrench.T
        return np.column_stack([c * fx - s * fy, s * fx + c * fy, *rest])

    arms = ("left",) if one else ("left", "right")
    told = found(arm_suspicions(with_wrenches(log, change, arms), CART))
    assert told.keys() == {("frame", arm) for arm in arms}


@settings(max_examples=8)
@given(st.integers(0, 1), st.floats(0.8, 1.1))
def test_a_unit_is_weighed_with_how_sure_the_mass_is(seed, guess):
    """On a rail nothing but the mass speaks of units. A weighed one tells pounds from newtons, a guess at most half."""
    log = with_wrenches(on_rail(seed), times(*[1 / LBF] * 6))
    rail = replace(RAIL, inertia=cart_of(guess).inertia)
    sure = found(arm_suspicions(log, rail, mass_spread=0.2))
    assert sure[("unit", "hand")] > 0.9
    guessed = found(arm_suspicions(log, rail))
    assert guessed.get(("unit", "hand"), 0.0) < 0.9
    kilogrammes = with_wrenches(on_rail(seed), times(*[1 / KGF] * 6))
    assert found(arm_suspicions(kilogrammes, rail))[("unit", "hand")] > 0.9


def test_the_words_tell_masses_and_the_cure():
    reversed_arm = arm_suspicions(with_wrenches(on_rail(), times(-1, 1, 1, 1, 1, 1)), RAIL)[0]
    assert "mass of -2" in reversed_arm.words
    assert reversed_arm.factor == -1.0
    in_kilonewtons = arm_suspicions(with_wrenches(on_rail(), times(*[1e-3] * 6)), RAIL)[0]
    assert in_kilonewtons.factor == 1000.0
    assert "kN" in in_kilonewtons.words
    assert "multiply forces by 1000" in in_kilonewtons.words


def on_casters(seed=0):
    """A cart that goes any way, on paths in closed form: wrenches are what its accelerations and drags take."""
    time = 0.01 * np.arange(4000)
    random = np.random.default_rng(seed)
    place = [np.sin(0.5 * time) + 0.4 * np.sin(1.3 * time + 1), 0.8 * np.cos(0.7 * time) + 0.3 * np.sin(1.1 * time)]
    x, y, theta = [*place, 0.8 * np.sin(0.3 * time) + 0.3 * np.sin(0.9 * time)]
    vx, vy, r = (np.gradient(one, time) for one in (x, y, theta))
    ax, ay, dr = (np.gradient(one, time) for one in (vx, vy, r))
    mass, (dx, dy), about = 30.0, (0.2, -0.1), 3.0
    c, s = np.cos(theta), np.sin(theta)
    u, w, du, dw = c * vx + s * vy, c * vy - s * vx, c * ax + s * ay, c * ay - s * ax
    fx = mass * (du - dy * dr - dx * r**2) + 4.0 * u
    fy = mass * (dw + dx * dr - dy * r**2) + 4.0 * w
    inertia = about + mass * (dx**2 + dy**2)
    tau = inertia * dr + mass * (dx * dw - dy * du) + 1.5 * r
    point = np.array([-0.4, 0.2, 1.0])
    wrench = np.zeros((len(time), 6))
    wrench[:, 0], wrench[:, 1], wrench[:, 5] = fx, fy, tau - point[0] * fy + point[1] * fx
    wrench += np.array([3, 3, 3, 0.15, 0.15, 0.15]) * random.standard_normal(wrench.shape)
    pose = np.column_stack([x, y, theta]) + 5e-4 * random.standard_normal((len(time), 3))
    return RunLog(time, pose, None, {"arm": ArmLog(np.tile(point, (len(time), 1)), wrench)})


FREE = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), RollingConstraints(axle_x=None))


def test_a_cart_on_casters_is_sound():
    assert check_sensors(on_casters(), FREE) == ()
    found_balances = balances(on_casters(), FREE)
    for balance, how in ((found_balances.forward, "forward"), (found_balances.sideways, "sideways")):
        signal = balance.signals["arm"] @ getattr(mountings()[0], how)(1.0)
        assert np.linalg.lstsq(balance.motion[:, None], signal)[0][0] == pytest.approx(30.0, rel=0.02)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_on_casters_too(name):
    kind, change = FAULTS[name]
    told = found(arm_suspicions(with_wrenches(on_casters(), change), FREE))
    assert told.keys() == {(kind, "arm")}
    assert told[kind, "arm"] > 0.9


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "mm"), (100.0, "cm")])
def test_contact_points_in_another_unit_are_told(factor, unit):
    log = two_hands(0)
    arms = {name: ArmLog(factor * arm.contact, arm.wrench) for name, arm in log.arms.items()}
    told = check_sensors(replace(log, arms=arms), CART)
    assert found(told).keys() == {("unit", "left"), ("unit", "right")}
    assert min(one.probability for one in told) > 0.9
    assert all(f"in {unit}," in one.words and one.factor == pytest.approx(1 / factor) for one in told)


def test_components_that_nobody_measures_count_for_nothing():
    """A sensor of fx alone, on a rail: blank columns are no missing rows."""
    blank = with_wrenches(on_rail(), lambda w: w * np.array([1, *[np.nan] * 5]))
    assert arm_suspicions(blank, RAIL) == ()
    told = arm_suspicions(with_wrenches(blank, lambda w: -w), RAIL)
    assert found(told)["sign", "hand"] > 0.9


def test_two_arms_with_faults_of_their_own_are_both_told():
    log = with_wrenches(two_hands(0), times(-1, -1, -1, -1, -1, -1), ("left",))
    log = with_wrenches(log, times(*[1 / KGF] * 6), ("right",))
    told = found(arm_suspicions(log, CART))
    assert told.keys() >= {("sign", "left"), ("unit", "right")}


@pytest.mark.parametrize("name", FAULTS)
def test_a_sure_reading_gives_the_wrench_back(name):
    log = two_hands(1)
    wrong = with_wrenches(log, FAULTS[name][1])
    right = with_reading(wrong, sure_reading(sensor_check(wrong, CART)))
    for arm in log.arms:
        planar = log.arms[arm].wrench[:, [0, 1, 5]]
        assert right.arms[arm].wrench[:, [0, 1, 5]] == pytest.approx(planar, abs=1e-4)


def test_nothing_is_told_where_nothing_moves_or_pushes():
    log = two_hands(0)
    silent = with_wrenches(log, lambda wrench: 0 * wrench)
    assert arm_suspicions(silent, CART) == ()
    still = replace(log, pose=0 * log.pose, velocity=0 * log.velocity)
    assert not {kind for kind, _ in found(check_sensors(still, CART))} & HARD


def test_blank_cells_are_no_wrenches():
    log = two_hands(0)
    blank = {}
    for name, arm in log.arms.items():
        wrench = arm.wrench.copy()
        wrench[::3] = np.nan
        blank[name] = ArmLog(arm.contact, wrench)
    assert arm_suspicions(replace(log, arms=blank), CART) == ()


# --- parts --------------------------------------------------------------------------------------------------


def test_the_table_of_mountings_is_whole():
    """Every probability is shared out, the sound one is the identity, and no two ways look alike to the balances but
    those that differ in what no balance sees."""
    known = mountings()
    assert sum(one.prior for one in known) == pytest.approx(1.0)
    assert known[0].prior == pytest.approx(1 - sum(MOUNTINGS.values()))
    assert known[0].force.tolist() == [[1, 0, 0], [0, 1, 0]]
    assert {one.kind for one in known} == {"", "sign", "axes", "frame"}
    for one in known:
        assert np.abs(one.force).sum() == 2
        assert np.abs(one.moment).sum() == 1
    assert sum(one.prior for one in UNITS) == pytest.approx(1.0)
    for arms in (("a",), ("a", "b"), ("a", "b", "c")):
        total = sum(one.prior for one in readings_of(arms))
        assert total == pytest.approx(1.0, abs=1e-9)


def test_balances_are_those_of_the_plant():
    """With no noise what is left of both sides is in proportion, by the mass and the yaw inertia about {b}'s origin."""
    log = two_hands(0, (0.0, 0.0, 0.0))
    found_balances = balances(log, CART)
    forward, turning = found_balances.forward, found_balances.turning
    sound = mountings()[0]
    force = sum(forward.signals[a] @ sound.forward(1.0) for a in log.arms)
    assert np.linalg.lstsq(forward.motion[:, None], force)[0][0] == pytest.approx(24.0, rel=0.01)
    moment = sum(turning.signals[a] @ sound.turning(1.0, 1.0) for a in log.arms)
    about_origin = 2.0 + 24.0 * (0.3**2 + 0.05**2)
    assert np.linalg.lstsq(turning.motion[:, None], moment)[0][0] == pytest.approx(about_origin, rel=0.02)


@settings(max_examples=15)
@given(st.floats(0.2, 1.0), st.floats(0.3, 1.2), st.floats(0.03, 0.08))
def test_casters_only_take_energy(speed, turning, trail):
    """Their power is what friction takes, never more than the torque times how fast they swing: over a reversal with a
    turn they swing about half round."""
    time = 0.005 * np.arange(2000)
    u = speed * np.sign(np.sin(0.7 * time))
    r = turning * np.cos(0.9 * time)
    heading = np.concatenate([[0.0], np.cumsum(r[:-1] * 0.005)])
    cart = replace(CART, wheels=(Wheel("caster", 0.7, 0.2, trail),))
    forces = caster_forces(cart, time, heading, np.column_stack([u, 0 * u, r]))
    power = forces[:, 0] * u + forces[:, 1] * r
    assert (power < 1e-6).all()
    assert -power.sum() * 0.005 > 0.3
    assert np.array_equal(caster_forces(CART, time, heading, np.zeros((2000, 3))), np.zeros((2000, 2)))


def test_a_caster_behind_a_reversal_is_the_effect_s():
    """The same path through the effect that simulator and filter share."""
    text = (
        "name: c\nmass: 24.0\ncom: [0.3, 0.0]\ninertia: 2.0\nconstraints:\n  - no_lateral_slip: {x: 0.0}\nwheels:\n"
        "  - {kind: fixed, x: 0.0, y: 0.25}\n  - {kind: fixed, x: 0.0, y: -0.25}\n"
        "  - {kind: caster, x: 0.7, y: 0.2, trail: 0.05}\neffects:\n"
        "  caster_realignment: {swivel_torque: 1.0, trail: 0.0}\n"
    )
    cart = cart_from_text(text, "casters")
    time = 0.002 * np.arange(3000)
    u, r = 0.5 * np.sin(0.9 * time + 0.3), 0.4 * np.cos(1.1 * time)
    heading = np.concatenate([[0.0], np.cumsum((r[1:] + r[:-1]) / 2 * 0.002)])
    pose = np.column_stack([0 * time, 0 * time, heading])
    memory = cart.memory_along(pose, np.column_stack([u, r]), time)
    wanted = cart.effect_wrench(np.column_stack([pose, u, r, memory]))
    ours = caster_forces(cart, time, heading, np.column_stack([u, 0 * u, r]))
    late = time > 1.0
    assert np.abs(ours[late, 0] - wanted[late, 0]).mean() < 0.05 * np.abs(wanted[late, 0]).mean()
    assert np.abs(ours[late, 1] - wanted[late, 2]).mean() < 0.05 * np.abs(wanted[late, 2]).mean()


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
    assert arm_suspicions(log, off) == ()
