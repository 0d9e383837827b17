"""Judgements as a section of a markdown page: what was said of each log beside the truth, then how many hold what."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median

from .judging import CRITERIA, Judgement
from .running import COMMANDS, Outcome
from .told_values import Number

HEAD = "## Measured logs"
NONE, SAME = "-", "the same"
ENDED = next(iter(CRITERIA))


def section(judgements: Sequence[Judgement], undeclared: Sequence[str] = ()) -> str:
    """Of all that was judged; `undeclared` are files of which nothing is known."""
    bases, variants = [j for j in judgements if j.is_base], [j for j in judgements if not j.is_base]
    parts = [HEAD, NOTE, _said(bases), _counted(bases, variants)]
    if bases:
        parts.append("What does not hold on the logs as they are:\n\n" + _faults(bases))
    if variants:
        parts.append(_by_log(variants))
        parts.append("What does not hold on variants:\n\n" + _faults(variants))
    if undeclared:
        parts.append(f"Not looked at, because nothing is known of them: {', '.join(undeclared)}.")
    return "\n\n".join(part for part in parts if part) + "\n"


NOTE = (
    "`make measured`: `estimate`, `identify` and `discrepancy` on logs that nobody of this project made, from a rail "
    "with a round wrong mass and some viscous drag, and on variants of each. What is true was worked out by simpler "
    "means (`benchmarks/measured/truths.py`). Values have their standard deviations; a mass with * is said to be "
    "taught. Gaps are those before, refitted and after, and what noise makes. Seconds are a core's, start included."
)


def _said(bases: Iterable[Judgement]) -> str:
    columns = ("log", "true", "filter: mass, kg; health", "identify: mass, kg", "report", "gap, mm", "s")
    return _table(columns, [_row(j) for j in bases])


def _row(j: Judgement) -> tuple[str, ...]:
    """By the columns of `_said`."""
    errors = [j.outcome.answers[command].error for command in COMMANDS]
    said = dict(zip(COMMANDS, [SAME if e and e in errors[:i] else e for i, e in enumerate(errors)], strict=True))
    health = j.outcome.said("estimate").get("health", "")
    return (
        j.log.name,
        j.log.truth.words,
        said["estimate"] or f"{_mass(j, 'estimate')}; {health}",
        said["identify"] or _mass(j, "identify"),
        said["discrepancy"] or _reported(j),
        _gap(j),
        " + ".join(f"{j.outcome.answers[command].seconds:.0f}" for command in COMMANDS),
    )


def _reported(j: Judgement) -> str:
    told = [f"{one.name} {one.probability:.2f}" for one in j.names]
    values = [f"{name} {_number(value)}" for name, value in j.values.items() if value is not None]
    mass = [f"mass {_number(j.mass('discrepancy'))}"] if j.log.truth.mass is not None else []
    impacts = [f"{len(found)} impacts"] if (found := j.report.get("impacts")) else []
    return "; ".join([j.report["verdict"], ", ".join(told) or "no name", *mass, *values, *impacts])


def _mass(j: Judgement, command: str) -> str:
    return _number(j.mass(command)) + "*" * j.taught(command)


def _gap(j: Judgement) -> str:
    """Before, refitted, after, and what noise makes."""
    gap = j.report.get("gap")
    if not gap:
        return NONE
    cells = [gap.get(key) for key in ("before", "refitted", "after", "noise_floor")]
    before, refitted, after, floor = (NONE if cell is None else f"{1e3 * cell:.3g}" for cell in cells)
    return f"{before}, {refitted}, {after}; {floor}"


def _number(told: Number | None) -> str:
    return NONE if told is None else f"{told[0]:.4g} ± {told[1]:.2g}"


def _counted(bases: Sequence[Judgement], variants: Sequence[Judgement]) -> str:
    """How often each criterion holds, of those rows where there is something to judge; then what it took."""
    groups = [("logs as they are", bases), ("variants", variants)]
    groups = [(title, group) for title, group in groups if group]
    rows = [(words, *(_held([j.criteria[words] for j in group]) for _, group in groups)) for words in CRITERIA]
    rows.append(
        ("**right: ended, mass, names and values**", *(_held([j.is_right for j in group]) for _, group in groups))
    )
    rows += [
        (f"s of `{command}`: median, most", *(_taken(group, command) for _, group in groups)) for command in COMMANDS
    ]
    return _table(("holds", *(f"{title} ({len(group)})" for title, group in groups)), rows)


def _held(found: Iterable[bool | None]) -> str:
    judged = [one for one in found if one is not None]
    return f"{sum(judged)} of {len(judged)}" if judged else NONE


def _taken(group: Sequence[Judgement], command: str) -> str:
    """Of those that ended well."""
    answers = [j.outcome.answers[command] for j in group]
    seconds = [answer.seconds for answer in answers if not answer.error]
    return f"{median(seconds):.1f}, {max(seconds):.1f}" if seconds else NONE


def _by_log(variants: Sequence[Judgement]) -> str:
    rows = []
    for name in dict.fromkeys(j.log.name for j in variants):
        own = [j for j in variants if j.log.name == name]
        wrong = [j.outcome.variant for j in own if not j.is_right]
        rows.append((name, _held([j.is_right for j in own]), ", ".join(wrong) or NONE))
    return _table(("log", "variants right", "not right"), rows)


def _faults(judgements: Iterable[Judgement]) -> str:
    lines = [f"- {j.log.name}, {j.outcome.variant}: {'; '.join(_words(j))}" for j in judgements if j.faults]
    return "\n".join(lines) or "Nothing: all holds."


def _words(j: Judgement) -> list[str]:
    """Errors, criteria that are missed, and on a variant what was said."""
    missed = [fault for fault in j.faults if fault != ENDED or not j.outcome.errors]
    return [*j.outcome.errors, *missed, *([_reported(j)] if j.report and not j.is_base else [])]


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "/") for cell in line) + " |" for line in lines)


def progress(number: int, count: int, outcome: Outcome) -> str:
    """One line of what has come."""
    seconds = sum(answer.seconds for answer in outcome.answers.values())
    said = outcome.said("discrepancy").get("verdict") or " | ".join(outcome.errors)
    return f"[{number}/{count}] {outcome.log}, {outcome.variant}: {said} ({seconds:.0f} s)"
