"""The parts of the discrepancy workflow against closed forms and motions of the tests' own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import (
    CasterRealignment,
    FloorPatch,
    LateralSlip,
    RollingResistance,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.errors import DataError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation import FilterNoise
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy import rollouts
from estimation.discrepancy.evidence import Finding
from estimation.discrepancy.fitted import SURE, Fitted
from estimation.discrepancy.gap import measured_gap
from estimation.discrepancy.generic import Course, dependences
from estimation.discrepancy.log_check import check_rows, checked, moving
from estimation.discrepancy.manoeuvres import manoeuvres, settled
from estimation.discrepancy.rollouts import Rollouts, roll_out, starts
from estimation.discrepancy.scatter import Scatter
from estimation.discrepancy.selection import _sideways
from estimation.discrepancy.sideways import SidewaysTrial, sideways_trials

from .runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)


DRAG = (ViscousDrag(linear=3.0, angular=1.2),)


def guess(effects=DRAG):
    return CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=effects)


def straight(acceleration=0.5, duration=4.0, mass=20.0):
    """A log without noise of a cart that a constant force pushes along x; no drag."""
    time = np.arange(0, duration, 0.01)
    zero = np.zeros_like(time)
    wrench = np.column_stack([np.full_like(time, mass * acceleration), zero, zero, zero, zero, zero])
    pose = np.column_stack([acceleration * time**2 / 2, zero, zero])
    velocity = np.column_stack([acceleration * time, zero, zero])
    return RunLog(time, pose, velocity, {"arm": ArmLog(np.tile([-0.3, 0.0, 1.0], (len(time), 1)), wrench)})


def test_a_rollout_of_a_wrong_mass_errs_by_its_acceleration():
    cart = CartModel(Inertia(25.0, (0.3, 0.0), 2.0))
    regression = WrenchRegression(straight(), cart, None)
    first = starts(regression, np.ones(len(regression.motion.time), dtype=bool), 1.0, 0.5)
    found = roll_out(regression, cart, 0.5, first, 1.0)
    assert len(first) >= 4
    assert found.error[:, 0] == pytest.approx(0.5 * (20.0 / 25.0 - 1.0) / 2, abs=2e-4)
    assert found.error[:, 1:] == pytest.approx(0.0, abs=1e-6)
    assert found.gap == pytest.approx(0.05, abs=3e-4)


def test_rollouts_of_stiff_swivels_are_those_of_finer_steps(monkeypatch):
    """A light cart on heavy casters: in steps of 5 ms it would shake itself off its way."""
    wheels = (Wheel("fixed", 0.0, 0.2), Wheel("fixed", 0.0, -0.2), Wheel("caster", 0.8, 0.2, 0.04))
    cart = CartModel(Inertia(12.0, (0.28, 0.06), 1.0), effects=(*DRAG, CasterRealignment(0.8)), wheels=wheels)
    log, _ = simulate(TRUTH, 0, 12.0)
    regression = WrenchRegression(log, cart, None)
    first = starts(regression, np.ones(len(regression.motion.time), dtype=bool), 1.0, 0.5)
    found = roll_out(regression, cart, 0.5, first, 1.0).error
    monkeypatch.setattr(rollouts, "STEP", 2e-4)
    assert found == pytest.approx(roll_out(regression, cart, 0.5, first, 1.0).error, abs=1e-3)


@pytest.mark.parametrize("curved", [False, True])
def test_places_everywhere_are_the_whole_floor(curved):
    """Under each wheel: on a straight way, that of the axle's middle meets none."""
    wheels = (Wheel("fixed", 0.0, 0.25), Wheel("fixed", 0.0, -0.25), Wheel("caster", 0.6, 0.2))
    cart = replace(guess(), wheels=wheels)
    log, _ = simulate(TRUTH, 0, 8.0, curved)
    dictionary = Fitted((WrenchRegression(log, cart, None),), cart).dictionary([FloorPatch(), RollingResistance()])
    p, sums = dictionary.n_base, dictionary.gram.sum(axis=0)
    cells, everywhere = dictionary.places.sum(axis=0), sums[dictionary.trials[-1].columns[0]]
    assert len(dictionary.places) > 4
    assert np.r_[cells[:p], cells[-1]] == pytest.approx(np.r_[everywhere[:p], everywhere[-1]], rel=1e-6)
    assert cells[p:-1].sum() == pytest.approx(everywhere[p], rel=1e-6)


