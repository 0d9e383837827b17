"""By how many deviations motions tell carts apart: against fits by hand, and against likelihoods of drawn logs."""

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import (
    DirectionalDrag,
    FloorSlope,
    ForceBias,
    ForceScale,
    LateralSlip,
    QuadraticDrag,
    RollingResistance,
    TimeDelay,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.inertia import Inertia
from cartgrasp.information import WrenchNoise
from cartgrasp.model import CartModel
from estimation.experiments.manoeuvres import MANOEUVRE_TIME_STEP, Limits, Place, pieces, sampled
from estimation.experiments.proposal import Experiment, Question
from estimation.experiments.separation import Belief, Evidence, Hands, traced
from planning.references import PathReference

MASS, G = 24.0, 9.81
RAIL = CartModel(
    Inertia(MASS, (0.0, 0.0), 2.0), RollingConstraints(0.0, no_rotation=True), (ViscousDrag(linear=3.0, angular=1.0),)
)
CART = CartModel(Inertia(MASS, (0.3, 0.05), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
ONE = Hands({"hand": np.array([-0.3, 0.1, 1.0])}, WrenchNoise(force=3.0, moment=0.1, rate=100.0))
TWO = Hands({"left": np.array([-0.3, 0.2, 1.0]), "right": np.array([-0.3, -0.2, 1.0])}, WrenchNoise())
LIMITS = Limits()
SAID = {piece.says: piece for piece in pieces(LIMITS, CART.constraints)}
ALONG = pieces(LIMITS, RAIL.constraints)
ADDED = {
    "rolling_resistance": RollingResistance(coefficient=0.02),
    "directional_drag": DirectionalDrag(forward=0.0, backward=4.0),
    "quadratic_drag": QuadraticDrag(coefficient=6.0),
    "force_bias": ForceBias(fx=3.0),
    "force_scale": ForceScale(gain=1.1),
    "time_delay": TimeDelay(delay=0.03),
}
RIVALS = {
    "rolling_resistance": RollingResistance(),
    "quadratic_drag": QuadraticDrag(),
    "force_bias": ForceBias(),
    "time_delay": TimeDelay(),
}
ANY = 1e3
"""Standard deviation of what is not known at all."""


def deviations(parts, truth, rival, hands, root=None):
    """Of pieces one after the other; of the rival nothing is known unless a root is given."""
    beliefs = Belief(truth, np.zeros((len(truth.parameters), 0))), Belief(rival, ANY * np.eye(len(rival.parameters)))
    if root is not None:
        beliefs = beliefs[0], Belief(rival, root)
    places = [Place(np.zeros(3), cart.state()[cart.memory_slice], 0.0) for cart in (truth, rival)]
    evidence, weights = Evidence.none(beliefs[1]), hands.weights(truth)
    for piece in parts:
        traces = [traced(b, piece, place, hands, weights) for b, place in zip(beliefs, places, strict=True)]
        evidence, places = evidence.more(*traces), [trace.end for trace in traces]
    return evidence.deviations


def column(name, u, a):
    """On a straight line, what each adds to the forward force; of usual signs."""
    force = MASS * a + 3.0 * u
    columns = {
        "rolling_resistance": 0.02 * MASS * G * np.sign(u) * (np.abs(u) > 0),
        "directional_drag": 4.0 * np.minimum(u, 0.0),
        "quadratic_drag": 6.0 * u * np.abs(u),
        "force_bias": 3.0 * np.ones_like(u),
        "force_scale": 0.1 * force,
        "time_delay": 0.03 * np.gradient(force, MANOEUVRE_TIME_STEP),
    }
    return columns[name]


def driven(piece):
    """Speed and its rate; nought at rest."""
    _, velocity, rate = sampled(piece)
    return np.round(velocity[:, 0], 9), rate[:, 0]


def joined(parts):
    return tuple(np.concatenate(one) for one in zip(*map(driven, parts), strict=True))


@pytest.mark.parametrize(("name", "rival"), [(name, rival) for name in ADDED for rival in RIVALS if name != rival])
def test_deviations_are_those_of_a_fit_by_hand(name, rival):
    """What least squares on acceleration, speed and the rival leave of the effect, over 3 N at a hundred rows a
    second."""
    for parts in (ALONG[:1], ALONG[2:4], ALONG[:2], ALONG[4:5], ALONG):
        motions = [driven(piece) for piece in parts]
        here, beside = (np.concatenate([column(one, *motion) for motion in motions]) for one in (name, rival))
        columns = np.column_stack([*joined(parts)[::-1], beside])
        columns = columns[:, np.linalg.norm(columns, axis=0) > 1e-9]
        left = here - columns @ np.linalg.lstsq(columns, here, rcond=1e-9)[0]
        expected = np.linalg.norm(left) * np.sqrt(100.0 * MANOEUVRE_TIME_STEP) / 3.0
        found = deviations(parts, RAIL.with_effect(ADDED[name]), RAIL.with_effect(RIVALS[rival]), ONE)
        assert found == pytest.approx(expected, rel=0.05, abs=0.4), [piece.says for piece in parts]


def test_deviations_are_the_likelihood_ratio_of_drawn_logs():
    """Resistance or an offset, after a push one way that knows them not apart: by what the best fit of each of old and
    new rows loses, over 400 draws of both logs. Fits are by hand, with priors of 40 % and of ten times a usual size."""
    draws, sigma = np.random.default_rng(7), 3.0 / np.sqrt(100.0 * MANOEUVRE_TIME_STEP)
    old, new = joined(ALONG[:1] * 2), joined(ALONG[1:2])
    mean, std = np.array([MASS, 3.0, 0.0]), np.array([10.0, 1.5, 60.0])
    size = 0.02 * MASS * G

    def rows(motion, name):
        u, a = motion
        return np.column_stack([a, u, np.sign(u) if name == "rolling_resistance" else np.ones_like(u)]) / sigma

    def lost(force, matrix):
        """Of the best fit and its prior; and the fit."""
        whole = np.vstack([matrix, np.diag(1 / std)])
        target = np.concatenate([force / sigma, mean / std])
        fit = np.linalg.lstsq(whole, target, rcond=None)[0]
        return float(np.sum((target - whole @ fit) ** 2)), fit

    clean = [rows(motion, "rolling_resistance") @ [MASS, 3.0, size] * sigma for motion in (old, new)]
    gains = []
    for _ in range(400):
        forces = [force + sigma * draws.standard_normal(len(force)) for force in clean]
        gain = {}
        for name in ("rolling_resistance", "force_bias"):
            before, after = (np.vstack([rows(motion, name) for motion in motions]) for motions in ([old], [old, new]))
            gain[name] = lost(np.concatenate(forces), after)[0] - lost(forces[0], before)[0]
        gains.append(gain["force_bias"] - gain["rolling_resistance"])
    matrix = rows(old, "force_bias")
    _, (mass, drag, bias) = lost(clean[0], matrix)
    covariance = np.linalg.inv(matrix.T @ matrix + np.diag(std**-2.0))
    rival = CartModel(
        Inertia(mass, (0.0, 0.0), 2.0), RAIL.constraints, (ViscousDrag(linear=drag, angular=1.0), ForceBias(fx=bias))
    )
    root = np.zeros((len(rival.parameters), 3))
    root[[0, rival.parameter_names.index("viscous_drag.linear"), rival.parameter_names.index("force_bias.fx")]] = (
        np.linalg.cholesky(covariance)
    )
    found = deviations(ALONG[1:2], RAIL.with_effect(RollingResistance(coefficient=0.02)), rival, ONE, root)
    assert found**2 == pytest.approx(np.mean(gains), rel=0.05)
    assert found > 5


def test_a_slope_and_a_bias_differ_along_another_heading():
    """On one heading they are one."""
    slope, bias = CART.with_effect(FloorSlope(grade_x=0.01)), CART.with_effect(ForceBias())
    there = [SAID["roll forwards at 0.8 m/s"], SAID["roll backwards at 0.8 m/s"]]
    assert deviations(there, slope, bias, TWO) < 1
    assert deviations([*there, SAID["turn left on the spot"], *there], slope, bias, TWO) > 10


def test_creep_shows_in_curves_and_an_angle_straight_on():
    """In the speed across the wheels, over the noise of poses."""
    straight, curve = [SAID["roll forwards at 0.8 m/s"]], [SAID["curve left forwards at 0.8 m/s"]]
    creeping, turned = CART.with_effect(LateralSlip(1000.0)), CART.with_effect(WheelMisalignment(0.02))
    assert deviations(straight, creeping, CART, TWO) < 1e-6 < 3 < deviations(curve, creeping, CART, TWO)
    u = joined(straight)[0]
    rate = np.sqrt(100.0 * MANOEUVRE_TIME_STEP) * 0.5 / (np.sqrt(2 * 100.0 * 0.5) * TWO.position)
    assert deviations(straight, turned, CART, TWO) == pytest.approx(rate * np.linalg.norm(0.02 * u), rel=1e-3)


def test_the_proposal_is_better_than_most_orders_of_pieces():
    """And is told as well as it is when its pieces are looked at one by one."""
    resisting = CART.with_effect(RollingResistance(coefficient=0.02))
    carts = resisting, CART.with_effect(ForceBias(fx=4.0)), CART.with_effect(FloorSlope(grade_x=0.015))
    beliefs = tuple(Belief(cart, ANY * np.eye(len(cart.parameters))) for cart in carts)
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    questions = tuple(Question(str(i), str(j), i, j) for i, j in pairs)
    experiment = Experiment(beliefs, questions, TWO)
    found = experiment.proposed(Limits(duration=15.0), np.zeros(3))
    assert 10 < found.reference.duration <= 15.0
    again = [deviations(found.pieces, carts[i], carts[j], TWO) for i, j in pairs]
    assert found.deviations == pytest.approx(again, rel=1e-6)
    random, known, worse = np.random.default_rng(0), list(SAID.values()), 0
    for _ in range(20):
        course = experiment.begun(np.zeros(3), 0.0)
        for i in random.integers(len(known), size=len(found.pieces)):
            course = experiment.after(course, known[i])
        worse += min(one.deviations for one in course.evidence) < min(found.deviations)
    assert worse >= 18


def test_sensors_without_noise_give_finite_numbers():
    quiet = Hands(TWO.contacts, WrenchNoise(force=0.0, moment=0.0), 0.0)
    assert np.isfinite(quiet.weights(CART)).all()


def test_a_share_of_the_wrench_counts_as_noise_of_each_piece():
    """Sherman and Morrison by hand, where the rival is known."""
    wrong = Hands(ONE.contacts, ONE.noise, form=0.05)
    resisting, square = RAIL.with_effect(RollingResistance(coefficient=0.02)), 0.0
    for u, a in map(driven, ALONG[:2]):
        d = column("rolling_resistance", u, a) * np.sqrt(100.0 * MANOEUVRE_TIME_STEP) / 3.0
        c = 0.05 * (d + (MASS * a + 3.0 * u) * np.sqrt(100.0 * MANOEUVRE_TIME_STEP) / 3.0)
        square += d @ d - (c @ d) ** 2 / (1 + c @ c)
    known = np.zeros((len(RAIL.parameters), 1))
    assert deviations(ALONG[:2], resisting, RAIL, wrong, known) == pytest.approx(np.sqrt(square), rel=0.01)
    assert deviations(ALONG[:2], resisting, RAIL, wrong, known) < deviations(ALONG[:2], resisting, RAIL, ONE, known)


@pytest.mark.parametrize("axle", [-0.6, 0.0, 0.5, 2.0])
@pytest.mark.parametrize("says", ["curve left forwards at 0.8 m/s", "turn right on the spot"])
def test_a_belief_goes_where_the_reference_leads(says, axle):
    """Wherever the axle stands: a yaw rate that is asked for is driven whole."""
    cart = CartModel(Inertia(MASS, (0.3, 0.05), 2.2), RollingConstraints(axle))
    belief, reference = Belief(cart, np.zeros((4, 0))), PathReference(SAID[says].stretches, cart.constraints)
    end = traced(belief, SAID[says], Place(np.zeros(3), np.zeros(0), 0.0), ONE, ONE.weights(cart)).end.pose
    np.testing.assert_allclose(end, reference.at(reference.duration).pose_sb, atol=1e-4)
