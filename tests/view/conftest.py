"""A run to look at: 60 s at 100 Hz round two bends, with the wrenches that the motion really needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs.run_log import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.simulation.record import RunRecord, Series
from cartgrasp.view.shown_run import ShownRun
from cartgrasp.wheels import Wheel

STEP = 0.01
DRAG = np.array([14.0, 2.5])  # N·s/m and N·m·s/rad


def shopping_cart() -> CartModel:
    """The example of the contract of the cart file, with its CoM off the middle line."""
    return CartModel(
        inertia=Inertia(24.0, (0.30, 0.05), 2.0),
        constraints=RollingConstraints(axle_x=0.0),
        wheels=(
            Wheel("fixed", 0.0, 0.27),
            Wheel("fixed", 0.0, -0.27),
            Wheel("caster", 0.72, 0.20, trail=0.045),
            Wheel("caster", 0.72, -0.20, trail=0.045),
        ),
        name="shopping cart",
    )


def reference(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses and (u, r): back for a moment, then forward through a bend to the left and one to the right."""

    def bump(start: float, stop: float, ramp: float) -> np.ndarray:
        rise = np.clip((time - start) / ramp, 0, 1)
        fall = np.clip((stop - time) / ramp, 0, 1)
        return np.minimum(rise, fall) ** 2 * (3 - 2 * np.minimum(rise, fall))

    u = -0.2 * bump(1, 5, 0.8) + 0.5 * bump(6, 58, 2.5)
    r = 0.22 * bump(13, 27, 3) - 0.26 * bump(33, 48, 3)
    theta = np.cumsum(r) * STEP
    pose = np.stack([np.cumsum(u * np.cos(theta)), np.cumsum(u * np.sin(theta)), theta / STEP], 1) * STEP
    return pose, np.stack([u, r], 1)


