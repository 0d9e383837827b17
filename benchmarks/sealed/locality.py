"""When effects act that act in a time or a place alone, beside what a report says of where: F1 over a log's samples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .arms import arm_of
from .judging import Judgement, bare

LOCAL = ("external_push", "floor_patch", "payload_change")
ROWS = {
    "where: what is told first": lambda j: told_first(j.report, j.course),
    "where: the time or place of named effects": lambda j: acting(named(j.report), j.course, j.truth["world"]),
    "where: had every sample been told": lambda j: np.ones(len(j.course), dtype=bool),
}


def localisation(judgements: Sequence[Judgement]) -> str:
    """Means over logs in which all that is hidden is local, and of each effect."""
    lines = [f"{'F1 of samples told to disagree':<52} {'n':>3}    mean" + "".join(f"{name:>16}" for name in LOCAL)]
    for title, of in ROWS.items():
        found = [
            (j.case, f1(told, acting(j.truth["effects"], j.course, j.truth["world"])))
            for j in judgements
            if j.report is not None and j.course is not None and (told := of(j)) is not None
        ]
        if found:
            own = [[score for case, score in found if case == name] for name in LOCAL]
            cells = "".join(f"{np.mean(some):>16.2f}" if some else f"{'-':>16}" for some in own)
            lines.append(f"{title:<52} {len(found):>3} {np.mean([score for _, score in found]):>7.2f}{cells}")
    return "\n".join(lines) if len(lines) > 1 else ""


def is_local(truth: Mapping[str, Any]) -> bool:
    return bool(truth["effects"]) and all(e["name"] in LOCAL for e in truth["effects"])


def named(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Effects as a truth tells them."""
    return [
        {
            "name": bare(e["name"]),
            "parameters": {bare(k, last=True): v["value"] for k, v in e["parameters"].items()},
            "roughly": {},
            "arm": arm_of(e),
        }
        for e in report["effects"]
    ]


def acting(effects: Iterable[Mapping[str, Any]], course: np.ndarray, world: Mapping[str, float]) -> np.ndarray:
    """(n,), of a course (n, 4) of times and poses: whether an effect is there whose time or place is told."""
    time, found = course[:, 0], np.zeros(len(course), dtype=bool)
    for effect in effects:
        told = {**effect["parameters"], **effect["roughly"]}
        if effect["name"] == "external_push" and "start" in told:
            found |= (time >= told["start"]) & (time < told["start"] + told["duration"])
        elif effect["name"] == "payload_change" and "time" in told:
            found |= time >= told["time"]
        elif effect["name"] == "floor_patch" and "x_min" in told:
            for x, y in wheels(course, world):
                found |= (x > told["x_min"]) & (x < told["x_max"]) & (y > told["y_min"]) & (y < told["y_max"])
    return found


def wheels(course: np.ndarray, world: Mapping[str, float]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where fixed wheels and casters' swivels are, each (n,)."""
    _, x, y, heading = course.T
    fixed, ahead, side = world["half_track"], world["caster_x"], world["caster_y"]
    along, across = np.cos(heading), np.sin(heading)
    places = [(0.0, fixed), (0.0, -fixed), (ahead, side), (ahead, -side)]
    return [(x + dx * along - dy * across, y + dx * across + dy * along) for dx, dy in places]


def told_first(report: Mapping[str, Any], course: np.ndarray) -> np.ndarray | None:
    """(n,), by the condition of `where` that is told first; None of methods that have none."""
    if "where" not in report:
        return None
    time, found = course[:, 0], np.zeros(len(course), dtype=bool)
    for one in report["where"][:1]:
        for start, stop in one.get("intervals") or [(one["start"], one["stop"])]:
            found |= (time >= start) & (time <= stop)
    return found


def f1(told: np.ndarray, true: np.ndarray) -> float:
    both = int((told & true).sum())
    return 2 * both / max(int(told.sum() + true.sum()), 1)
