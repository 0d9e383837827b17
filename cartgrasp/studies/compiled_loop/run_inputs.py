"""What a compiled run is given beside its carts: where to be and to hold at each step, and what sensors will add."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planning.contact_sources.by_time import FixedContacts, PeriodicContacts
from planning.contact_sources.strategies import PERIODIC
from planning.references import PathReference, Stretch

from ...constraints import RollingConstraints
from ...contacts import grasp_map_planar
from ...frames import Array
from ...roles import ContactQuery, ContactSource
from ..scenario import Scenario
from .values import RunHistory, RunInputs


def inputs_of(scenario: Scenario) -> RunInputs:
    """Reference, contacts and laws, worked out for each step."""
    guess = scenario.guess
    time, pose, velocity, acceleration = _reference(
        scenario.stretches, guess.rolling, scenario.period, scenario.duration
    )
    names, turns = [arm.name for arm in scenario.arms], np.zeros(len(time), np.int64)
    contacts: ContactSource = FixedContacts(scenario.arms)
    if scenario.contacts == PERIODIC:
        every = scenario.choosing.every
        contacts, turns = PeriodicContacts(scenario.arms, every), (time / every + 1e-9).astype(int)
    _, first, place = np.unique(turns, return_index=True, return_inverse=True)
    held = [contacts.contacts(ContactQuery(float(time[k]), np.zeros(3))).contacts for k in first]
    points, yaws = np.array([[at[name] for name in names] for at in held]), np.array([arm.yaw for arm in scenario.arms])
    grasp = np.concatenate(list(np.moveaxis(grasp_map_planar(points, yaws), 1, 0)), axis=-1)
    reduced = guess.basis_b.T @ grasp
    each = np.tile(np.diag(scenario.noise.wrench_covariance), len(yaws))
    rolling, gains = guess.rolling, scenario.gains
    return RunInputs(
        time=time,
        pose=pose,
        velocity=velocity,
        acceleration=acceleration,
        place=place,
        points=points,
        grasp=grasp,
        grip=np.concatenate([reduced, (reduced * each) @ np.swapaxes(reduced, 1, 2)], axis=-1),
        basis=guess.basis_b.copy(),
        along=np.ascontiguousarray(rolling.along_b),
        law=np.array([rolling.axle_x or 0.0, rolling.angle, *gains.numbers]),
    )


@lru_cache(maxsize=8)
def _reference(
    stretches: tuple[Stretch, ...], rolling: RollingConstraints, period: float, duration: float | None
) -> tuple[Array, Array, Array, Array]:
    """Times of the steps, as the plant's clock adds them up, with pose, nu and nu' of the path."""
    path = PathReference(stretches, rolling)
    n = round((path.duration if duration is None else duration) / period)
    time = np.concatenate([[0.0], np.cumsum(np.full(n - 1, period))])
    found = [path.at(t) for t in time.tolist()]
    pose, velocity, acceleration = (
        np.array([getattr(one, name) for one in found]) for name in ("pose_sb", "velocity", "acceleration")
    )
    return time, pose, velocity, acceleration


def noise_of(scenario: Scenario, time: Array, n_state: int) -> RunHistory:
    """All that the sensors will add, drawn in the order in which `Sensors` draws."""
    noise, n, arms = scenario.sensors, len(time), len(scenario.arms)
    pose = np.tile([noise.position, noise.position, noise.heading], (n, 1))
    velocity = np.tile([noise.linear_velocity, noise.linear_velocity, noise.yaw_rate], (n, 1))
    felt = np.tile(np.repeat([noise.force, noise.moment], 3), (n, arms))
    due = [
        np.repeat(_due(time, period)[:, None], width, axis=1)
        for period, width in ((noise.pose_period, 3), (noise.velocity_period, 3), (noise.wrench_period, 6 * arms))
    ]
    is_drawn = np.hstack(due)
    drawn = np.full(is_drawn.shape, np.nan)
    drawn[is_drawn] = np.random.default_rng(scenario.seed).standard_normal(int(is_drawn.sum()))
    parts = np.split(drawn, [3, 6], axis=1)
    pose, velocity, felt = (np.ascontiguousarray(a * b) for a, b in zip((pose, velocity, felt), parts, strict=True))
    return RunHistory(np.empty((n, n_state)), np.empty((n, 6 * arms)), pose, velocity, felt)


def _due(time: Array, period: float | None) -> np.ndarray:
    """Whether a sensor gives a sample at each time."""
    due, found = 0.0, np.zeros(len(time), dtype=bool)
    if not period:
        return found if period is None else ~found
    for k, now in enumerate(time.tolist()):
        if now >= due - 1e-9:
            found[k], due = True, due + period
    return found
