"""What the player shows of a run: plain numbers and words, thinned to video rate.

A column is one number that never changes, or `[decimals, first, difference, …]`: whole numbers of the last decimal,
each less the one before it. A missing sample is None, and differences go on from the last that is there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..frames import Array
from ..simulation.record import Series
from ..wheels import CASTER
from .shown_run import ShownRun

PLAYER_FRAMES_PER_SECOND = 30.0
MAX_PLAYER_FRAMES = 3600
"""Beyond it (two minutes at full rate) frames lie further apart and the player interpolates more."""

PARAMETER_LABELS = {"mass": "Mass", "com_x": "CoM x", "com_y": "CoM y", "inertia": "Yaw inertia"}

Column = float | list[int | None] | None


def player_data(run: ShownRun, title: str) -> dict[str, Any]:
    """Everything the page needs, ready for JSON."""
    frames = frame_indices(run.time)
    reference, error = run.reference_pose, run.tracking_error
    return {
        "title": title,
        "run": run.name,
        "cart": _cart(run),
        "frames": len(frames),
        "time": column(run.time[frames], 3),
        "pose": _columns(run.pose[frames]),
        "velocity": _columns(run.velocity_b[frames], 3),
        "reference": None if reference is None else _columns(reference[frames]),
        "error": None if error is None else column(100.0 * error[frames], 3),
        "casters": _casters(run, frames),
        "arms": [_arm(run, name, frames) for name in run.contacts],
        "parameters": [_parameter(name, series, frames) for name, series in run.parameters.items()],
        "correlation": _correlation(run, frames),
        "status": _told(run.statuses, frames, len(run.time)),
        "health": _told(run.healths, frames, len(run.time)),
    }


def frame_indices(time: Array) -> np.ndarray:
    """Samples to show: about `PLAYER_FRAMES_PER_SECOND`, at most `MAX_PLAYER_FRAMES`, with both ends of every gap."""
    duration = float(time[-1] - time[0])
    step = max(1.0 / PLAYER_FRAMES_PER_SECOND, duration / (MAX_PLAYER_FRAMES - 1))
    instants = time[0] + step * np.arange(int(duration / step) + 1)
    found = np.minimum(np.searchsorted(time, instants - 1e-9), len(time) - 1)
    gaps = np.flatnonzero(np.diff(time) > step)
    return np.unique(np.concatenate([found, gaps, gaps + 1, [len(time) - 1]]))


def column(values: ArrayLike, decimals: int = 4) -> Column:
    """Rounded numbers; one where all are the same; None where not finite, or so large that JSON's readers round."""
    with np.errstate(over="ignore"):
        scaled = np.asarray(values, dtype=float) * 10.0**decimals
    known = np.abs(scaled) < 2.0**52
    whole = np.round(scaled[known]).astype(np.int64)
    if not len(whole):
        return None
    if known.all() and (whole == whole[0]).all():
        return float(whole[0] / 10.0**decimals)
    differences = iter(np.diff(whole, prepend=0).tolist())
    return [decimals, *(next(differences) if there else None for there in known.tolist())]


def _columns(values: Array, decimals: int = 4) -> list[Column]:
    return [column(one, decimals) for one in values.T]


def _cart(run: ShownRun) -> dict[str, Any]:
    cart = run.cart
    return {
        "name": "" if cart is None else cart.name,
        "body": [round(v, 4) for v in run.outline],
        "com": None if cart is None else [round(float(v), 4) for v in cart.inertia.com],
        "wheels": [
            {"caster": w.kind == CASTER, "x": w.x, "y": w.y, "trail": w.trail} for w in (cart.wheels if cart else ())
        ],
    }


def _casters(run: ShownRun, frames: np.ndarray) -> list[Column] | None:
    """Heading of each listed caster in {b}, or None where it is not known."""
    count = 0 if run.cart is None else sum(w.kind == CASTER for w in run.cart.wheels)
    headings = run.caster_headings
    if headings is None or headings.shape[1] != count:
        return None
    return _columns(headings[frames], 3)


def _arm(run: ShownRun, name: str, frames: np.ndarray) -> dict[str, Any]:
    wrench = run.wrenches[name][frames]
    return {
        "name": name,
        "contact": _columns(run.contacts[name][frames, :2]),
        "force": _columns(wrench[:, :3], 2),
        "moment": _columns(wrench[:, 3:], 3),
    }


def _correlation(run: ShownRun, frames: np.ndarray) -> Column:
    """The correlation of the CoM's estimated coordinates."""
    if run.com_covariance is None:
        return None
    covariance = run.com_covariance[frames]
    with np.errstate(invalid="ignore", divide="ignore"):
        return column(covariance[:, 0, 1] / np.sqrt(covariance[:, 0, 0] * covariance[:, 1, 1]), 3)


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


def _told(said: Sequence[str], frames: np.ndarray, n: int) -> dict[str, Any] | None:
    """The distinct ones of words spread over n instants, and for each frame the worst one since the frame before."""
    if not said:
        return None
    words = sorted(set(said), key=_severity)
    every = np.array([words.index(word) for word in said])[np.arange(n) * len(said) // n]
    starts = np.concatenate([[0], frames[:-1] + 1])
    worst = np.maximum.reduceat(every, starts).tolist()
    return {"words": words, "grades": [_severity(w)[0] for w in words], "index": worst}


def _severity(word: str) -> tuple[int, str]:
    """0 as wished, 1 with a reservation, 2 anything else."""
    return {"optimal": 0, "ok": 0, "relaxed": 1, "load_changed": 1, "outliers": 1}.get(word, 2), word
