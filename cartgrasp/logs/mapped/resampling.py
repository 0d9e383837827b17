"""Samples of one clock on another: gaps are masked, never bridged."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...frames import Array

MAX_OFFSET_STEPS = 0.75
"""Steps: from here on a sample is another row's, be that one there or not."""


@dataclass(frozen=True)
class Resampled:
    """Rows (n, k), NaN where masked, and by how many rows each way came about."""

    rows: Array
    taken: int
    interpolated: int
    masked: int


def interpolated(time: Array, rows: Array, at: Array, max_gap: float) -> Resampled:
    """Straight between the neighbours that are at most `max_gap` apart; a sample at the very time is taken as it is,
    missing or not. Between samples, those that are missing in part count as gaps.
    """
    found = np.full((len(at), rows.shape[1]), np.nan)
    same = np.minimum(np.searchsorted(time, at), len(time) - 1)
    exact = time[same] == at
    found[exact] = rows[same[exact]]
    present = np.isfinite(rows).all(axis=1)
    knots, values = time[present], rows[present]
    after = np.searchsorted(knots, at)
    between = np.flatnonzero(~exact & (after > 0) & (after < len(knots)))
    right = after[between]
    gap = knots[right] - knots[right - 1]
    between, right, gap = between[gap <= max_gap], right[gap <= max_gap], gap[gap <= max_gap]
    share = ((at[between] - knots[right - 1]) / gap)[:, None]
    found[between] = (1 - share) * values[right - 1] + share * values[right]
    return Resampled(found, int(exact.sum()), len(between), len(at) - int(exact.sum()) - len(between))


def averaged(time: Array, rows: Array, at: Array, max_gap: float) -> Resampled:
    """Each row the mean of the samples that are nearer to it than to another row, and at most 3/4 of a usual step off.

    So no sample is in two rows, and neighbours share no noise. A row that no sample is near is interpolated; samples
    that are NaN don't count, and fill no row.
    """
    edges = np.concatenate([[-np.inf], (at[1:] + at[:-1]) / 2, [np.inf]])
    row = np.searchsorted(edges, time, side="right") - 1
    reach = min(max_gap / 2, MAX_OFFSET_STEPS * float(np.median(np.diff(at)))) if len(at) > 1 else max_gap / 2
    near = np.abs(time - at[row]) <= reach
    row, near_rows = row[near], rows[near]
    present = np.isfinite(near_rows)
    total, count = np.zeros((len(at), rows.shape[1])), np.zeros((len(at), rows.shape[1]))
    np.add.at(total, row, np.where(present, near_rows, 0.0))
    np.add.at(count, row, present)
    found = np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
    empty = np.ones(len(at), dtype=bool)
    empty[row] = False
    between = interpolated(time, rows, at[empty], max_gap)
    found[empty] = between.rows
    masked = int(np.isnan(found).all(axis=1).sum())
    filled = between.taken + between.interpolated
    return Resampled(found, len(at) - masked - filled, filled, masked)


def held(time: Array, rows: Array, at: Array, max_gap: float) -> Resampled:
    """The last sample at or before each time, at most `max_gap` old."""
    last = np.searchsorted(time, at, side="right") - 1
    there = (last >= 0) & (at - time[np.maximum(last, 0)] <= max_gap)
    found = np.where(there[:, None], rows[np.maximum(last, 0)], np.nan)
    return Resampled(found, int(there.sum()), 0, int((~there).sum()))


def stretches(time: Array, max_gap: float) -> list[slice]:
    """The parts without a gap."""
    cuts = [0, *(np.flatnonzero(np.diff(time) > max_gap) + 1).tolist(), len(time)]
    return [slice(a, b) for a, b in pairwise(cuts) if b > a]
