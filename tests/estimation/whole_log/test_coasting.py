"""A cart that rolls freely: for its mass, motion tells CoM, inertia and drag.

The log is integrated from Newton's and Euler's equations of a body whose axle goes straight ahead: with v = (u, 0) at
{b}, the CoM at (x, y) has the acceleration (u' - ω' y - ω² x, u ω + ω' x - ω² y).
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from estimation import CartFilter, identify
from estimation.discrepancy import diagnose
from estimation.whole_log.coasting import as_given, prior_of, with_known_wrench
from estimation.whole_log.replay import replay

MASS, COM, INERTIA, DRAG, TURNING = 30.0, (0.25, -0.04), 2.4, 3.0, 1.5
GUESS = CartModel(Inertia(MASS, (0.3, 0.0), 2.0), effects=(ViscousDrag(linear=4.0, angular=1.0),))


def rolled(seed, seconds=12.0):
    """Backwards, with the CoM behind: it swings round."""
    x, y = COM

    def rate(_, state):
        heading, u, turn = state[2:]
        # m (u' - ω' y) = -c u + m ω² x;  (J + m (x² + y²)) ω' - m y u' = -d ω - m x u ω
        left = np.array([[MASS, -MASS * y], [-MASS * y, INERTIA + MASS * (x * x + y * y)]])
        right = [-DRAG * u + MASS * turn**2 * x, -TURNING * turn - MASS * x * u * turn]
        return [u * np.cos(heading), u * np.sin(heading), turn, *np.linalg.solve(left, right)]

    time = np.arange(0.0, seconds, 0.01)
    start = [0.0, 0.0, 0.3, -1.4, 0.05]
    found = solve_ivp(rate, (0.0, seconds), start, t_eval=time, rtol=1e-10, atol=1e-12).y.T
    pose = found[:, :3] + 0.0005 * np.random.default_rng(seed).standard_normal((len(time), 3))
    return RunLog(time, pose, None, {}, name="rolled")


def is_told(parameters):
    true = {"com_x": COM[0], "com_y": COM[1], "inertia": INERTIA, "viscous_drag.linear": DRAG}
    for name, value in true.items():
        told = parameters[name]
        assert told.identifiable, name
        assert abs(told.value - value) < 3.5 * told.std + 0.01 * abs(value), name
        assert told.std < 0.1 * abs(value) + 0.003, name
    assert parameters["mass"].value == pytest.approx(MASS, rel=1e-12)
    assert parameters["mass"].std == 0.0
    assert not parameters["mass"].identifiable


@pytest.mark.parametrize("seed", [0, 1])
def test_a_fit_tells_the_body_for_its_mass(seed):
    is_told(identify([rolled(seed)], GUESS).parameters)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_filter_tells_the_body_for_its_mass(seed):
    log = with_known_wrench(rolled(seed))
    told = replay(log, CartFilter(GUESS, prior=prior_of([log], GUESS))).last
    assert str(told.health) == "ok"
    is_told({**told.parameters, "mass": identify([log], GUESS).parameters["mass"]})


def test_a_wrong_body_is_no_missing_effect():
    """Whether stretches agree is left open: one swing tells the inertia, and stretches without it don't."""
    found = diagnose(rolled(0), GUESS)
    assert not found.effects
    assert found.gap.refitted < 0.3 * found.gap.before
    assert found.parameter_mismatch["inertia"]["refitted"] == pytest.approx(INERTIA, rel=0.02)


def test_on_a_rail_nothing_tells_of_the_body():
    rail = CartModel(Inertia(MASS, COM, INERTIA), constraints=RollingConstraints(no_rotation=True))
    log = replace(rolled(0), pose=rolled(0).pose * [1.0, 0.0, 0.0])
    assert as_given([log], GUESS) == ("mass",)
    assert as_given([log], rail) == ("mass", "com_x", "com_y", "inertia")
