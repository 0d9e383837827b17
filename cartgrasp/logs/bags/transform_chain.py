"""Transforms along a path of frames, composed at the stamps of the one that moves fastest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from ...frames import Array
from ..mapped.processing_steps import ProcessingSteps
from ..mapped.resampling import Resampled, interpolated
from ..mapped.timed_samples import TimedSamples
from .transform_tree import Link, arrow, frames_on


def composed(
    role: str, path: Sequence[Link], links: Sequence[TimedSamples], max_gap: float, steps: ProcessingSteps
) -> TimedSamples:
    """Poses (n, 7) of the path's last frame in its first; static where all its links are."""
    moving = [i for i, link in enumerate(links) if not link.is_static]
    time, figures = np.zeros(1), {"samples": 1}
    if moving:
        start, end = common_span([links[i] for i in moving])
        inside = {i: links[i].time[(links[i].time >= start) & (links[i].time <= end)] for i in moving}
        fastest = max(moving, key=lambda i: len(inside[i]))
        time = inside[fastest]
        figures = {"samples": len(time), "left_out": len(links[fastest].time) - len(time)}
    found = [at_stamps(link, time, max_gap) for link in links]
    for i in moving:
        counts = {"taken": found[i].taken, "interpolated": found[i].interpolated, "masked": found[i].masked}
        steps.add(path[i].name, f"at the stamps of {path[fastest].name}", **counts)
    numbers = product([each.rows for each in found], [link.is_turned for link in path])
    figures["missing"] = int((~_whole(numbers)).sum())
    steps.add(role, f"{arrow(frames_on(path))} composed", links=len(path), **figures)
    return TimedSamples(time, numbers, not moving)


def common_span(moving: Sequence[TimedSamples]) -> tuple[float, float]:
    """From when all have begun until the first ends."""
    return max(c.span()[0] for c in moving), min(c.span()[1] for c in moving)


def at_stamps(link: TimedSamples, at: Array, max_gap: float) -> Resampled:
    """Positions and quaternions (n, 7): positions straight between neighbours, rotations by SLERP; NaN in gaps."""
    if link.is_static:
        return Resampled(np.tile(link.numbers[-1], (len(at), 1)), len(at), 0, 0)
    found = interpolated(link.time, link.numbers, at, max_gap)
    present, there = _whole(link.numbers), _whole(found.rows)
    if present.sum() > 1 and there.any():
        turning = Slerp(link.time[present], Rotation.from_quat(link.numbers[present, 3:]))
        found.rows[there, 3:] = turning(at[there]).as_quat()
    return found


def product(links: Sequence[Array], turned: Sequence[bool]) -> Array:
    """Poses (n, 7) of the last frame in the first; NaN where a link (n, 7) is missing; `turned` ones are inverted."""
    found = np.full_like(links[0], np.nan)
    there = np.logical_and.reduce([_whole(rows) for rows in links])
    if not there.any():
        return found
    pose = RigidTransform.identity()
    for rows, is_turned in zip(links, turned, strict=True):
        link = RigidTransform.from_components(rows[there, :3], Rotation.from_quat(rows[there, 3:]))
        pose = pose * (link.inv() if is_turned else link)
    position, rotation = pose.as_components()
    found[there] = np.column_stack([position, rotation.as_quat()])
    return found


def _whole(rows: Array) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(rows).all(axis=1))