def test_rollouts_stay_where_they_are_allowed():
    regression = WrenchRegression(straight(), guess(), None)
    chosen = regression.motion.time > 2.0
    first = starts(regression, chosen, 1.0, 0.25)
    assert regression.motion.time[first].min() > 2.0
    assert regression.motion.time[first].max() < 3.0


def rolling(angle=0.0, compliance=0.0, seed=0, mass=24.0, com_x=0.28):
    """A log of a cart that goes round in wide circles, forward and back, on wheels at an angle that creep by
    `compliance` (rad/N) under the force that keeps them on the circle; hands give what the rigid body needs."""
    random, fine = np.random.default_rng(seed), 0.0005
    time = np.arange(0, 20, fine)
    speed, turn = 0.6 * np.sin(0.5 * time), 0.5 * np.cos(0.3 * time)
    heading = np.sin(0.3 * time) * 0.5 / 0.3
    side = -mass * (speed * turn + com_x * np.gradient(turn, time))
    creep = compliance * np.abs(speed) * side
    towards = heading + angle
    velocity = np.column_stack(
        [speed * np.cos(towards) - creep * np.sin(towards), speed * np.sin(towards) + creep * np.cos(towards), turn]
    )
    pose = np.cumsum(velocity, axis=0) * fine
    pose[:, 2] = heading
    forward = mass * (np.gradient(speed, time) - com_x * turn**2)
    moment = (2.2 + mass * com_x**2) * np.gradient(turn, time) + mass * com_x * speed * turn
    rows = slice(None, None, 20)
    wrench = np.zeros((len(time[rows]), 6))
    wrench[:, 0], wrench[:, 5] = forward[rows], moment[rows]
    noisy = pose[rows] + 0.0005 * random.standard_normal(pose[rows].shape)
    measured = velocity[rows] + 0.005 * random.standard_normal(pose[rows].shape)
    contact = np.tile([0.0, 0.0, 1.0], (len(wrench), 1))
    return RunLog(time[rows], noisy, measured, {"arm": ArmLog(contact, wrench)})


@pytest.mark.parametrize("angle", [0.03, -0.01])
def test_wheels_at_an_angle_show_sideways(angle):
    regression = WrenchRegression(rolling(angle), guess(()), None)
    first = sideways_trials((regression,), regression.cart)[0].finding
    assert isinstance(first.effect, WheelMisalignment)
    assert first.log_factor > 20
    assert first.effect.angle == pytest.approx(angle, abs=3e-4)


@pytest.mark.parametrize("spoiled", [False, True])
def test_headings_are_taken_as_they_were_recorded(spoiled):
    """Smoothed as if wheels were square, they lean towards where the cart went; but for what is missing, or a slip of
    the tracker."""
    log, random = rolling(0.07), np.random.default_rng(1)
    pose = log.pose + [0.0013, 0.0013, 0.0034] * random.standard_normal(log.pose.shape)
    if spoiled:
        pose[400, 2] += 0.5
        pose[900:903, 2] = np.nan
    regression = WrenchRegression(replace(log, pose=pose, velocity=None), guess(()), None)
    lean = regression.motion.pose[:, 2] - log.pose[:, 2]
    assert np.abs(lean).mean() > 0.01
    first = sideways_trials((regression,), regression.cart)[0].finding
    assert isinstance(first.effect, WheelMisalignment)
    assert first.effect.angle == pytest.approx(0.07, abs=8e-4)


def test_creeping_wheels_show_sideways():
    regression = WrenchRegression(
        rolling(compliance=1 / 600.0), replace(guess(()), inertia=Inertia(24.0, (0.28, 0.0), 2.2)), None
    )
    first = sideways_trials((regression,), regression.cart)[0].finding
    assert isinstance(first.effect, LateralSlip)
    assert first.effect.cornering_stiffness == pytest.approx(600.0, rel=0.1)


