"""Frames and grasp maps by the road of 4 x 4 transformations, points and virtual power."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given

from cartgrasp.contacts import ContactWrenches, grasp_map_planar, grasp_map_spatial
from cartgrasp.frames import (
    adjoint,
    body_to_world,
    rotation_planar,
    rotation_z,
    skew,
    unwrapped,
    wrap_angle,
)

from .drawn import numbers, vectors

PLANAR_BASIS = np.eye(6)[:, [0, 1, 5]]  # B of (22)
yaws = numbers(-4, 4)
points = vectors(3, -1.5, 1.5)
wrenches_a = vectors(6, -80, 80)


def transformation(position, yaw):
    """g_ba, 4 x 4: of a point's coordinates in {a} to those in {b}."""
    return np.block([[rotation_z(yaw), np.array(position)[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])


def adjoint_of(g):
    rotation, position = g[:3, :3], g[:3, 3]
    return np.block([[rotation, skew(position) @ rotation], [np.zeros((3, 3)), rotation]])


@given(p=points, yaw=yaws)
def test_planar_grasp_map_is_the_composition_of_22_and_23(p, yaw):
    """G = Bᵀ Ad_{g_ab}ᵀ with g_ab the inverse of g_ba: (22) to (24) with frames that compose (physics.md)."""
    g_ab = np.linalg.inv(transformation(p, yaw))
    np.testing.assert_allclose(grasp_map_spatial(p, yaw), adjoint_of(g_ab).T, atol=1e-12)
    np.testing.assert_allclose(grasp_map_planar(p, yaw), PLANAR_BASIS.T @ adjoint_of(g_ab).T, atol=1e-12)
    np.testing.assert_allclose(adjoint(g_ab[:3, :3], g_ab[:3, 3]), adjoint_of(g_ab), atol=1e-15)


@given(p=points)
def test_lever_arms_of_parallel_axes(p):
    x, y, _ = p
    by_hand = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [-y, x, 0, 0, 0, 1]]
    np.testing.assert_allclose(grasp_map_planar(p), by_hand, atol=1e-15)


@given(p=points, yaw=yaws, wrench_a=wrenches_a, twist_b=vectors(3, -2, 2))
def test_the_power_of_a_wrench_is_the_same_in_either_frame(p, yaw, wrench_a, twist_b):
    """The contact moves with v_p = v + omega x p, seen in {a}; power needs no adjoint."""
    u, w, r = twist_b
    point_velocity = rotation_z(yaw).T @ np.array([u - r * p[1], w + r * p[0], 0.0])
    power_a = wrench_a[:3] @ point_velocity + wrench_a[5] * r
    power_b = grasp_map_planar(p, yaw) @ wrench_a @ twist_b
    np.testing.assert_allclose(power_b, power_a, rtol=1e-12, atol=1e-11)
    spatial_twist = np.array([u, w, 0, 0, 0, r])
    np.testing.assert_allclose(grasp_map_spatial(p, yaw) @ wrench_a @ spatial_twist, power_a, rtol=1e-12, atol=1e-11)


@given(p=points, yaw=yaws, wrench_a=wrenches_a)
def test_moment_is_force_times_lever_plus_moment(p, yaw, wrench_a):
    force_b = rotation_planar(yaw) @ wrench_a[:2]
    expected = [*force_b, p[0] * force_b[1] - p[1] * force_b[0] + wrench_a[5]]
    np.testing.assert_allclose(grasp_map_planar(p, yaw) @ wrench_a, expected, atol=1e-11)


@given(p=vectors(6, -1, 1), yaw=yaws, wrenches=vectors(12, -80, 80))
def test_contact_wrenches_add_up(p, yaw, wrenches):
    given_wrenches = ContactWrenches(
        {"left": wrenches[:6], "right": wrenches[6:]}, {"left": p[:3], "right": p[3:]}, {"right": yaw}
    )
    expected = grasp_map_spatial(p[:3]) @ wrenches[:6] + grasp_map_spatial(p[3:], yaw) @ wrenches[6:]
    np.testing.assert_allclose(given_wrenches.wrench_b, PLANAR_BASIS.T @ expected, atol=1e-11)
    assert not ContactWrenches().wrench_b.any()


def test_grasp_maps_broadcast():
    generator = np.random.default_rng(1)
    p, yaw = generator.normal(size=(4, 1, 3)), generator.normal(size=(5,))
    stacked = grasp_map_planar(p, yaw)
    assert stacked.shape == (4, 5, 3, 6)
    for i in range(4):
        for j in range(5):
            np.testing.assert_array_equal(stacked[i, j], grasp_map_planar(p[i, 0], yaw[j]))


@given(angle=numbers(-100, 100))
@example(angle=np.nextafter(-np.pi, -np.inf))
@example(angle=np.pi)
@example(angle=-np.pi)
@example(angle=1e-20)
def test_wrapped_angles_are_the_same_angle_from_minus_pi_up_to_pi(angle):
    wrapped = wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    np.testing.assert_allclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-13)


@given(angle=numbers(-10, 10), planar=vectors(3, -2, 2))
def test_world_and_body_components(angle, planar):
    turned = complex(planar[0], planar[1]) * np.exp(1j * angle)
    np.testing.assert_allclose(body_to_world(angle) @ planar, [turned.real, turned.imag, planar[2]], atol=1e-12)


@given(a=vectors(3, -2, 2), b=vectors(3, -2, 2))
def test_skew_is_the_cross_product(a, b):
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-15)


def test_a_heading_without_jumps_is_the_same_heading_and_leaves_out_what_is_missing():
    turning = np.linspace(0.0, 40.0, 200)
    told = wrap_angle(turning)
    told[[3, 50, 51, 199]] = np.nan
    seen = np.isfinite(told)
    np.testing.assert_allclose(unwrapped(told)[seen], turning[seen], atol=1e-12)
    assert np.isnan(unwrapped(told)[~seen]).all()
    np.testing.assert_allclose(unwrapped(np.degrees(told), 360.0)[seen], np.degrees(turning[seen]), atol=1e-9)
