"""The search, on logs whose equations share nothing with the library's, and on motions that are written down."""

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from benchmarks.sealed.generate import generate
from cartgrasp.effects import (
    FloorPatch,
    FloorSlope,
    LoadSlosh,
    RollingResistance,
    TimeDelay,
    ViscousDrag,
    WheelDragImbalance,
)
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.discrepancy.search.candidates import amplitudes_of, families
from estimation.discrepancy.search.gains import CONFUSABLE_NATS, MIN_GAIN_NATS, without_amplitudes
from estimation.discrepancy.search.model import FORCE_LEVER_STD, Model
from estimation.discrepancy.search.refine import refined
from estimation.discrepancy.search.scored_candidates import ScoredCandidate
from estimation.discrepancy.search.screening import Screen
from estimation.discrepancy.search.search import chosen, structure_keys
from estimation.weak_form.balances import Balances

from ...runs import simulate_two_hands
from ...weak_form.motions import RAIL, STEP, TRUE, cart_of, noisy, on_rail, weaving


def first_seconds(log, seconds):
    own = log.time < log.time[0] + seconds
    arms = {name: ArmLog(arm.contact[own], arm.wrench[own]) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else log.velocity[own]
    return RunLog(log.time[own], log.pose[own], velocity, arms, name=log.name)


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize(("case", "seed", "motion"), [("nothing", 3, "rich"), ("rolling_resistance", 0, "straight")])
def test_sealed_logs_are_named_exactly(case, seed, motion, tmp_path):
    (name,) = generate(tmp_path, [case], [seed], motion)
    log = first_seconds(cg.read_log(tmp_path / "logs" / name / "run.csv"), 20.0)
    found = diagnose(log, cg.load_cart(tmp_path / "logs" / name / "cart.yaml"))
    assert [effect.name for effect in found.effects] == [n for n in [case] if n != "nothing"]
    assert not found.final.laws


@pytest.mark.prove
def test_a_load_that_swings_is_found_in_the_band_that_it_makes_one(tmp_path):
    """In bands above a second it is no longer seen. The wide ones agree with it on the mass, which they tell."""
    (name,) = generate(tmp_path, ["load_slosh"], [8339], "rich")
    found = diagnose(
        cg.read_log(tmp_path / "logs" / name / "run.csv"), cg.load_cart(tmp_path / "logs" / name / "cart.yaml")
    )
    assert [effect.name for effect in found.effects] == ["load_slosh"]
    assert [band.row_step < 0.3 for band in found.bands] == [True]
    assert found.gap.after < 2 * found.gap.noise_floor


@pytest.mark.prove
def test_a_slope_that_is_written_down():
    """Its grades, within three standard deviations; what was added is worth more than all that was tried beside it."""
    found = diagnose(noisy(weaving(TRUE, 24.0, slope=(0.015, -0.01)), 2), cart_of((20.0, 0.2, 0.0, 2.0, 2.7, 1.1)))
    (effect,) = found.effects
    assert effect.name == "floor_slope"
    for name, true in (("grade_x", 0.015), ("grade_y", -0.01)):
        value, std, _ = effect.parameters[name]
        assert abs(value - true) < 3 * std < 0.003
    step = found.steps[0]
    assert step.added.key == "floor_slope"
    assert step.added.gain >= max(a.gain for a in step.attempts if a.key != "floor_slope")
    assert found.steps[-1].added is None


def still(force, seconds=8.0):
    time = np.arange(0.0, seconds, STEP)
    zero = np.zeros((len(time), 3))
    wrench = np.zeros((len(time), 6))
    wrench[:, 0] = force
    return noisy(RunLog(time, zero, zero, {"arm": ArmLog(zero, wrench)}, name="still"), 1)


@pytest.mark.parametrize("force", [0.0, 8.0])
def test_a_cart_that_stands_is_no_error(force, tmp_path):
    """Whatever holds it; a gap is as large as its poses' noise, and what was added closed none of it."""
    found = diagnose(still(force), cart_of(TRUE))
    assert found.gap.before == found.gap.refitted == found.gap.after == found.gap.noise_floor
    assert found.gap.before == pytest.approx(2**0.5 * 5e-4, rel=0.2)
    assert all(effect.gap_share == 0.0 for effect in found.effects)
    found.report.save(tmp_path / "out")


def coasting(grade, drag=4.0, seconds=12.0):
    """On a rail, x'' = -9.81 g - (c / m) x', solved."""
    time, rate = np.arange(0.0, seconds, STEP), drag / RAIL.inertia.mass
    end, start = -9.81 * grade / rate, 1.6
    speed = end + (start - end) * np.exp(-rate * time)
    x = end * time + (start - end) * (1 - np.exp(-rate * time)) / rate
    zero = np.zeros_like(time)
    poses, rates = np.column_stack([x, zero, zero]), np.column_stack([speed, zero, zero])
    return noisy(RunLog(time, poses, rates, {}, name="coasting"), 3, 2e-4, 2e-3)


@pytest.mark.long
def test_a_cart_that_coasts_up_and_down_a_slope():
    """It turns round, and goes faster downhill than its drag lets it; the mass is as it was given."""
    cart = CartModel(RAIL.inertia, RAIL.constraints, (ViscousDrag(linear=4.0),))
    found = diagnose(coasting(0.02), cart)
    assert [effect.name for effect in found.effects] == ["floor_slope"]
    value, std, _ = found.effects[0].parameters["grade_x"]
    assert abs(value - 0.02) < 3 * std < 0.003
    assert "grade_y" not in found.effects[0].parameters  # of which a rail along x says nothing
    assert found.cart.inertia.mass == pytest.approx(RAIL.inertia.mass, rel=1e-12)
    assert diagnose(coasting(0.0), cart).verdict == "no_discrepancy"


def test_a_single_sensor_is_not_said_to_be_scaled():
    """Were all wrenches wrong by a factor, the cart would be another; of two, one may be."""
    cart = cart_of(TRUE)
    keys = {family.key for family in families(cart, ["hand"])}
    assert not any(key.startswith("force_scale") for key in keys)
    both = {family.key for family in families(cart, ["left", "right"])}
    assert {"force_scale.left", "force_scale.right"} <= both
    assert not any(key.startswith(("force_", "time_delay", "payload")) for key in (f.key for f in families(cart, [])))


def test_what_a_cart_has_is_no_candidate():
    cart = CartModel(Inertia(20.0, (0.0, 0.0), 2.0), effects=(ViscousDrag(1.0, 1.0), RollingResistance(0.01)))
    names = [family.key for family in families(cart, ["hand"])]
    assert "viscous_drag" not in names
    assert "rolling_resistance" not in names
    assert len(names) == len(set(names))


def test_what_turns_a_cart_is_no_candidate_on_a_rail():
    assert "wheel_drag_imbalance" in {family.key for family in families(cart_of(TRUE), ["hand"])}
    assert "wheel_drag_imbalance" not in {family.key for family in families(RAIL, ["hand"])}


def test_a_variant_without_amplitudes_does_nothing():
    cart = cart_of(TRUE)
    for family in families(cart, ["left", "right"]):
        effect = family.variants[0]
        if isinstance(effect, TimeDelay) or effect.gate.n_parameters == 4 or not len(amplitudes_of(effect)):
            continue
        none = without_amplitudes(effect)
        state = np.array([0.3, 0.2, 0.4, 0.5, 0.1])
        if hasattr(none, "slip_compliance"):
            continue
        whole = cart.with_effect(none)
        state = np.append(state, np.zeros(len(whole.memory_names)))
        found = whole.required_wrench(state, np.array([0.3, -0.2]))
        assert found == pytest.approx(cart.required_wrench(state[:5], np.array([0.3, -0.2])), abs=1e-9)


def test_what_stretches_contradict_is_not_taken():
    """A gain counts where it is one and a half of its standard errors; what vanished at its bound, and
    what nobody would call by its name, is no rival."""
    model = Model.started([Balances.of(on_rail(12.0), RAIL)], RAIL)
    slope, rolling = FloorSlope(0.02, 0.0), RollingResistance(0.02)
    unsteady = ScoredCandidate(slope, 30.0, 1, model, 25.0)
    steady = ScoredCandidate(rolling, 28.0, 1, model, 5.0)
    assert chosen([unsteady], 10.0, MIN_GAIN_NATS) is None
    assert chosen([unsteady, steady], 10.0, MIN_GAIN_NATS) is steady
    vanished = ScoredCandidate(RollingResistance(0.0), 90.0, 1, model, 1.0)
    assert chosen([vanished, steady], 10.0, MIN_GAIN_NATS) is steady
    late = ScoredCandidate(TimeDelay(0.4), 90.0, 1, model)
    assert chosen([late, steady], 10.0, MIN_GAIN_NATS) is steady


def test_another_size_of_what_the_file_has_is_a_step():
    """The search goes on after it, as after a name."""
    model = Model.started([Balances.of(on_rail(12.0), RAIL)], RAIL)
    assert structure_keys(replace(model, wide=frozenset({"viscous_drag"}))) - structure_keys(model) == {"viscous_drag"}


def test_what_every_cart_has_may_be_small_beside_another():
    """Of anything else, the form of what was found may leave as much."""
    model = Model.started([Balances.of(on_rail(12.0), RAIL)], RAIL)
    rolling = ScoredCandidate(RollingResistance(0.02), 28.0, 1, model, 3.0)
    slope = ScoredCandidate(FloorSlope(0.02), 90.0, 1, model, 3.0)
    assert chosen([slope, rolling], 100.0, MIN_GAIN_NATS) is rolling
    assert chosen([slope], 100.0, MIN_GAIN_NATS) is None
    assert chosen([replace(rolling, gain=9.0)], 0.0, MIN_GAIN_NATS) is None


@pytest.mark.parametrize(("gain", "is_named"), [(99.0, True), (95.1, True), (94.9, False), (50.0, False)])
def test_a_name_keeps_what_a_law_fits_no_better_than_forms_differ(gain, is_named):
    """A slope whose floor waves a little: by up to a twentieth of what both explain a law is better by its form."""
    cart = cart_of(TRUE)
    model = Model.started([Balances.of(noisy(weaving(TRUE, 24.0, slope=(0.03, 0.02)), 2), cart)], cart)
    law = next(law for law, _ in Screen(model).laws() if law.name == "place")
    fitted = ScoredCandidate(law, 100.0, 1, replace(model, laws=(law,)).refitted(cart), 3.0)
    named = ScoredCandidate(FloorSlope(0.03, 0.02), gain, 1, fitted.model, 3.0)
    assert chosen([fitted, named], 0.0, MIN_GAIN_NATS) is (named if is_named else fitted)


@pytest.mark.parametrize(("deviations", "is_one"), [(3.0, True), (-3.0, True), (1.0, False)])
def test_wheels_that_drag_alike_are_no_imbalance(deviations, is_one):
    """The moment is told where it is two deviations from nought, with those that the force's lever has."""
    cart = cart_of(TRUE).with_effect(WheelDragImbalance(4.0, 1.0))
    model = Model.started([Balances.of(noisy(weaving(TRUE, 24.0), 2), cart)], cart)
    moment = deviations * np.hypot(model.deviation("wheel_drag_imbalance.moment"), FORCE_LEVER_STD * 4.0)
    told = ScoredCandidate(WheelDragImbalance(4.0, moment), 90.0, 1, model, 3.0)
    assert chosen([told], 0.0, MIN_GAIN_NATS) is (told if is_one else None)


@pytest.mark.parametrize(("far", "is_one"), [(0.5, True), (50.0, False)])
def test_a_floor_without_an_edge_is_no_patch(far, is_one):
    """What the cart never leaves is the floor."""
    cart = cart_of(TRUE).with_effect(FloorPatch(-50.0, far, -50.0, 50.0, 0.02))
    model = Model.started([Balances.of(noisy(weaving(TRUE, 24.0), 2), cart)], cart)
    told = ScoredCandidate(cart.effects[-1], 90.0, 1, model)
    assert chosen([told], 0.0, MIN_GAIN_NATS) is (told if is_one else None)


def test_settings_stay_near_what_is_plausible():
    """However much a load gains that swings faster, nobody follows it beyond half as much again."""
    slosh = LoadSlosh(mass=5.0, frequency=2.0, damping=0.1)
    best = refined(slosh, lambda effect: float(effect.values[1]))
    assert 4.0 < best.values[1] <= 6.0


def test_a_drag_at_its_bound_frees_no_column():
    """Pushed back by its drag, a cart's fit has none of it, and no score counts on less."""
    guess = cart_of(TRUE)
    model = Model.started([Balances.of(noisy(weaving((*TRUE[:4], -2.0, 1.2), 12.0), 5), guess)], guess)
    assert model.prior.free.sum() == len(model.cart.parameters) - 1
    assert model.cart.effects[0].values[0] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("frequency", [4.0, 8.0, 20.0])
def test_a_load_that_swings_faster_than_the_motion_is_known_explains_nothing(frequency):
    """As fast, it goes with a cart that is rigid; noise of its poses is not what it does beside."""
    log = replace(simulate_two_hands((24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0), 1, 30.0), velocity=None)
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
    screen = Screen(Model.started([Balances.of(log, cart)], cart))
    assert screen.gain(LoadSlosh(mass=0.0, frequency=frequency, damping=0.2)) < 3.0


def test_what_closes_the_gap_may_gain_less():
    model = Model.started([Balances.of(on_rail(12.0), RAIL)], RAIL)
    slope = ScoredCandidate(FloorSlope(0.02, 0.0), 6.0, 1, model, 3.0)
    assert chosen([slope], 0.0, MIN_GAIN_NATS) is None
    assert chosen([slope], 0.0, CONFUSABLE_NATS) is slope