def test_tyres_that_creep_fast_do_not_bend_the_motion():
    """Said to roll, the cart would be smoothed at speeds that nobody saw, where headings are all that they change."""
    log = rolling(compliance=1 / 30.0)
    motion = WrenchRegression(replace(log, velocity=None), guess(()), None).motion
    speed, turn = 0.6 * np.sin(0.5 * log.time), 0.5 * np.cos(0.3 * log.time)
    np.testing.assert_allclose(motion.velocity[50:-50], np.column_stack([speed, turn])[50:-50], atol=0.02)
    assert np.median(np.abs(motion.pose[:, 2] - np.sin(0.3 * log.time) * 0.5 / 0.3)) < 0.0003


@pytest.mark.parametrize("angle", [0.0, 0.01, 0.06])
def test_an_angle_beside_tyres_that_creep(angle):
    """It is told where it explains what they leave, also where it is a trifle beside them."""
    cart = guess(())
    _, fitted, steps = _sideways((WrenchRegression(rolling(angle, compliance=1 / 60.0), cart, None),), cart)
    assert {step.added.name for step in steps} == {"lateral_slip", *(["wheel_misalignment"] if angle else [])}
    if angle:
        assert next(e.angle for e in fitted.added if isinstance(e, WheelMisalignment)) == pytest.approx(angle, rel=0.05)


@pytest.mark.parametrize(
    ("effect", "gain", "speed", "expected"),
    [
        (WheelMisalignment(0.1), 0.6, 0.02, True),
        (WheelMisalignment(0.1), 0.6, 0.01, False),
        (WheelMisalignment(0.1), 0.9, 0.01, True),
        (LateralSlip(500.0), 0.6, 0.02, True),
        (LateralSlip(500.0), 0.9, 0.01, False),
    ],
)
def test_a_trifle_sideways_beside_much_may_be_of_its_form(effect, gain, speed, expected):
    """Beside 0.06 m/s: an angle is none unless it explains all that is left, and every tyre gives a little."""
    finding = Finding(effect, 50.0, 50.0, np.zeros(0, dtype=int), np.zeros(0), np.zeros(1))
    assert SidewaysTrial(finding, 1.0, gain, speed).is_worth(7.0, 0.05, 0.06) is expected
    assert SidewaysTrial(finding, 1.0, gain, speed).is_worth(7.0, 0.05, 0.0)


def test_wheels_that_hold_show_nothing_sideways():
    for trial in sideways_trials((WrenchRegression(rolling(seed=3), guess(()), None),), guess(())):
        assert trial.finding.log_factor < 0
        assert trial.speed < 0.002


@pytest.mark.parametrize(("correlation", "low", "high"), [(0.0, 1.0, 1.6), (0.8, 4.0, 14.0)])
def test_excess_tells_coloured_noise(correlation, low, high):
    """Long means of an autoregression have (1 + c) / (1 - c) times the variance that its samples promise."""
    log, cart = rolling(), guess(()).with_inertia(Inertia(24.0, (0.28, 0.0), 2.2))
    random = np.random.default_rng(2)
    noise = np.zeros((len(log), 2))
    for k in range(1, len(log)):
        noise[k] = correlation * noise[k - 1] + (1 - correlation**2) ** 0.5 * random.standard_normal(2)
    (name, arm), *_ = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, [0, 5]] += noise * [3.0, 0.3]
    noisy = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    told = FilterNoise(force=3.0, moment=0.3, position=0.0005, heading=0.0005)
    fitted = Fitted((WrenchRegression(noisy, cart, told),), cart)
    assert low <= fitted.scatter.excess < high


@pytest.mark.parametrize("is_drag", [False, True])
@pytest.mark.parametrize("turns_back", [False, True])
def test_a_force_with_the_wheels_turn_is_found_by_its_period(is_drag, turns_back):
    """Of the way rolled, which turns back where the cart does, or of the way travelled; a force or a drag."""
    log, _ = simulate(TRUTH, 3, 30.0, noise=(0.0005, 0.005, 1.0))
    regression = WrenchRegression(log, guess(), None)
    speed = regression.motion.velocity[:, 0]
    rolled = np.cumsum(np.append(0.0, np.diff(log.time)) * (speed if turns_back else np.abs(speed)))
    (name, arm), *_ = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] += 4.0 * np.sin(2 * np.pi * rolled / 0.4) * (np.sign(speed) if is_drag else 1.0)
    bumped = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    found = Fitted((WrenchRegression(bumped, guess(), None),), guess()).dependences[0]
    assert found.name.startswith("travelled distance")
    assert found.period == pytest.approx(0.4, rel=0.02)
    assert 0.8 * found.share < found.foretold <= found.share
    quiet = Fitted((regression,), guess()).dependences[0]
    assert quiet.log_factor < 6 < found.log_factor
    assert quiet.foretold < 0.05


