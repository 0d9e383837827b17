"""References obey the rolling constraint, end at rest, and go as far as they say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import body_to_world
from planning.references import PathReference, Stretch, chain, pause, speed_change, straight, turn

AXLES = {"axle": RollingConstraints(0.0), "axle ahead": RollingConstraints(0.5), "casters": RollingConstraints(None)}
AXLES["wheels at an angle"] = RollingConstraints(-0.3, angle=0.2)
CURVES = chain(speed_change(0.7), turn(1.2, 0.4), pause(0.7), turn(-0.8, 0.3), speed_change(-0.7))


@pytest.mark.parametrize("kind", AXLES)
def test_pose_is_the_integral_of_the_velocity(kind):
    """Against an adaptive integrator of qd = S(theta) nu, and so the constraint Lambda qd = 0 holds."""
    constraints = AXLES[kind]
    path = PathReference(CURVES, constraints, start_pose=(1.0, -2.0, 0.4))

    def rate(t, q):
        return body_to_world(q[2]) @ constraints.basis_b @ path.at(float(t)).velocity

    inner = np.cumsum([s.duration for s in CURVES])
    pose, begin = np.array([1.0, -2.0, 0.4]), 0.0
    for end in inner:
        solved = solve_ivp(rate, (begin, end - 1e-12), pose, rtol=1e-10, atol=1e-12)
        pose, begin = solved.y[:, -1], end
        np.testing.assert_allclose(path.at(end - 1e-12).pose_sb, pose, atol=1e-7)


@given(st.floats(0.0, 1.0))
def test_acceleration_is_the_rate_of_the_velocity(share):
    path = PathReference(CURVES)
    time = share * (path.duration - 1e-3)
    edges = np.cumsum([s.duration for s in CURVES])
    if np.abs(edges - time).min() < 1e-3:
        return
    ahead, behind = path.at(time + 1e-5), path.at(max(time - 1e-5, 0.0))
    span = ahead.time - behind.time
    np.testing.assert_allclose((ahead.velocity - behind.velocity) / span, path.at(time).acceleration, atol=1e-6)


def test_stands_still_before_and_after():
    path = PathReference(CURVES)
    end = path.at(path.duration + 5.0)
    np.testing.assert_array_equal(end.velocity, 0.0)
    np.testing.assert_array_equal(end.acceleration, 0.0)
    np.testing.assert_allclose(end.pose_sb, path.at(path.duration).pose_sb)
    assert path.at(-1.0).velocity @ path.at(-1.0).velocity == 0.0


@given(st.floats(-6, 6).filter(lambda d: abs(d) > 0.05), st.floats(0.2, 1.5), st.floats(0.2, 1.0))
def test_straight_goes_the_distance(distance, speed, acceleration):
    path = PathReference(chain(straight(distance, speed, acceleration)))
    assert path.at(path.duration).pose_sb[0] == pytest.approx(distance, rel=1e-9)
    speeds = [path.at(t).velocity[0] for t in np.linspace(0, path.duration, 50)]
    assert np.abs(speeds).max() <= speed + 1e-9


def test_no_way_and_no_angle_are_no_stretch():
    assert chain(straight(0.0, 0.5), turn(0.0, 0.4), straight(2.0, 0.5)) == chain(straight(2.0, 0.5))


@given(st.floats(-3, 3).filter(lambda a: abs(a) > 0.02), st.floats(0.1, 0.8), st.floats(0.2, 1.0))
def test_turn_turns_by_the_angle(angle, rate, acceleration):
    path = PathReference(chain(speed_change(0.5), turn(angle, rate, acceleration), speed_change(-0.5)))
    assert path.at(path.duration).pose_sb[2] == pytest.approx(angle, rel=1e-9)


@pytest.mark.parametrize(
    ("stretches", "why"),
    [((), "duration"), ((Stretch(0.0, 1.0),), "duration"), ((Stretch(1.0, 1.0),), "end at rest")],
)
def test_bad_stretches_are_refused(stretches, why):
    with pytest.raises(UsageError, match=why):
        PathReference(stretches)


def test_a_rail_can_not_turn():
    with pytest.raises(UsageError, match="rail"):
        PathReference(chain(turn(1.0, 0.5)), RollingConstraints(no_rotation=True))
