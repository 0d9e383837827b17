"""Reports of the workflow beside the truth: DIR/logs/NAME/out/report.json and DIR/truth/NAME.json.

`out` may be another folder, of another method. A report that tells no probability or standard deviation is not judged
by it, one that tells no gap by that of its names. DIR/logs/NAME/refit.json tells what the true structure would have
reached. Logs that are rough on purpose have tables of their own; those that are kept for proof are only counted.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from .arms import by_arm
from .calibration import coverage, reliability
from .judging import CLOSES, Estimate, Judgement, bare
from .locality import is_local, localisation
from .recorded import read_course
from .soundness import by_roughness, counted, soundness, totals, waits

NONE = "(none)"
MISSING = "(no report)"
UNEXPLAINED = "(unexplained)"
POWER = 0.9
PLAIN = 0.0, 5.0, 8.0, 12.0, np.inf
"""Deviations by which who knows the motion, the noise and the form sees an effect."""
CLOSE = 1.1
"""Times the gap of a refit of the true structure."""


def score(folder: Path, reports: str = "out") -> str:
    everyone = judged(folder, reports)
    kept = [j for j in everyone if j.is_proof]
    plain, rough = ([j for j in everyone if not j.is_proof and bool(j.roughness) == is_rough] for is_rough in (0, 1))
    parts = [tables(plain)] if plain or not everyone else []
    parts += ["Rough on purpose", tables(rough)] if rough else []
    return "\n\n".join(part for part in (*parts, totals(kept)) if part)


def tables(everyone: Sequence[Judgement]) -> str:
    known = [j for j in everyone if j.report is not None]
    everyone, there = ([j for j in group if j.share == 1.0] for group in (everyone, known))
    named = [e for j in there for e in j.estimates]
    alone, beside = refitted(there, ("nothing",)), refitted(there, ("single", "pair"))
    parts = [
        f"{len(there)} reports of {len(everyone)} logs; {len(everyone) - len(there)} missing",
        rates(there),
        localisation(there),
        soundness(there),
        by_arm(there),
        by_roughness(there),
        by_strength(there),
        gaps(there),
        beside_truth(there),
        coverage({"parameters of named effects": named, "cart, nothing beside": alone, "cart, effects beside": beside}),
        reliability(there),
        waits(there),
        estimates("Parameters of named effects", named),
        estimates("Refitted cart, nothing beside", alone),
        estimates("Refitted cart, effects beside", beside),
        floors(known),
        confusion(everyone),
        strays(there),
    ]
    return "\n\n".join(part for part in parts if part)


def judged(folder: Path, reports: str = "out") -> list[Judgement]:
    return [read(folder, path, reports) for path in sorted((folder / "truth").glob("*.json"))]


def read(folder: Path, path: Path, reports: str) -> Judgement:
    log, truth = folder / "logs" / path.stem, contents(path)
    report, taken = contents(log / reports / "report.json"), contents(log / reports / "seconds.json") or {}
    if report and "gap" not in report:
        report["gap"] = gap_of_names(log, reports, report)
    known = contents(log / "refit.json") or {}
    course = read_course(log / "run.csv") if report and is_local(truth) else None
    return Judgement(truth, report, taken.get("seconds"), known.get("gap"), course)


def gap_of_names(log: Path, reports: str, report: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The workflow's gap, but for what is left with the names of a method that tells none (`true_structures --reports`
    refits those that the workflow doesn't tell, too)."""
    ours, refit = contents(log / "out" / "report.json"), contents(log / reports / "refit.json")
    if not (ours and ours.get("gap")):
        return None
    gap = {key: ours["gap"][key] for key in ("refitted", "after", "noise_floor")}
    if not report["effects"]:
        return gap | {"after": gap["refitted"]}
    if names(report) == names(ours):
        return gap
    return gap | {"after": refit["gap"]} if refit else None


def names(report: Mapping[str, Any]) -> set[str]:
    return {bare(effect["name"]) for effect in report["effects"]}