def test_a_period_is_the_whole_turn():
    """Of a force with its second and fifth harmonics: alone, the second looks like half a turn."""
    log, _ = simulate(TRUTH, 3, 40.0, noise=(0.0005, 0.005, 1.0))
    speed = WrenchRegression(log, guess(), None).motion.velocity[:, 0]
    phase = 2 * np.pi * np.cumsum(np.append(0.0, np.diff(log.time)) * speed) / 1.6
    (name, arm), *_ = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] += 5.0 * np.sin(2 * phase) + 4.0 * np.sin(5 * phase)
    bumped = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    found = Fitted((WrenchRegression(bumped, guess(), None),), guess()).dependences[0]
    assert found.name.startswith("travelled distance")
    assert found.period == pytest.approx(1.6, rel=0.02)


def test_seams_across_the_floor_are_found_by_their_distance():
    """Where the floor itself pushes towards the nearest seam, whatever way was travelled."""
    log, _ = simulate(TRUTH, 4, 60.0, noise=(0.0005, 0.005, 1.0))
    (name, arm), *_ = log.arms.items()
    wrench, heading = arm.wrench.copy(), log.pose[:, 2]
    wrench[:, 0] += 6.0 * np.sin(2 * np.pi * log.pose[:, 0] / 0.7) * np.cos(heading)
    seamed = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    found = Fitted((WrenchRegression(seamed, guess(), None),), guess()).dependences[0]
    assert found.name == "place, periodic"
    assert found.period == pytest.approx(0.7, rel=0.03)
    assert found.log_factor > SURE


@pytest.mark.parametrize("turns", [1, 2])
def test_a_force_by_the_heading_is_found(turns):
    """As of a floor that slopes, or one with a grain."""
    log, _ = simulate(TRUTH, 3, 40.0, noise=(0.0005, 0.005, 1.0))
    (name, arm), *_ = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] += 4.0 * np.sin(turns * log.pose[:, 2])
    moved = replace(log, arms={name: ArmLog(arm.contact, wrench)})
    found, quiet = (
        next(one for one in Fitted((WrenchRegression(each, guess(), None),), guess()).dependences if is_heading(one))
        for each in (moved, log)
    )
    assert quiet.log_factor < 6 < SURE < found.log_factor
    assert found.share > 0.3 > 0.05 > quiet.foretold
    assert 0.8 * found.share < found.foretold <= found.share


DRAGS = {
    "time, as a drag": lambda log, speed: np.sign(speed) * np.cos(np.pi * log.time / log.duration),
    "heading, as a drag": lambda log, speed: 2.5 * speed * np.cos(log.pose[:, 2]),
    "heading, as a drag, along two opposite headings": lambda log, speed: np.sign(speed) * np.sin(2 * log.pose[:, 2]),
    "place, as a drag": lambda log, speed: np.sign(speed) * (log.pose[:, 0] - log.pose[:, 0].mean()) / 3,
    "yaw rate, as a drag": lambda log, speed: 3 * speed * np.abs(np.gradient(log.pose[:, 2], log.time)),
}