def follow(pose_r: np.ndarray, velocity_r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From 12 cm beside the reference on to it by a Kanayama law: poses, (u, r) and their rates."""
    n = len(pose_r)
    pose, velocity, rate = np.zeros((n, 3)), np.zeros((n, 2)), np.zeros((n, 2))
    pose[0] = [-0.05, 0.11, 0.06]
    for i in range(n):
        c, s = np.cos(pose[i, 2]), np.sin(pose[i, 2])
        gap = pose_r[i] - pose[i]
        ahead, aside = c * gap[0] + s * gap[1], -s * gap[0] + c * gap[1]
        u_r, r_r = velocity_r[i]
        wish = u_r * np.cos(gap[2]) + 0.8 * ahead, r_r + 4.0 * u_r * aside + 1.5 * np.sin(gap[2])
        rate[i] = (np.array(wish) - velocity[i]) / 0.15
        if i + 1 < n:
            velocity[i + 1] = velocity[i] + STEP * rate[i]
            u, r = velocity[i + 1]
            pose[i + 1] = pose[i] + STEP * np.array([u * c, u * s, r])
    return pose, velocity, rate


def needed_wrench(cart: CartModel, velocity: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """(fx, tau) of the reduced dynamics (physics.md), under viscous drag."""
    (u, r), (du, dr) = velocity.T, rate.T
    m, m_dx, m_dy, J = cart.inertia.phi
    fx = m * du - m_dy * dr - m_dx * r**2 + DRAG[0] * u
    tau = J * dr - m_dy * du + m_dx * u * r + DRAG[1] * r
    return np.stack([fx, tau], 1)


def shared(wrench: np.ndarray, contacts: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The least-norm (fx, fy, tz) of two arms that sum up to (fx, tau), as wrenches (n, 6)."""
    grasps = []
    for points in contacts.values():
        one, zero = np.ones(len(points)), np.zeros(len(points))
        grasps.append(np.stack([np.stack([one, zero, zero], 1), np.stack([-points[:, 1], points[:, 0], one], 1)], 1))
    weights = np.array([1.0, 1.0, 0.1, 0.8, 0.3, 0.04])  # the right arm is the weaker one
    grasp = np.concatenate(grasps, axis=2)
    inner = np.linalg.solve((grasp * weights) @ np.swapaxes(grasp, 1, 2), wrench[..., None])
    parts = (weights[:, None] * np.swapaxes(grasp, 1, 2) @ inner)[..., 0]
    wrenches = {}
    for i, arm in enumerate(contacts):
        wrenches[arm] = np.zeros((len(wrench), 6))
        wrenches[arm][:, [0, 1, 5]] = parts[:, 3 * i : 3 * i + 3]
        wrenches[arm][:, 2] = -4.0  # the weight of the hand
    return wrenches


def caster_headings(cart: CartModel, velocity: np.ndarray) -> np.ndarray:
    """Headings in {b} under the trail model, from casters that lie askew."""
    casters = [w for w in cart.wheels if w.kind == "caster"]
    headings = np.zeros((len(velocity), len(casters)))
    headings[0] = [0.5, -0.3]
    for i, (u, r) in enumerate(velocity[:-1]):
        for k, wheel in enumerate(casters):
            across = -np.sin(headings[i, k]) * (u - wheel.y * r) + np.cos(headings[i, k]) * wheel.x * r
            headings[i + 1, k] = headings[i, k] + STEP * (across / wheel.trail - r)
    return headings


def learnt(truth: float, first: float, sigma: float, information: np.ndarray, unit: str, seed: int) -> Series:
    """An estimate that goes from a first guess to the truth as information comes in, within its own band."""
    std = 1.0 / np.sqrt(1.0 / sigma**2 + information)
    share = (std / sigma) ** 2
    wander = np.cumsum(np.random.default_rng(seed).normal(size=len(std))) * np.sqrt(STEP / 4)
    wander *= np.exp(-((np.arange(len(std)) * STEP - 60) ** 2) / 5000)
    value = truth + (first - truth) * share + 0.35 * std * (1 - share) * wander
    return Series(value, std, np.full(len(std), truth), unit)


@pytest.fixture(scope="session")
def record() -> RunRecord:
    cart = shopping_cart()
    time = np.arange(0, 60, STEP)
    pose_r, velocity_r = reference(time)
    pose, velocity, rate = follow(pose_r, velocity_r)
    regrasp = np.where(time < 30, 0.22, 0.10)[:, None] * [[0.0, 1.0, 0.0]]
    left = np.array([[-0.25, 0.0, 1.0]]) + regrasp
    contacts = {"left": left, "right": np.tile([-0.25, -0.22, 1.0], (len(time), 1))}
    wrenches = shared(needed_wrench(cart, velocity, rate), contacts)
    noise = np.random.default_rng(0)
    log = RunLog(
        time=time,
        pose=pose + noise.normal(scale=0.0004, size=pose.shape),
        velocity=None,
        arms={a: ArmLog(contacts[a], w + noise.normal(scale=0.5, size=w.shape)) for a, w in wrenches.items()},
        name="two bends",
    )
    du, r, dr = rate[:, 0], velocity[:, 1], rate[:, 1]
    parameters = {
        "mass": learnt(24.0, 16.0, 4.0, 0.5 * np.cumsum(du**2), "kg", 1),
        "com_x": learnt(0.30, 0.15, 0.15, 60 * np.cumsum(r**2 + dr**2), "m", 2),
        "com_y": learnt(0.05, 0.0, 0.10, 300 * np.cumsum(du**2), "m", 3),
        "inertia": learnt(2.0, 1.2, 0.8, 4 * np.cumsum(dr**2), "kg m²", 4),
        "viscous_drag.linear": learnt(14.0, 8.0, 4.0, 0.02 * np.cumsum(velocity[:, 0] ** 2), "N·s/m", 5),
    }
    relaxed = (time > 33.2) & (time < 34.4)
    return RunRecord(
        log=log,
        cart=cart,
        pose=pose,
        velocity=velocity,
        reference_pose=pose_r,
        reference_velocity=velocity_r,
        wrenches=wrenches,
        parameters=parameters,
        caster_headings=caster_headings(cart, velocity),
        statuses=tuple("relaxed" if bad else "optimal" for bad in relaxed),
    )


@pytest.fixture
def bare_record(record: RunRecord) -> RunRecord:
    """A run of one arm without wheels, estimates, casters or statuses, a tenth as long."""
    first = slice(0, 600)
    arm = ArmLog(record.log.arms["left"].contact[first], record.log.arms["left"].wrench[first])
    return replace(
        record,
        log=RunLog(record.time[first], record.log.pose[first], None, {"only": arm}, "bare"),
        cart=replace(record.cart, wheels=()),
        pose=record.pose[first],
        velocity=record.velocity[first],
        reference_pose=record.reference_pose[first],
        reference_velocity=record.reference_velocity[first],
        wrenches={},
        parameters={},
        caster_headings=None,
        statuses=(),
    )


@pytest.fixture(scope="session")
def shown(record: RunRecord) -> ShownRun:
    return ShownRun.of_record(record)


@pytest.fixture
def bare(bare_record: RunRecord) -> ShownRun:
    return ShownRun.of_record(bare_record)
