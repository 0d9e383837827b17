"""The choice of what teaches most, against enumeration; the split, against pseudo-inverse and optimality; the sum."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planning.excitation.excitation_family as family_module
from cartgrasp.arms import Arm, Friction
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import LoadSlosh, PayloadChange, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.information import WrenchNoise, reduced_noise
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import regressor_b
from cartgrasp.roles import ContactQuery
from planning.allocation.allocation import allocate
from planning.excitation.excitation_choice import Allowance, ExcitationChooser
from planning.excitation.excitation_family import FreeSplit, motions
from planning.excitation.excitation_plan import plan_excitation
from planning.references import PathReference, Stretch, chain, pause, turn

NOISE = WrenchNoise(3.0, 0.1, 100.0)
CART = CartModel(Inertia(20.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.2),))
PRIOR = np.diag(1.0 / np.array([8.0, 4.0, 4.0, 3.0, 1e-3, 1e-3]) ** 2)
PLACES = {"left": [(-0.25, 0.2, 1.0), (0.0, 0.3, 0.8)], "right": [(-0.25, -0.2, 1.0), (0.0, -0.3, 0.8)]}
PATH = PathReference(chain([Stretch(1.0, 0.5)], pause(3.0), turn(1.2, 0.5), [Stretch(1.0, -0.5)]))


def arms(force=80.0, moment=15.0, friction=None):
    limits = {"force_limit": (force,) * 3, "moment_limit": (moment,) * 3, "friction": friction}
    return [Arm(name, points, **limits) for name, points in PLACES.items()]


def covariance_of_phi(information):
    return np.linalg.inv(information)[:4, :4] / np.outer(scales(), scales())


def scales():
    m, _, _, J = CART.inertia.phi
    return np.array([m, m * np.sqrt(J / m), m * np.sqrt(J / m), J])


def merit(information, criterion):
    values = np.linalg.eigvalsh(covariance_of_phi(information))
    return 1 / values[-1] if criterion == "E" else 1 / np.prod(values)


def enumerated(hands, window, allowance):
    """Every candidate: information summed sample by sample, effort of each QP made from scratch."""
    found = motions(PATH, CART, window, allowance.offset)
    names = [hand.name for hand in hands]
    candidates = []
    for i in range(len(found.deviations)):
        for one in PLACES["left"]:
            for other in PLACES["right"]:
                contacts = dict(zip(names, (one, other), strict=True))
                plans = [allocate(CART, hands, contacts, CART.planar_wrench(w)) for w in found.needed[i]]
                effort = np.mean([plan.effort for plan in plans]) if all(p.wrenches for p in plans) else np.inf
                weight = np.linalg.inv(reduced_noise(CART, [one, other], NOISE))
                share = (window[1] - window[0]) * NOISE.rate / found.samples
                total = PRIOR + share * sum(Y.T @ weight @ Y for Y in found.regressors[i])
                candidates.append((effort, merit(total, allowance.criterion), i == 0))
    assert len(candidates) == 36
    least = min(effort for effort, _, plain in candidates if plain)
    return least, max(worth for effort, worth, _ in candidates if effort <= least + allowance.effort + 1e-9)


@pytest.mark.parametrize(
    ("criterion", "effort", "limits", "window"),
    [
        ("E", 0.0, (80.0, 15.0, None), (3.8, 5.0)),
        ("E", 40.0, (80.0, 15.0, None), (1.8, 3.0)),
        ("D", 40.0, (80.0, 15.0, None), (5.1, 6.2)),
        ("D", 20.0, (25.0, 0.3, None), (1.8, 3.0)),
        ("E", 30.0, (80.0, 4.0, Friction(0.6, 4)), (2.0, 3.0)),
    ],
)
def test_the_best_of_every_candidate(criterion, effort, limits, window):
    hands, allowance = arms(*limits), Allowance(effort, 0.03, criterion)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(family_module, "AMPLITUDE_FRACTIONS", (1.0,))
        patch.setattr(family_module, "SWING_COUNTS", (1,))
        found = ExcitationChooser(CART, hands, NOISE, allowance).choose(PATH, window, PRIOR)
        least, best = enumerated(hands, window, allowance)
    assert found.status == "optimal"
    assert found.least_effort == pytest.approx(least)
    assert found.effort <= least + effort + 1e-6
    assert merit(found.information, criterion) == pytest.approx(best, rel=1e-6)
    assert found.after == pytest.approx(np.sqrt(np.linalg.eigvalsh(covariance_of_phi(found.information))[-1]))


def test_more_may_be_spent_and_more_is_learned():
    window, known = (1.0, 4.0), []
    for effort, offset in ((0.0, 0.0), (30.0, 0.0), (30.0, 0.02), (90.0, 0.02), (90.0, 0.04)):
        found = ExcitationChooser(CART, arms(), NOISE, Allowance(effort, offset)).choose(PATH, window, PRIOR)
        known.append(found.after)
    assert known == sorted(known, reverse=True)
    assert known[0] == pytest.approx(found.before), "at constant speed on a line nothing is learned"
    assert known[-1] < 0.2 * known[0]


def test_each_criterion_wins_by_its_own_measure():
    e, d = (
        ExcitationChooser(CART, arms(), NOISE, Allowance(60.0, 0.03, criterion)).choose(PATH, (1.0, 4.0), PRIOR)
        for criterion in "ED"
    )
    assert e.after <= d.after
    assert np.linalg.det(covariance_of_phi(d.information)) <= np.linalg.det(covariance_of_phi(e.information))


@given(st.integers(0, 2**32 - 1))
def test_split_without_internal_force(seed):
    """It has the wrench's effect, and no self-cancelling change makes it cheaper: orthogonal to all that cancels."""
    rng = np.random.default_rng(seed)
    hands = arms(np.inf, np.inf)
    chooser = ExcitationChooser(CART, hands, NOISE)
    split = FreeSplit.of(chooser._template, chooser.choices)
    needed, choice = rng.uniform(-50, 50, (3, 2)), int(rng.integers(4))
    wrenches, matrix = split.wrenches(choice, needed), split.matrix[choice]
    assert np.allclose(wrenches @ matrix.T, needed)
    cancelling = np.linalg.svd(matrix)[2][len(matrix) :]
    assert np.allclose(matrix @ cancelling.T, 0.0)
    assert np.allclose((wrenches * split.weights) @ cancelling.T, 0.0, atol=1e-8)
    assert split.efforts(needed[None])[0, choice] == pytest.approx((wrenches**2 @ split.weights).mean())


