"""What a run did not teach is said, with a motion that would: and that motion does."""

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.information import WrenchNoise
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion
from estimation import CartFilter, FilterNoise, PaperFilter, Prior
from estimation.experiments.exciting_motions import exciting_motions, remedy
from estimation.identifiable import identifiability
from estimation.whole_log.replay import replay

from .runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
STRAIGHT = (24.0, 0.28, 0.0, 2.2, 3.0, 1.2, 0.0)  # nothing turns it
NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05, disturbance=0.05, slip=0.0002)
DRAGS = (ViscousDrag(2.0, 1.0), RollingResistance(0.015))


def guess(effects=DRAGS, constraints=RollingConstraints()):
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), constraints, effects)


def learned(curved, cart=None, prior=None):
    log, _ = simulate(TRUTH if curved else STRAIGHT, 4, duration=14.0, curved=curved, noise=(0.0004, 0.005, 1.0))
    return replay(log, CartFilter(cart or guess(), ["hand"], noise=NOISE, prior=prior)).last


@pytest.mark.long
def test_a_straight_push_asks_for_curves_and_curves_teach():
    """d/d(com_x) and d/dJ of the equations vanish where r = 0 and r' = 0 (physics.md)."""
    found = identifiability(learned(curved=False, cart=guess(DRAGS[:1])))
    untaught = {name for one in found.untaught for name in one.parameters}
    assert {"com_x", "inertia", "viscous_drag.angular"} <= untaught
    assert not {"mass", "com_y"} & untaught
    for one in found.untaught:
        if {"com_x", "inertia"} & set(one.parameters):
            assert one.remedy is not None
            assert "curve" in one.remedy or "turn" in one.remedy
            assert one.remedy in str(one)
    after = identifiability(learned(curved=True, cart=guess(DRAGS[:1])))
    assert not {"com_x", "inertia"} & {name for one in after.untaught for name in one.parameters}
    assert all(after.left[name] < found.left[name] for name in ("com_x", "inertia"))


def test_what_one_contact_can_not_tell_apart_moves_together():
    cart = guess(effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.02), ForceBias()))
    found = identifiability(learned(curved=True, cart=cart, prior=Prior(slope=0.0)))
    together = next(one for one in found.untaught if "force_bias.tz" in one.parameters)
    assert set(together.parameters) == {"force_bias.fy", "force_bias.tz"}
    assert "force_bias.fy and force_bias.tz move together" in str(together)
    assert "another point" in together.remedy


@pytest.mark.long
def test_what_is_known_or_can_not_move_is_not_asked_for():
    known = Prior(known=frozenset({"viscous_drag", "rolling_resistance"}))
    assert not any("drag" in name for name in identifiability(learned(False, prior=known), known).left)
    rail = guess(constraints=RollingConstraints(no_rotation=True))
    found = identifiability(CartFilter(rail).update(Measurement(0.0, np.zeros(3))))
    spinning = next(one for one in found.untaught if one.parameters == ("viscous_drag.angular",))
    assert spinning.remedy is None
    assert "none of the usual motions" in str(spinning)


@pytest.mark.parametrize("motion", exciting_motions(), ids=lambda motion: motion.says)
def test_what_a_motion_teaches_is_what_its_wrenches_say(motion):
    """Its information against differences of the wrenches that the model asks for, worked out one by one."""
    cart = guess()
    found = motion.information(cart, WrenchNoise(force=2.0, moment=0.1, rate=100.0))
    velocity = motion.twist_b[:, [0, 2]]
    acceleration = np.gradient(velocity, 0.02, axis=0)
    state = np.hstack([np.zeros((len(velocity), 3)), velocity])
    columns = []
    for i, value in enumerate(cart.parameters):
        step = 1e-4 * max(abs(value), 0.01) * np.eye(len(cart.parameters))[i]
        sides = [cart.required_wrench(state, acceleration, cart.parameters + s) for s in (step, -step)]
        columns.append((sides[0] - sides[1]) / (2 * step.sum()))
    Y = np.stack(columns, axis=-1)
    moment = 2 * (0.3**2 + 0.3**2) * 2.0**2 + 2 * 0.1**2
    R = np.diag([2 * 2.0**2, moment])
    expected = 2.0 * np.einsum("nap,ab,nbq->pq", Y, np.linalg.inv(R), Y)
    scale = np.sqrt(np.maximum(np.diag(expected), 1e-9))
    np.testing.assert_allclose(found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-4)


@pytest.mark.parametrize("axle", [-0.6, 1.0])
def test_a_turn_teaches_as_much_as_it_accelerates(axle):
    """On the spot about an axle at x = a, r' alone tells of `m a² + 2 m dx a + J`, the inertia about it."""
    cart = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), RollingConstraints(axle))
    turn = next(motion for motion in exciting_motions() if motion.says == "turn left and right on the spot")
    found = turn.information(cart, WrenchNoise(force=1e-6, moment=0.1, rate=50.0))
    rate = np.gradient(turn.twist_b[:, 2], 0.02)
    assert found[3, 3] == pytest.approx(float(rate @ rate) / (2 * 0.1**2))


@pytest.mark.parametrize(("left", "is_told"), [(0.3, True), (0.45, True), (0.55, False)])
def test_a_remedy_leaves_less_than_half_of_the_variance(left, is_told):
    cart = guess(effects=())
    most = max(motion.information(cart, WrenchNoise())[0, 0] for motion in exciting_motions())
    covariance = np.eye(4) * (1 / left - 1) / most
    seen = Estimate(0.0, Motion(np.zeros(3), np.zeros(2)), {}, "ok", cart, cart.parameters, covariance)
    assert (remedy(seen, np.array([0]), np.eye(4)[0], WrenchNoise()) is not None) == is_told


def test_an_estimate_without_a_covariance_is_refused():
    estimate = PaperFilter(guess(), ["hand"]).update(Measurement(0.0, np.zeros(3), np.zeros(3)))
    with pytest.raises(UsageError, match="covariance"):
        identifiability(estimate._replace(covariance=None))
