"""Deviated references: they roll without slip, come back, and stay within their bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.frames import body_to_world, rotation_planar
from planning.excitation.deviation import DeviatedReference, Deviation, Wave, steady_part
from planning.references import PathReference, Stretch, chain, pause

STEP = 1e-5


def paths(speed, yaw, axle, angle=0.0):
    """Forward or backward, at a constant speed on a line or a curve, 4 s from 2 s on."""
    way = chain([Stretch(1.0, speed), Stretch(1.0, 0, yaw)], pause(4.0), [Stretch(1.0, 0, -yaw), Stretch(1.0, -speed)])
    return PathReference(way, RollingConstraints(axle, angle=angle))


WAVES = st.builds(Wave, st.floats(-0.05, 0.05), st.integers(0, 2))


@settings(max_examples=30)
@given(
    st.sampled_from([-0.6, 0.5, 0.9]),
    st.floats(-0.4, 0.4),
    st.sampled_from([(0.0, 0.0), (0.3, 0.0), (0.3, -0.2)]),
    WAVES,
    WAVES,
)
def test_it_rolls_without_slip(speed, yaw, wheels, along, across):
    """Pose, velocity and acceleration against differences of the pose, whose error is of order 1e-9 here."""
    base = paths(speed, yaw, *wheels)
    reference = DeviatedReference(base, (Deviation(2.0, 4.0, along, across),), base.constraints)
    basis_b = base.constraints.basis_b
    for time in np.linspace(2.1, 5.9, 13):
        here, before, after = (reference.at(t) for t in (time, time - STEP, time + STEP))
        rate_s = (after.pose_sb - before.pose_sb) / (2 * STEP)
        assert np.allclose(body_to_world(here.pose_sb[2]) @ basis_b @ here.velocity, rate_s, atol=1e-7)
        assert np.allclose((after.velocity - before.velocity) / (2 * STEP), here.acceleration, atol=1e-6)
        assert np.sign(here.velocity[0]) == np.sign(speed)


@settings(max_examples=30)
@given(WAVES, WAVES)
def test_it_stays_within_its_bounds_and_comes_back(along, across):
    base = paths(0.5, 0.3, 0.0)
    reference = DeviatedReference(base, (Deviation(2.5, 3.0, along, across),))
    for time in np.linspace(0.0, base.duration, 50):
        there, here = base.at(time), reference.at(time)
        offset = rotation_planar(there.pose_sb[2]).T @ (here.pose_sb - there.pose_sb)[:2]
        assert (np.abs(offset) <= np.abs([along.amplitude, across.amplitude]) + 1e-12).all()
        if not 2.5 < time < 5.5:
            assert np.array_equal(here.pose_sb, there.pose_sb)
    for time in (2.5, 5.5):
        for side in (-1e-6, 1e-6):
            near, there = reference.at(time + side), base.at(time + side)
            assert np.allclose(near.acceleration, there.acceleration, atol=1e-4)


@given(WAVES, st.floats(0.01, 0.99))
def test_wave_and_its_derivatives(wave, s):
    """Against the formula, and the derivatives against differences of one another."""
    duration, h = 3.0, 1e-5
    swing = np.sin(2 * np.pi * wave.swings * s) if wave.swings else 1.0
    value = wave.derivatives(np.array(s), duration)
    assert value[0] == pytest.approx(wave.amplitude * np.sin(np.pi * s) ** 4 * swing, abs=1e-15)
    ends = [wave.derivatives(np.array(s + side * h / duration), duration) for side in (1, -1)]
    assert np.allclose((ends[0] - ends[1])[:3] / (2 * h), value[1:], atol=1e-6)


def test_steady_part_is_the_longest_between_steps():
    way = chain(
        [Stretch(1.0, 0.5)], pause(2.0), [Stretch(1.0, 0.0, 0.4), Stretch(1.0, 0.0, -0.4)], [Stretch(1.0, -0.5)]
    )
    reference = PathReference(way)
    assert steady_part(reference, 0.5, 3.5) == pytest.approx((1.0, 3.0), abs=0.05)
    assert steady_part(reference, 1.2, 2.2) == pytest.approx((1.2, 2.2))


def test_deviations_may_not_overlap():
    with pytest.raises(UsageError, match="overlap"):
        DeviatedReference(paths(0.5, 0.0, 0.0), (Deviation(2.0, 2.0), Deviation(3.0, 2.0)))
