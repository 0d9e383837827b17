"""What came of an ablation, as markdown: how many logs are right with each constant at each value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from types import FunctionType
from typing import Any

from .cases import KINDS, Case, Mark
from .constants import OFF, Constant
from .running import Answer, Answers, Job

NOTE = (
    "`python -m benchmarks.ablation`. A log is right by the exam of its kind: sealed ones where the names that are "
    "hidden and no others are told (nothing, or something left unexplained, where that is true), measured ones where "
    "names and values are true. `changed` counts logs of which names, probabilities or verdict differ, `(all)` those "
    "of which any digit of the report does, scores of all candidates included. The mass is that of sealed logs. Group "
    "a decides; b is assumed; r is a rule."
)
MOST_LOST = 0.01
"""Of logs: what a constant moved by 30 % may cost."""


@dataclass(frozen=True)
class Row:
    """What came with one constant (None: all as they are) at one value."""

    constant: Constant | None
    move: str
    marks: tuple[tuple[str, Mark], ...]
    changed: int
    touched: int

    @property
    def right(self) -> int:
        return sum(mark.is_right for _, mark in self.marks)

    @property
    def wrong(self) -> int:
        return sum(mark.wrong for _, mark in self.marks)

    @property
    def mass_error(self) -> float | None:
        errors = [mark.mass_error for _, mark in self.marks if mark.mass_error is not None]
        return median(errors) if errors else None

    def of(self, kind: str) -> str:
        own = [mark.is_right for each, mark in self.marks if each == kind]
        return f"{sum(own)}/{len(own)}" if own else "-"


def rows(cases: Sequence[Case], constants: Sequence[Constant], moves: Sequence[str], answers: Answers) -> list[Row]:
    """As they are first; values that a constant can't have are left out."""
    found = [_row(cases, None, "", answers)]
    for constant in constants:
        found += [_row(cases, constant, move, answers) for move in moves if constant.moved(move) is not None]
    return found


def _row(cases: Sequence[Case], constant: Constant | None, move: str, answers: Answers) -> Row:
    own = [(answers[Job(c).place], answers[Job(c, constant, move).place], c) for c in cases]
    marks = tuple((case.kind, case.mark(there.report, there.failure)) for _, there, case in own)
    changed = sum(_said(base) != _said(there) for base, there, _ in own)
    touched = sum((base.digest, base.failure) != (there.digest, there.failure) for base, there, _ in own)
    return Row(constant, move, marks, changed, touched)


def _said(answer: Answer) -> Any:
    if answer.report is None:
        return answer.failure
    effects = [(e["name"], e.get("label"), f"{e['probability']:.2f}") for e in answer.report["effects"]]
    return answer.report["verdict"], effects, answer.report["unexplained"].get("depends_on")


def section(found: Sequence[Row]) -> str:
    """The table, with what follows from it."""
    base, *others = found
    columns = (
        "constant",
        "group",
        "value",
        "decides",
        "moved",
        "to",
        "right",
        *KINDS,
        "false names",
        "mass",
        "changed",
    )
    cells = [("as they are", "", "", "", "", "", *_counts(base), "")]
    before: Constant | None = None
    for row in others:
        own = row.constant
        assert own is not None
        head = ("", "", "", "") if own is before else (f"`{own.full_name}`", own.group.value, short(own.value), own.why)
        moved = row.move if row.move == OFF else f"×{row.move}"
        cells.append(
            (*head, moved, short(own.moved(row.move)), *_counts(row, base), f"{row.changed} ({row.touched} all)")
        )
        before = own
    return "\n\n".join(["## What each constant buys", NOTE, _markdown(columns, cells), *_summary(base, others)]) + "\n"


def _counts(row: Row, base: Row | None = None) -> tuple[str, ...]:
    more = "" if base is None or row.right == base.right else f" ({row.right - base.right:+d})"
    mass = "-" if row.mass_error is None else f"{100 * row.mass_error:.2f} %"
    return f"{row.right} of {len(row.marks)}{more}", *(row.of(kind) for kind in KINDS), str(row.wrong), mass


def _summary(base: Row, others: Sequence[Row]) -> list[str]:
    """What switching off changes nothing, and what costs more than it may when it is moved."""
    count = max(len(base.marks), 1)
    off = [row for row in others if row.move == OFF]
    idle = [row for row in off if not row.touched]
    costly = [row for row in others if row.move != OFF and base.right - row.right > MOST_LOST * count]
    told = [f"Switched off without any change: {_named(idle)}." if off else ""]
    if off:
        told.append(f"Switched off, fewer logs are right: {_named([r for r in off if r.right < base.right])}.")
    told.append(f"Moved, they cost more than {100 * MOST_LOST:g} % of the logs: {_named(costly)}.")
    return [one for one in told if one]


def _named(found: Sequence[Row]) -> str:
    return ", ".join(dict.fromkeys(f"`{row.constant.full_name}`" for row in found if row.constant)) or "none"


def affected(constants: Sequence[Constant], moves: Sequence[str], watched: Answers) -> str:
    """On how many logs each value might change anything; those that can't be followed are told."""
    followed = [answer for answer in watched.values() if answer.digest]
    cells = []
    for one in constants:
        counts = [sum((one.full_name, move) in answer.noticed for answer in followed) for move in moves]
        told = [str(n) if one.moved(move) is not None else "-" for n, move in zip(counts, moves, strict=True)]
        cells.append((f"`{one.full_name}`", one.group.value, short(one.value), one.why, *told))
    note = f"Of {len(watched)} logs, on how many a value of a constant might change any digit of the report."
    lost = [f"{case}, {answer.failure}" for (_, _, case), answer in watched.items() if not answer.digest]
    told = [f"Not followed: {'; '.join(lost)}."] if lost else []
    columns = ("constant", "group", "value", "decides", *(move if move == OFF else f"×{move}" for move in moves))
    return "\n\n".join([note, _markdown(columns, cells), *told]) + "\n"


def listed(constants: Sequence[Constant]) -> str:
    """Of constants alone, as they are now."""
    columns = ("constant", "group", "value", "off", "what for")
    cells = [
        (f"`{c.full_name}`", c.group.value, short(c.value), "-" if c.off is None else short(c.off), c.why)
        for c in constants
    ]
    return _markdown(columns, cells) + "\n"


def short(value: Any) -> str:
    """Of few digits; of a long table or text, its kind."""
    if isinstance(value, FunctionType):
        return "a rule"
    text = f"{float(value):.4g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 40 and "\n" not in text else f"({type(value).__name__})"


def _markdown(columns: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *cells]
    return "\n".join("| " + " | ".join(cell.replace("|", "/") for cell in line) + " |" for line in lines)