def contents(path: Path) -> Any:
    """None where there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def refitted(judgements: Iterable[Judgement], kinds: Sequence[str]) -> list[Estimate]:
    return [estimate for j in judgements if j.kind in kinds for estimate in j.mismatches]


def rates(judgements: Sequence[Judgement]) -> str:
    def rate(what: str, group: Sequence[Judgement], holds: Callable[[Judgement], object]) -> str:
        return counted(what, [bool(holds(j)) for j in group])

    kinds = ("single", "pair", "nothing", "outside")
    single, pair, nothing, outside = ([j for j in judgements if j.kind == kind] for kind in kinds)
    wrong = [j for j in single if j.names and not j.exact]
    sized = [len(frozenset().union(*j.sets)) for j in single if j.sets]
    periods = [right for j in outside if (right := j.period_right) is not None]
    return "\n".join(
        [
            rate("single effect: its name and no other", single, lambda j: j.exact),
            rate("single effect: named first", single, lambda j: j.names[:1] == tuple(j.true_names)),
            rate("single effect: in the reported set", single, lambda j: j.within),
            rate("single effect: wrong name, but the truth in its set", wrong, lambda j: j.within),
            f"{'single effect: mean size of the reported set':<52} {mean(sized)}",
            rate("pair: both named and no other", pair, lambda j: j.exact),
            rate("pair: both named", pair, lambda j: j.true_names <= set(j.names)),
            rate("pair: both in the reported sets", pair, lambda j: j.within),
            rate("pair: one named at least", pair, lambda j: j.true_names & set(j.names)),
            rate("nothing: false alarms", nothing, lambda j: not j.called_nothing),
            rate("law: of the right variable", outside, lambda j: j.variable_right),
            rate("law: four fifths of the gap closed", [j for j in outside if j.closed is not None], _closes),
            rate("law: a wrong name", outside, lambda j: bool(j.wrong_names)),
            rate(
                "law: the name beside it", [j for j in outside if j.true_names], lambda j: j.true_names <= set(j.names)
            ),
            rate("law: all of it right", outside, lambda j: j.law_right),
            counted("law: period right, where there is one", periods),
            counted("names told that are not hidden", [name in j.wrong_names for j in judgements for name in j.names]),
        ]
    )


def _closes(judgement: Judgement) -> bool:
    return judgement.closed is not None and judgement.closed >= CLOSES


def by_strength(judgements: Sequence[Judgement]) -> str:
    """How often single effects are in the reported set, by how plainly the wrenches show them."""
    known = [(j.z, j.within) for j in judgements if j.kind == "single" and j.z is not None]
    lines = [f"{'Single effect in the reported set, by z':<52}"]
    for low, high in pairwise(PLAIN):
        own = [within for z, within in known if low <= z < high]
        title = f"{low:g} to {high:g}" if high < np.inf else f"{low:g} and more"
        lines.append(counted(title, own))
    return "\n".join(lines) if known else ""


def gaps(judgements: Sequence[Judgement]) -> str:
    """Of all, and of those in which what is hidden makes most of the gap."""
    lines = [f"{'Held-out gap (median; 90 %)':<44} {'n':>3}   after / refitted    after / noise floor"]
    for kind in ("single", "pair", "outside", "nothing"):
        group = [j for j in judgements if j.kind == kind and j.gap is not None]
        for title, own in ((kind, group), (f"{kind}, most of it more than noise", [j for j in group if j.stands_out])):
            if own and (own is group or kind in ("single", "pair")):
                found = np.array([j.gap for j in own])
                middle, high = np.median(found, axis=0), np.quantile(found, 0.9, axis=0)
                cells = (f"{m:.3f}; {h:.3f}" for m, h in zip(middle, high, strict=True))
                lines.append(f"{title:<44} {len(own):>3}   " + "        ".join(cells))
    closed = [j.closed for j in judgements if j.closed is not None]
    if closed:
        cells = f"{np.median(closed):6.2f}; of four fifths or more {sum(one >= CLOSES for one in closed)}"
        lines.append(f"{'squared gap above noise closed, of those (median)':<44} {len(closed):>3} {cells}")
    return "\n".join(lines) if len(lines) > 1 else ""


def beside_truth(judgements: Sequence[Judgement]) -> str:
    """The held-out gap, of a refit of the true structure where there is one."""
    lines = [f"{'Held-out gap, after / true structure refitted':<52} {'n':>3}  median    90 %  within {CLOSE:g}"]
    for kind in ("single", "pair", "nothing"):
        found = np.array([j.beside_truth for j in judgements if j.kind == kind and j.beside_truth is not None])
        if len(found):
            cells = f"{len(found):>3}{np.median(found):8.3f}{np.quantile(found, 0.9):8.3f}"
            lines.append(f"{kind:<52} {cells}  {counted('', list(found <= CLOSE)).lstrip()}")
    return "\n".join(lines) if len(lines) > 1 else ""


def estimates(title: str, found: Iterable[Estimate]) -> str:
    """Errors in the parameter's unit, and z. ~: what is meant differs somewhat, so z says little."""
    groups: dict[str, list[Estimate]] = defaultdict(list)
    for estimate in found:
        groups[("~ " if estimate.roughly else "  ") + estimate.name].append(estimate)
    if not groups:
        return ""
    lines = [f"{title:<44} {'n':>3} {'median error':>13} {'median |error|':>15} {'90 %':>9} {'rms z':>7} {'|z|>3':>6}"]
    for name, group in sorted(groups.items(), key=lambda item: item[0][2:]):
        errors = np.array([e.error for e in group])
        z = np.array([e.z for e in group])
        z = z[np.isfinite(z)]
        rms = f"{np.sqrt(np.mean(z**2)):7.1f}" if len(z) else f"{'-':>7}"
        sizes = f"{np.median(errors):13.3g} {np.median(abs(errors)):15.3g} {np.quantile(abs(errors), 0.9):9.2g}"
        lines.append(f"{name:<44} {len(group):>3} {sizes} {rms} {int((abs(z) > 3).sum()):>6}")
    return "\n".join(lines)