@pytest.mark.parametrize("name", DRAGS)
def test_a_drag_that_grows_with_something_is_found(name):
    """Flat in speed or not; it says nothing against an effect that lasts, but something against one that passes."""
    log, _ = simulate(TRUTH, 4, 60.0, noise=(0.0005, 0.005, 1.0))
    speed = WrenchRegression(log, guess(), None).motion.velocity[:, 0]
    (arm_name, arm), *_ = log.arms.items()
    wrench = arm.wrench.copy()
    wrench[:, 0] += 5.0 * DRAGS[name](log, speed)
    dragged = replace(log, arms={arm_name: ArmLog(arm.contact, wrench)})
    fitted = Fitted((WrenchRegression(dragged, guess(), None),), guess())
    told = name.removesuffix(", along two opposite headings")
    found = next(one for one in fitted.dependences if one.name == told)
    assert found.log_factor > SURE
    assert found.is_drag
    assert found.foretold > 0.2
    assert fitted.dependences[0].is_drag
    assert fitted.follows(lasts=False) == fitted.dependences[0]
    lasting = fitted.follows(lasts=True)
    assert lasting is None or not lasting.is_drag
    quiet = Fitted((WrenchRegression(log, guess(), None),), guess())
    assert next(one for one in quiet.dependences if one.name == told).log_factor < 6


def is_heading(dependence):
    return dependence.name == "heading"


def test_a_scatter_of_a_right_model_is_noise():
    log, _ = simulate(TRUTH, 7, 20.0, noise=(0.0005, 0.005, 2.0))
    fitted = Fitted((WrenchRegression(log, guess(), None),), guess())
    scatter = fitted.scatter
    assert 0.5 < scatter.misfit.mean() / 2 < 1.5
    polygon = fitted.polygon
    course = Course.of(polygon.time, polygon.log, [fitted.regressions[0].motion])
    assert len(course.time) == len(polygon.value)
    assert all(one.log_factor < 8 for one in dependences(polygon, course))
    assert isinstance(scatter, Scatter)


def test_manoeuvres_end_where_the_cart_turns_round():
    log = rolling()
    regression = WrenchRegression(log, guess(()), None)
    number = manoeuvres(regression.motion, turns=True)
    assert (np.diff(number) >= 0).all()
    assert number[-1] >= 4
    for k in range(number[-1] + 1):
        assert np.ptp(log.time[number == k]) <= 6.01


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda log: RunLog(log.time[:40], log.pose[:40], None, cut(log, 40)), "too few"),
        (lambda log: replace(log, pose=np.where(log.time[:, None] > 0.5, np.nan, log.pose)), "whole pose"),
        (
            lambda log: replace(log, arms={"arm": ArmLog(log.arms["arm"].contact, log.arms["arm"].wrench * np.nan)}),
            "arm arm",
        ),
    ],
)
def test_a_log_that_shows_nothing_is_refused_with_the_reason(spoil, said):
    with pytest.raises(DataError, match=said):
        check_rows(spoil(straight(duration=6.0)), guess())


def test_a_cart_that_stands_is_refused():
    log = straight(acceleration=0.0, duration=6.0)
    with pytest.raises(DataError, match="too little"):
        checked(log, guess(), WrenchRegression(log, guess(), None))


def test_a_cart_on_casters_moves_sideways_too():
    log, free = straight(duration=6.0), replace(guess(()), constraints=RollingConstraints(None))
    beside = replace(log, pose=log.pose + np.array([0.0, 0.0, np.pi / 2]))
    ahead, across = (WrenchRegression(one, free, None) for one in (log, beside))
    np.testing.assert_allclose(across.motion.speed, ahead.motion.speed, atol=0.01)
    for rows in (moving, settled):
        assert rows(across).mean() == pytest.approx(rows(ahead).mean(), abs=0.02)
        assert rows(across).mean() > 0.3
    assert checked(beside, free, across).distance == pytest.approx(checked(log, free, ahead).distance, rel=0.01)


def cut(log, rows):
    return {name: ArmLog(arm.contact[:rows], arm.wrench[:rows]) for name, arm in log.arms.items()}


def test_simulations_that_run_away_are_refused():
    """As they do on a log in mN or mm."""
    away = Rollouts(np.arange(2), 1.0, np.full((2, 3), np.nan))
    fit = SimpleNamespace(cart=None, delays=())
    held_out = SimpleNamespace(
        trained=lambda fitted: fit,
        rollouts=lambda cart, delays, horizon: (away,),
        floor_rollouts=lambda fitted, horizon: (away,),
        whole=(SimpleNamespace(name="run.csv"),),
    )
    with pytest.raises(DataError, match=r"run\.csv: .*SI units"):
        measured_gap(None, SimpleNamespace(held_out=held_out, nominal=fit, final=fit))
