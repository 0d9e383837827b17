"""Noise floors read off a log: what is left of a channel when everything smooth is taken out.

Third differences annihilate a quadratic, and turn white noise of variance s² into 20 s²; their median size is robust
to jumps. What the log's motion can't show, the disturbance, is taken as a share of the forces at work. Velocities and
poses of two sensors may tell different motions: late, scaled or turned ones are as quiet as any, and wrong for long.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.errors import DataError
from cartgrasp.frames import Array, unwrapped
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import at_body
from cartgrasp.model import CartModel

from ..noise import FilterNoise
from .resolution import ROUNDING_STD, resolution
from .sample_step import usual_step
from .velocity_autocorrelation import noise_scale

MIN_POSITION_NOISE, MIN_VELOCITY_NOISE, MIN_FORCE_NOISE, MIN_MOMENT_NOISE = 2e-6, 1e-4, 0.01, 0.001
DISTURBANCE_FRACTION = 0.01
THIRD_DIFFERENCE_GAIN = 20**0.5
MAD_TO_STD = 1.4826
MIN_NOISE_FLOOR_SAMPLES = 8
COMPARED_SPAN = 0.5
"""s over which velocities are summed and held against the way between two poses."""
MIN_COMPARED_SPANS = 12
"""Spans that tell how far they usually are apart."""
SPREAD_QUANTILE, SPREAD_QUANTILE_SIGMAS = 0.9, 1.645
"""Quantile of normal numbers' sizes, and how many deviations it is: single glitches don't reach it."""
DISAGREEMENT_VARIANCE_RATIO = 2.0
"""Times the variance that noise alone makes, beyond which they disagree."""


def noise_of_log(log: RunLog, cart: CartModel) -> FilterNoise:
    """Sensor noise of this log, and a disturbance in proportion to its forces."""
    try:
        with np.errstate(over="raise", invalid="raise"):
            return _noise(at_body(log, cart), cart)
    except FloatingPointError as error:
        raise DataError(f"{log.name}: its numbers are too large to be SI units; mend them") from error


def _noise(log: RunLog, cart: CartModel) -> FilterNoise:
    usual, places = FilterNoise(), (*log.pose[:, :2].T, unwrapped(log.pose[:, 2]))
    position, heading = pose_noise(log.pose, (usual.position, usual.heading))
    linear = yaw = MIN_VELOCITY_NOISE
    if log.velocity is not None:
        along = (white_noise(log.velocity[:, i], usual.linear_velocity) for i in (0, 1))
        linear = max(*along, MIN_VELOCITY_NOISE)
        yaw = max(white_noise(log.velocity[:, 2], usual.yaw_rate), MIN_VELOCITY_NOISE)
        remembers = _noise_scale(log, cart)
        x, y, yaw = (
            velocity_noise(log.time, place, velocity, (of_place, remembers * own))
            for place, velocity, of_place, own in zip(
                places, log.velocity.T, (position, position, heading), (linear, linear, yaw), strict=True
            )
        )
        linear = max(x, y)
    wrenches = [arm.wrench for arm in log.arms.values()]
    force = max([MIN_FORCE_NOISE, *(noise_floor(w[:, i], usual.force) for w in wrenches for i in (0, 1))])
    moment = max([MIN_MOMENT_NOISE, *(noise_floor(w[:, 5], usual.moment) for w in wrenches)])
    return FilterNoise(
        position=position,
        heading=heading,
        linear_velocity=linear,
        yaw_rate=yaw,
        force=force,
        moment=moment,
        disturbance=max(DISTURBANCE_FRACTION * _force_size(log, cart), 0.01),
    )


def noise_floor(channel: Array, usual: float = 0.0) -> float:
    """Standard deviation of the white noise on a channel, from its third differences; the `usual` one where
    there are too few samples to tell."""
    present = channel[np.isfinite(channel)]
    if len(present) < MIN_NOISE_FLOOR_SAMPLES:
        return usual
    return float(MAD_TO_STD * np.median(np.abs(np.diff(present, 3))) / THIRD_DIFFERENCE_GAIN)


def white_noise(channel: Array, usual: float = 0.0) -> float:
    """Standard deviation of the white noise on a channel that does not jump, such as a motion. Where the channel comes
    in steps, it is at least that of rounding."""
    return max(noise_floor(channel, usual), resolution(channel) * ROUNDING_STD)


def pose_noise(pose: Array, usual: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float]:
    """White noise of positions (m) and headings (rad) of poses (n, 3)."""
    x, y, heading = *pose[:, :2].T, unwrapped(pose[:, 2])
    position = max(white_noise(x, usual[0]), white_noise(y, usual[0]), MIN_POSITION_NOISE)
    return position, max(white_noise(heading, usual[1]), MIN_POSITION_NOISE)


def velocity_noise(time: Array, place: Array, velocity: Array, white: tuple[float, float]) -> float:
    """Standard deviation of white noise of a velocity (n,) that spoils ways as much as they differ from those between
    places (n,); of places and velocities that agree, what they have: `white`."""
    of_place, of_velocity = white
    seen = np.isfinite(place) & np.isfinite(velocity)
    time, place, velocity = time[seen], place[seen], velocity[seen]
    if len(time) < MIN_COMPARED_SPANS:
        return of_velocity
    step = usual_step(time)
    ends = np.flatnonzero(np.diff(np.floor((time - time[0]) / COMPARED_SPAN), prepend=-1.0))
    whole = np.diff(time[ends]) < 2.0 * COMPARED_SPAN  # without a hole
    way = np.append(0.0, np.cumsum(np.diff(time) * (velocity[1:] + velocity[:-1]) / 2.0))
    off = (np.diff(place[ends]) - np.diff(way[ends]))[whole]
    if len(off) < MIN_COMPARED_SPANS:
        return of_velocity
    spread = float(np.quantile(np.abs(off), SPREAD_QUANTILE) / SPREAD_QUANTILE_SIGMAS) ** 2
    foretold = 2.0 * of_place**2 + of_velocity**2 * step * COMPARED_SPAN
    more = (spread - foretold) / (step * COMPARED_SPAN) if spread > DISAGREEMENT_VARIANCE_RATIO * foretold else 0.0
    return float(np.sqrt(of_velocity**2 + more))


def _noise_scale(log: RunLog, cart: CartModel) -> float:
    """The noise scale of recorded velocities; 1 for a cart that may go any way."""
    axle = cart.constraints.axle_x
    if axle is None or log.velocity is None:
        return 1.0
    seen = np.isfinite(log.pose[:, 2]) & np.isfinite(log.velocity).all(axis=1)
    rolling = log.pose[seen, 2] + np.arctan2(cart.basis_b[1, 0], cart.basis_b[0, 0])
    x, y, yaw = log.velocity[seen].T
    return noise_scale(log.time[seen], np.cos(rolling) * y - np.sin(rolling) * x + axle * yaw)


def _force_size(log: RunLog, cart: CartModel) -> float:
    """Root mean square of the forward force on the cart, N."""
    total = np.zeros(len(log))
    for arm in log.arms.values():
        total += np.einsum("ni,ni->n", grasp_map_planar(arm.contact)[:, 0], arm.wrench)
    return float(np.sqrt(np.nanmean(total**2))) if np.isfinite(total).any() else 0.0