def floors(judgements: Sequence[Judgement]) -> str:
    """How often an effect is named, by the share of its usual size; the smallest share from which on it is named in
    `POWER` of the logs."""
    groups: dict[str, dict[float, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for j in judgements:
        if j.kind == "single":
            groups[j.case][j.share].append(j.true_names <= set(j.names))
    tried = sorted({share for group in groups.values() for share in group}, reverse=True)
    if len(tried) < 2:
        return ""
    lines = [f"{'Named at shares of the usual size':<38} " + "".join(f"{share:>9g}" for share in tried) + "    floor"]
    for case, group in sorted(groups.items()):
        cells = "".join(f"{sum(group[s])} of {len(group[s])}".rjust(9) for s in tried)
        seen = [np.mean(group[s] or [False]) >= POWER for s in tried]
        enough = sum(takewhile(bool, seen))
        lines.append(f"{case:<38} {cells}    {f'{tried[enough - 1]:g}' if enough else '-'}")
    return "\n".join(lines)


def confusion(judgements: Sequence[Judgement]) -> str:
    """What was reported of each case, names in order of addition, most frequent first."""
    told: dict[str, Counter[str]] = defaultdict(Counter)
    for j in judgements:
        told[j.case][said(j)] += 1
    lines = ["Case: what was reported, how often"]
    for case, counts in told.items():
        lines.append(f"{case:<38} " + "; ".join(f"{n} {what}" for what, n in counts.most_common()))
    return "\n".join([lines[0], *sorted(lines[1:])])


def strays(judgements: Sequence[Judgement]) -> str:
    """Names that were given where they are not true."""
    wrong = Counter(name for j in judgements for name in j.wrong_names)
    return "Names given in vain: " + (", ".join(f"{name} {n}" for name, n in wrong.most_common()) or "none")


def said(j: Judgement) -> str:
    if j.report is None:
        return MISSING
    if not j.names:
        return NONE if j.called_nothing else UNEXPLAINED
    return "+".join(j.names) + (" and more" if j.partly else "")


def mean(values: Sequence[int]) -> str:
    return f"{np.mean(values):.2f}" if values else "-"
