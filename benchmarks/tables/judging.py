"""Whether a proposed map reads a made table right, or wrongly and in silence.

What is blank is answered as the stranger would. A map is right if its guesses are, too; it is wrong in silence if it
stays wrong with every guess put right: then something that it was sure of is not so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cartgrasp.errors import CartgraspError
from cartgrasp.logs import RunLog, read_log
from cartgrasp.logs.tables.proposing import propose
from cartgrasp.logs.tables.questions import put, without_marks
from cartgrasp.logs.tables.table_map import open_questions
from cartgrasp.yaml_file import dump_yaml, parse_yaml

from .strangers import Made, as_yaml

DEFAULTS = {"sign": 1, "latency": 0.0, "body": [0.0, 0.0, 0.0], "sensor": {"rpy": [0.0, 0.0, 0.0]}}
CLOSE = 1e-6


@dataclass(frozen=True)
class Judged:
    """Verdicts on one table: `questions` are places that were open, `why` what was wrong."""

    kind: str
    is_right: bool
    is_silently_wrong: bool
    guesses: int
    blanks: int
    why: str


def judge(made: Made, folder: Path) -> Judged:
    others = [p for p in made.path.parent.iterdir() if p.suffix == made.path.suffix and p != made.path]
    others.sort()
    try:
        text = propose(made.path, others).text
    except CartgraspError as error:
        return Judged(made.kind, False, False, 0, 0, f"no proposal: {error}")
    document = parse_yaml(text, "proposal")
    questions = open_questions(document, "proposal")
    guesses = sum(one.said is not None for one in questions)
    verdicts, why = [], ""
    clock = _with_true_arms(document, made.map).get(document["clock"], document["clock"])
    truth = _log(made.path, as_yaml(made.map | {"clock": clock}), folder / "truth.yaml")
    for is_told in (False, True):
        try:
            found = _log(made.path, _answered(text, made.map, is_told), folder / "proposed.yaml")
            wrong = difference(found, truth)
        except CartgraspError as error:
            wrong = str(error)
        verdicts.append(not wrong)
        why = why or wrong
    is_refused = not verdicts[1] and why.startswith(str(folder))
    return Judged(made.kind, verdicts[0], not verdicts[1] and not is_refused, guesses, len(questions) - guesses, why)


def _log(path: Path, text: str, map_path: Path) -> RunLog:
    map_path.write_text(text, encoding="utf-8")
    return read_log(path, map_path)


def _answered(text: str, truth: Mapping[str, Any], is_told: bool) -> str:
    """With blanks filled in, and with every guess put right if it `is_told`. Arms go by their order."""
    document = parse_yaml(text, "proposal")
    arms = _with_true_arms(document, truth)
    for question in open_questions(document, "proposal"):
        if question.said is None or is_told:
            where = tuple(arms.get(key, key) if i == 1 else key for i, key in enumerate(question.where))
            put(document, question.where, _true(truth, where))
    return dump_yaml(without_marks(document, "proposal"))


def _with_true_arms(document: Mapping[str, Any], truth: Mapping[str, Any]) -> dict[str, str]:
    """True names of the arms by the proposed ones: the same, else by their order."""
    theirs, ours = list(truth["arms"]), list(document.get("arms") or {})
    return {name: name if name in theirs else theirs[i] for i, name in enumerate(ours) if i < len(theirs)}


def _true(truth: Any, where: tuple[str, ...]) -> Any:
    """What stands there in the right map, or as if it didn't."""
    node = truth
    for key in where:
        if isinstance(node, list):
            node = node[int(key)]
        elif isinstance(node, Mapping) and key in node:
            node = node[key]
        elif key in DEFAULTS:
            node = DEFAULTS[key]
        else:
            return None
    return node


def difference(found: RunLog, truth: RunLog) -> str:
    """What differs first, or nothing. Headings may differ by whole turns, and arms by their names."""
    if len(found) != len(truth) or not np.allclose(found.time, truth.time, rtol=0, atol=1e-6):
        return "times"
    turns = np.round((found.pose[:, 2] - truth.pose[:, 2]) / (2 * np.pi))
    if not np.allclose(
        found.pose - np.outer(turns, [0, 0, 2 * np.pi]), truth.pose, rtol=CLOSE, atol=CLOSE, equal_nan=True
    ):
        return "poses"
    if (found.velocity is None) != (truth.velocity is None):
        return "velocities left out" if found.velocity is None else "velocities that aren't any"
    if found.velocity is not None and not np.allclose(
        found.velocity, truth.velocity, rtol=CLOSE, atol=CLOSE, equal_nan=True
    ):
        return "velocities"
    if len(found.arms) != len(truth.arms):
        return f"{len(found.arms)} arms for {len(truth.arms)}"
    theirs = [truth.arms.get(name) or list(truth.arms.values())[i] for i, name in enumerate(found.arms)]
    for one, other in zip(found.arms.values(), theirs, strict=True):
        if not np.allclose(one.wrench, other.wrench, rtol=CLOSE, atol=1e-5, equal_nan=True):
            return "wrenches"
        if not np.allclose(one.contact, other.contact, rtol=CLOSE, atol=CLOSE, equal_nan=True):
            return "contacts"
    return ""
