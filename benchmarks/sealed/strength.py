"""How plainly an effect shows: what is left of the recorded wrench when mass, CoM, inertia and drag are refitted
without noise, beside the noise; white, or what is new in each sample of autocorrelated noise."""

from __future__ import annotations

import numpy as np

from .robots import followed
from .scenes import Scene
from .world import R, U, W


def planar(contacts: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
    """Recorded (fx, tau) about {b}'s origin, (n, 2)."""
    levers = contacts[..., 0] * wrenches[..., 1] - contacts[..., 1] * wrenches[..., 0]
    return np.column_stack([wrenches[..., 0].sum(axis=1), (levers + wrenches[..., 5]).sum(axis=1)])


def regressors(states: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(n, 2, 6): of m, m com_x, m com_y, J, linear and angular drag."""
    u, r, du, dr = states[:, U], states[:, R], rates[:, U], rates[:, R]
    zero = np.zeros_like(u)
    force = np.column_stack([du, -r * r, -dr, zero, u, zero])
    moment = np.column_stack([zero, u * r, -du, dr, zero, r])
    return np.stack([force, moment], axis=1)


def strength(scene: Scene, states: np.ndarray, rates: np.ndarray, recorded: np.ndarray) -> dict[str, float]:
    """`force_share` and `moment_share`: rms left over rms; `z`: sqrt of the sum of squares over the noise's, with which
    nobody sees the effect better who knows the motion, the noise and the effect's form; empty where nobody pushes."""
    if not scene.arms:
        return {}
    contacts, sensors = scene.drive.contacts.copy(), scene.sensors
    for arm, away in sensors.beside.items():
        contacts[:, arm] -= away
    seen = planar(contacts, recorded)
    lever = (contacts[..., 0] ** 2 + contacts[..., 1] ** 2).sum(axis=1)
    k = contacts.shape[1]
    noise = np.column_stack(
        [
            np.full(len(seen), sensors.force_noise * np.sqrt(k)),
            np.sqrt(sensors.force_noise**2 * lever + k * sensors.moment_noise**2),
        ]
    )
    design = regressors(states, rates)
    if scene.world.rail:  # it takes any moment, which tells nothing of the cart
        seen[:, 1], design[:, 1] = 0.0, 0.0
    rows = (design / noise[:, :, None]).reshape(-1, 6)
    found, *_ = np.linalg.lstsq(rows, (seen / noise).ravel(), rcond=1e-9)
    left = (seen / noise - (rows @ found).reshape(-1, 2)) * noise
    share = np.sqrt((left**2).mean(axis=0) / np.maximum((seen**2).mean(axis=0), 1e-12))
    new = _innovations(
        np.concatenate([rows.reshape(-1, 2, 6), (seen / noise)[..., None]], axis=2), scene.drive.time, sensors.colour
    )
    flat = new.reshape(-1, 7)
    beside, *_ = np.linalg.lstsq(flat[:, :6], flat[:, 6], rcond=1e-9)
    slip = float(np.sqrt((followed(sensors, states)[:, W] ** 2).mean()))
    return {
        "force_share": float(share[0]),
        "moment_share": float(share[1]),
        "z": float(np.linalg.norm(flat[:, 6] - flat[:, :6] @ beside)),
        "lateral_speed": slip,
    }


def _innovations(samples: np.ndarray, time: np.ndarray, colour: float) -> np.ndarray:
    """Samples (n, ...) in units of noise that is white, or a first-order autoregression, less what is foretold."""
    if not colour:
        return samples
    keep = np.exp(-np.diff(time) / colour).reshape(-1, *[1] * (samples.ndim - 1))
    return np.concatenate([samples[:1], (samples[1:] - keep * samples[:-1]) / np.sqrt(1 - keep**2)])
