"""Where one arm of two has the effect: whether it is named, or said to tie with the other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from .judging import Judgement, bare
from .soundness import counted

NAMED, TIE, BOTH, OTHER, MISSED = "named", "told as a tie", "both named", "the other alone", "effect not named"


def by_arm(judgements: Sequence[Judgement]) -> str:
    """How often the arm is named rightly, or told as a tie, of all that have one."""
    told = Counter(said for j in judgements if j.report is not None for said in told_arms(j))
    if not told:
        return ""
    right = [said in (NAMED, TIE) for said in told.elements()]
    lines = [f"{f'the arm: {one}':<52} {told[one]:>3}" for one in (NAMED, TIE, BOTH, OTHER, MISSED)]
    return "\n".join([counted("The arm of two: rightly named, or a tie", right), *lines])


def told_arms(j: Judgement) -> list[str]:
    """For each true effect of one arm of two, what was said of the arm."""
    if len(j.arms) < 2:
        return []
    return [told_arm(true, j.report or {}) for true in j.truth["effects"] if true["arm"]]


def told_arm(true: Mapping[str, Any], report: Mapping[str, Any]) -> str:
    """A tie is told by the effect's own name among those that it may be confused with: alone, or with the arm."""
    entries = [e for e in report.get("effects", []) if bare(e["name"]) == true["name"]]
    arms = {arm_of(e) for e in entries}
    if not entries:
        return MISSED
    if arms == {true["arm"]}:
        return NAMED
    own = (true["name"], f"{true['name']}.{true['arm']}", f"{true['name']} {true['arm']}")
    if any(name in own for e in entries for name in e.get("confusable_with", [])):
        return TIE
    return BOTH if true["arm"] in arms else OTHER


def arm_of(effect: Mapping[str, Any]) -> str:
    """Of `force_bias` with the label `left`, or of `force_bias.left`."""
    return str(effect.get("label") or effect["name"].partition(".")[2])