@pytest.mark.long
def test_limits_bring_internal_force():
    """Hands that only push can't brake a cart without drag: refused. With room to press, wrenches differ from the free
    split only where a limit binds."""
    free = ExcitationChooser(CART, arms(), NOISE, Allowance(30.0, 0.02)).choose(PATH, (1.0, 4.0), PRIOR)
    assert free.internal_force < 1e-9
    tight = ExcitationChooser(CART, arms(moment=0.1), NOISE, Allowance(30.0, 0.02)).choose(PATH, (1.0, 4.0), PRIOR)
    assert tight.internal_force > 0.01
    pushing = ExcitationChooser(CART, arms(friction=Friction(0.5)), NOISE, Allowance())
    stopped = pushing.choose(PATH, (PATH.duration - 1.0, PATH.duration), PRIOR)
    assert stopped.status == "infeasible"
    with pytest.raises(UsageError, match="no contacts can drive"):
        plan_excitation(pushing, PATH, PRIOR, 1.5)


def test_what_was_summed_is_what_the_whole_drive_teaches():
    """The plan's information against that of its own reference at every sample, sensed where it says."""
    plan = plan_excitation(ExcitationChooser(CART, arms(), NOISE, Allowance(40.0, 0.02)), PATH, PRIOR, 2.0)
    total = PRIOR.copy()
    for time in np.arange(0.0, plan.reference.duration, 0.01) + 0.005:
        wanted = plan.reference.at(time)
        rigid = regressor_b(wanted.velocity @ CART.basis_b.T, wanted.acceleration @ CART.basis_b.T)
        Y = np.hstack([CART.basis_b.T @ rigid, np.diag(wanted.velocity)])
        points = list(plan.contacts(ContactQuery(time, np.zeros(3))).contacts.values())
        total += Y.T @ np.linalg.solve(reduced_noise(CART, points, NOISE), Y)
    planned, driven = (np.sqrt(np.diag(covariance_of_phi(i))) for i in (plan.windows[-1].information, total))
    assert np.allclose(planned, driven, rtol=0.05)
    assert any(window.deviation for window in plan.windows)


@pytest.mark.parametrize("rows", [0, 2])
def test_only_a_steered_cart_weaves(rows):
    cart = CartModel(CART.inertia, RollingConstraints(None if rows == 0 else 0.0, no_rotation=rows == 2), CART.effects)
    path = PathReference((Stretch(1.0, 0.5), Stretch(2.0), Stretch(1.0, -0.5)), cart.constraints)
    found = ExcitationChooser(cart, arms(), NOISE).choose(path, (1.0, 3.0), PRIOR)
    assert found.deviation is None
    assert found.tried == 4


