"""The same logs with two first guesses: whether the verdict hangs on the guess."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from .judging import Judgement
from .score import judged, said
from .soundness import counted, mass_is_close

IDENTITY = ("case", "seed", "motion", "share", "worse_sensors", "proof")
"""What of a truth says which log it is, whatever its cart file."""

Pair = tuple[Judgement, Judgement]


def compare(first: Path, second: Path, reports: str = "out") -> str:
    """Of logs that have a report in both folders. Of those kept for proof, totals alone."""
    ours, theirs = by_log(first, reports), by_log(second, reports)
    both = [(ours[key], theirs[key]) for key in ours if key in theirs]
    there = [(a, b) for a, b in both if a.report is not None and b.report is not None]
    lines = [f"{len(there)} logs with reports in both folders, of {len(ours)} and {len(theirs)}"]
    seen, kept = ([pair for pair in there if pair[0].is_proof == is_proof] for is_proof in (False, True))
    if seen or not kept:
        lines += [*agreement("", seen), *by_kind(seen), *differences(seen)]
    if kept:
        lines += agreement("for proof: ", kept)
    return "\n".join(lines)


def by_log(folder: Path, reports: str) -> dict[tuple[object, ...], Judgement]:
    found: dict[tuple[object, ...], Judgement] = {}
    for judgement in judged(folder, reports):
        key = tuple(judgement.truth.get(name) or None for name in IDENTITY)
        if key in found:
            raise ValueError(
                f"{folder} holds a log of {judgement.case!r} twice; give each first guess a folder of its own"
            )
        found[key] = judgement
    return found


def agreement(title: str, pairs: Sequence[Pair]) -> list[str]:
    def row(what: str, holds: Callable[[Judgement, Judgement], bool]) -> str:
        return counted(title + what, [holds(a, b) for a, b in pairs])

    return [
        row("the same set of names", same_names),
        row("the same set of names, and verdict", lambda a, b: same_names(a, b) and verdict(a) == verdict(b)),
        row("right in the first", lambda a, _: a.right),
        row("right in the second", lambda _, b: b.right),
        row("mass within 3 % in both, or known in neither", lambda a, b: masses_are_close(a, b)),
    ]


def by_kind(pairs: Sequence[Pair]) -> list[str]:
    """The same set of names: of each case's kind, and of each roughness."""
    groups: dict[str, list[bool]] = {}
    for a, b in pairs:
        for group in (a.kind, *(f"@{kind}" for kind in a.roughness)):
            groups.setdefault(group, []).append(same_names(a, b))
    return [counted(f"the same set of names: {group}", found) for group, found in sorted(groups.items())]


def differences(pairs: Sequence[Pair]) -> list[str]:
    """What was reported of each case where the names differ."""
    told = Counter(f"{a.case}: {said(a)} -> {said(b)}" for a, b in pairs if not same_names(a, b))
    lines = [f"{count} {what}" for what, count in sorted(told.items())]
    return ["Other names with the other guess", *lines] if lines else []


def same_names(a: Judgement, b: Judgement) -> bool:
    return set(a.names) == set(b.names)


def verdict(j: Judgement) -> str:
    return str((j.report or {}).get("verdict"))


def masses_are_close(a: Judgement, b: Judgement) -> bool:
    return mass_is_close(a) is not False and mass_is_close(b) is not False
