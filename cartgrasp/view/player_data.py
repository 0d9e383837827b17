"""What the player shows of a run: a `RunRecord` as plain numbers and words, thinned to video rate.

A column is a list with a number for each frame, or one number that never changes; a missing sample is None.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..frames import Array
from ..inertia import Inertia
from ..model import CartModel
from ..simulation.record import RunRecord, Series
from ..wheels import CASTER

FRAMES_PER_SECOND = 30.0
MOST_FRAMES = 3600
"""Beyond it (two minutes at full rate) frames lie further apart and the player interpolates more."""

MARGIN = 0.08
"""m, from the wheels to the drawn edge of the body."""

PARAMETER_LABELS = {"mass": "Mass", "com_x": "CoM x", "com_y": "CoM y", "inertia": "Yaw inertia"}

Column = float | list[float | None] | None


def player_data(record: RunRecord, title: str) -> dict[str, Any]:
    """Everything the page needs, ready for JSON."""
    frames = frame_indices(record.time)
    return {
        "title": title,
        "run": record.log.name,
        "cart": _cart(record.cart),
        "time": np.round(record.time[frames], 3).tolist(),
        "pose": [column(record.pose[frames, i]) for i in range(3)],
        "reference": [column(record.reference_pose[frames, i]) for i in range(3)],
        "speed": column(_speed(record)[frames], 3),
        "error": column(100.0 * record.tracking_error[frames], 3),
        "casters": _casters(record, frames),
        "arms": _arms(record, frames),
        "parameters": [_parameter(name, series, frames) for name, series in record.parameters.items()],
        "status": _status(record.statuses, frames, len(record.time)),
    }


def frame_indices(time: Array) -> np.ndarray:
    """Samples to show: about `FRAMES_PER_SECOND`, at most `MOST_FRAMES`, with both ends of every gap."""
    duration = float(time[-1] - time[0])
    step = max(1.0 / FRAMES_PER_SECOND, duration / (MOST_FRAMES - 1))
    instants = time[0] + step * np.arange(int(duration / step) + 1)
    found = np.minimum(np.searchsorted(time, instants - 1e-9), len(time) - 1)
    gaps = np.flatnonzero(np.diff(time) > step)
    return np.unique(np.concatenate([found, gaps, gaps + 1, [len(time) - 1]]))


def column(values: ArrayLike, decimals: int = 4) -> Column:
    """Rounded numbers; one where all are the same; None where not finite."""
    rounded = np.round(np.asarray(values, dtype=float), decimals) + 0.0
    plain = [float(v) if np.isfinite(v) else None for v in rounded]
    return plain[0] if all(v == plain[0] for v in plain) else plain


def body_outline(cart: CartModel) -> tuple[float, float, float, float]:
    """(x_min, x_max, y_min, y_max) in {b}, m: round wheels and CoM, or a box of the same inertia."""
    (x, y), about_com, mass = cart.inertia.com, cart.inertia.about_com, cart.inertia.mass
    if not cart.wheels:
        half_width = float(np.sqrt(3.0 * about_com / mass / 3.25))
        return x - 1.5 * half_width, x + 1.5 * half_width, y - half_width, y + half_width
    points = np.array([*((w.x, w.y) for w in cart.wheels), (x, y)])
    centre, half = (points.min(0) + points.max(0)) / 2, (points.max(0) - points.min(0)) / 2
    half = np.maximum(half + MARGIN, 0.15)
    low, high = centre - half, centre + half
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _cart(cart: CartModel) -> dict[str, Any]:
    inertia: Inertia = cart.inertia
    return {
        "name": cart.name,
        "body": [round(v, 4) for v in body_outline(cart)],
        "com": [round(float(v), 4) for v in inertia.com],
        "wheels": [{"caster": w.kind == CASTER, "x": w.x, "y": w.y, "trail": w.trail} for w in cart.wheels],
    }


def _speed(record: RunRecord) -> Array:
    """Speed of {b}'s origin, (n,), m/s; negative while it rolls backward."""
    velocity_b = record.velocity @ record.cart.basis_b.T
    return np.copysign(np.hypot(velocity_b[:, 0], velocity_b[:, 1]), velocity_b[:, 0])


def _casters(record: RunRecord, frames: np.ndarray) -> list[Column] | None:
    """Heading of each listed caster in {b}, or None where it is not known."""
    count = sum(w.kind == CASTER for w in record.cart.wheels)
    headings = record.caster_headings
    if headings is None or headings.shape[1] != count:
        return None
    return [column(headings[frames, i], 3) for i in range(count)]


def _arms(record: RunRecord, frames: np.ndarray) -> list[dict[str, Any]]:
    """Contacts as logged; wrenches as really given, or as measured where the truth is not known."""
    arms = []
    for name, log in record.log.arms.items():
        wrench = np.asarray(record.wrenches.get(name, log.wrench))[frames]
        contact = log.contact[frames]
        arms.append(
            {
                "name": name,
                "contact": [column(contact[:, i]) for i in (0, 1)],
                "force": [column(wrench[:, i], 2) for i in (0, 1)],
                "moment": column(wrench[:, 5], 3),
            }
        )
    return arms


def _parameter(name: str, series: Series, frames: np.ndarray) -> dict[str, Any]:
    truth = None if series.truth is None else np.broadcast_to(series.truth, series.value.shape)
    return {
        "name": name,
        "label": PARAMETER_LABELS.get(name, name),
        "unit": series.unit,
        "value": _significant(series.value[frames]),
        "std": _significant(series.std[frames]),
        "truth": None if truth is None else _significant(truth[frames]),
    }


def _significant(values: Array, digits: int = 5) -> Column:
    """A column with `digits` significant digits at its largest number."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max(initial=0.0))
    return column(values, digits - 1 - int(np.floor(np.log10(largest))) if largest > 0 else 0)


def _status(statuses: Sequence[str], frames: np.ndarray, n: int) -> dict[str, Any] | None:
    """The distinct words, and for each frame the worst one since the frame before."""
    if not statuses:
        return None
    words = sorted(set(statuses), key=_severity)
    rank: Mapping[str, int] = {word: i for i, word in enumerate(words)}
    every = np.array([rank[word] for word in statuses])
    every = every[(np.arange(n) * len(every)) // n]
    starts = np.concatenate([[0], frames[:-1] + 1])
    return {
        "words": words,
        "grades": [_severity(w)[0] for w in words],
        "index": _worst(every, starts, frames),
    }


def _worst(ranks: np.ndarray, starts: np.ndarray, stops: np.ndarray) -> list[int]:
    return [int(ranks[a : b + 1].max()) for a, b in zip(starts, stops, strict=True)]


def _severity(word: str) -> tuple[int, str]:
    """0 as wished, 1 relaxed, 2 anything else."""
    return {"optimal": 0, "relaxed": 1}.get(word, 2), word