def test_what_swings_goes_along():
    """At a steady speed nothing swings; when the speed has changed, it swings on."""
    cart = CART.with_effect(LoadSlosh(8.0, 1.0, 0.3))
    steady, without = (motions(PATH, one, (1.2, 3.0), 0.0).needed for one in (cart, CART))
    np.testing.assert_allclose(steady, without, atol=1e-9)
    pushed, without = (motions(PATH, one, (0.0, 1.0), 0.0).needed[0, :, 0] for one in (cart, CART))
    assert pushed[0] == pytest.approx(without[0] - 8.0 * 0.5)
    assert pushed.max() > without.max() + 0.5


def test_a_load_counts_from_when_it_is_put_on():
    times = 1.2 + 0.1 * (np.arange(18) + 0.5)
    loaded = CART.with_effect(PayloadChange(1.5, 5.0, 0.4, 0.1))
    found, without = (motions(PATH, cart, (1.2, 3.0), 0.02) for cart in (loaded, CART))
    new = np.abs(found.needed - without.needed).max(axis=(0, 2)) > 1e-6
    assert new.tolist() == (times > 1.5).tolist()


def test_a_sensor_without_noise_is_as_good_as_the_best():
    exact, best = (ExcitationChooser(CART, arms(), WrenchNoise(std, std)) for std in (0.0, 1e-3))
    assert exact.choose(PATH, (1.0, 2.0), PRIOR).after == best.choose(PATH, (1.0, 2.0), PRIOR).after


def test_what_can_not_be_asked():
    for wrong in ({"effort": -1.0}, {"offset": np.nan}, {"criterion": "A"}):
        with pytest.raises(UsageError, match="excitation"):
            Allowance(**wrong)
    with pytest.raises(UsageError, match="hands 2 m apart"):
        ExcitationChooser(CART, arms(), NOISE, Allowance(min_hand_distance=2.0))
    with pytest.raises(UsageError, match="weight of 0"):
        ExcitationChooser(CART, [Arm("hand", [(0, 0, 1)], weights=(1, 1, 0, 1, 1, 1))], NOISE)
    with pytest.raises(UsageError, match="no length"):
        ExcitationChooser(CART, arms(), NOISE).choose(PATH, (2.0, 2.0), PRIOR)
    for wrong in (np.zeros((6, 6)), np.full((6, 6), np.nan)):
        with pytest.raises(UsageError, match="singular; add a prior's"):
            ExcitationChooser(CART, arms(), NOISE).choose(PATH, (1.0, 2.0), wrong)
    for dwell in (0.0, -1.0, np.nan):
        with pytest.raises(UsageError, match="excitation: dwell"):
            plan_excitation(ExcitationChooser(CART, arms(), NOISE), PATH, PRIOR, dwell)


def test_the_sequence_is_at_least_half_as_good_as_the_best():
    """Log-volume is submodular in what is taught, so window after window (D, phi alone unknown) wins at least half of
    what the best of all sequences within the allowance wins."""
    cart = CartModel(CART.inertia)
    prior = np.diag(1.0 / np.array([8.0, 4.0, 4.0, 3.0]) ** 2)
    path = PathReference(chain([Stretch(1.0, 0.5)], pause(3.0), [Stretch(1.0, -0.5)]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(family_module, "AMPLITUDE_FRACTIONS", (1.0,))
        patch.setattr(family_module, "SWING_COUNTS", (1,))
        chooser = ExcitationChooser(cart, arms(np.inf, np.inf), NOISE, Allowance(60.0, 0.01, "D"))
        plan = plan_excitation(chooser, path, prior, 1.25)
        best = np.zeros((1, 4, 4)) + prior
        for window in plan.windows:
            found = motions(path, cart, window.window, 0.01)
            allowed = chooser._split.efforts(found.needed) <= window.least_effort + 60.0 + 1e-9
            taught = chooser.taught(found, window.window)[allowed]
            best = (best[:, None] + taught).reshape(-1, 4, 4)
    most = np.linalg.slogdet(best)[1].max()
    least = np.linalg.slogdet(prior)[1]
    won = np.linalg.slogdet(plan.windows[-1].information)[1]
    assert len(best) > 1000
    assert won - least >= 0.5 * (most - least)
    assert won <= most + 1e-9
