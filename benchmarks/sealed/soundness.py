"""What no log may do to the workflow, however rough: masses far off, refits that are worse than the file's values,
wrong names that are said to be likely, long waits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from .calibration import INTERVAL
from .judging import Judgement, bare

CLOSE_MASS = 0.03
"""Of the mass."""
NOISE = 0.05
"""Of a gap. Of n rollouts a root mean square is sure to 1 / sqrt(2 n), a twentieth of 200; two of the same rollouts err
together, so chance moves their ratio by less."""
LIKELY = 0.5


def mass_is_close(j: Judgement) -> bool | None:
    """None where no mass is told, or nobody can know it."""
    found = [e for e in j.mismatches if e.name == "mass"]
    return abs(found[0].error) < CLOSE_MASS * found[0].truth if found else None


def refit_is_worse(j: Judgement) -> bool | None:
    """Than the cart file's values, beyond noise, on stretches that no fit saw."""
    gap = (j.report or {}).get("gap")
    if not gap or "before" not in gap:
        return None
    return bool(gap["refitted"] > max(gap["before"] * (1 + NOISE), gap["noise_floor"]))


def likely_and_wrong(j: Judgement) -> tuple[str, ...] | None:
    """Names that are not true and have a probability above one half; None where there is no report."""
    if j.report is None:
        return None
    effects = j.report.get("effects", [])
    likely = {bare(e["name"]) for e in effects if e.get("probability", 0.0) > LIKELY}
    return tuple(name for name in j.wrong_names if name in likely)


def effect_intervals(judgements: Sequence[Judgement]) -> list[bool]:
    """Whether each interval of 95 % of a named effect's parameter holds the truth."""
    z = np.array([e.z for j in judgements for e in j.estimates if not e.roughly])
    return [bool(abs(one) < INTERVAL) for one in z[np.isfinite(z)]]


def shares(judgements: Sequence[Judgement]) -> dict[str, list[bool]]:
    """Of what can be judged: which did."""
    checks: dict[str, Callable[[Judgement], bool | None]] = {
        f"mass within {CLOSE_MASS:.0%}": mass_is_close,
        "refit worse than before": refit_is_worse,
        f"a wrong name above {LIKELY:g}": lambda j: None if (wrong := likely_and_wrong(j)) is None else bool(wrong),
    }
    return {title: [v for j in judgements if (v := check(j)) is not None] for title, check in checks.items()}


def soundness(judgements: Sequence[Judgement]) -> str:
    """How many of the logs, and which names were likely and wrong."""
    if not any(j.report for j in judgements):
        return ""
    lines = ["Of all logs", *(counted(title, found) for title, found in shares(judgements).items())]
    wrong = Counter(name for j in judgements for name in likely_and_wrong(j) or ())
    lines += [f"{'wrong names above one half':<52} {', '.join(f'{name} {n}' for name, n in wrong.most_common())}"]
    return "\n".join(lines if wrong else lines[:-1])


def waits(judgements: Sequence[Judgement]) -> str:
    """Seconds of all logs, and of each kind."""
    lines = [f"{'Seconds for a log':<52} {'n':>3}  median    90 %    most"]
    for kind in ("all", "nothing", "single", "pair", "outside"):
        taken = [j.seconds for j in judgements if kind in ("all", j.kind) and j.seconds is not None]
        if taken:
            told = "".join(f"{one:>8.1f}" for one in (np.median(taken), np.quantile(taken, 0.9), max(taken)))
            lines.append(f"{kind:<52} {len(taken):>3}{told}")
    return "\n".join(lines) if len(lines) > 1 else ""


def by_roughness(judgements: Sequence[Judgement]) -> str:
    """A row for each kind of roughness, in which a log that has several is counted each time."""
    kinds = sorted({kind for j in judgements for kind in j.roughness})
    if not kinds:
        return ""
    titles = ("right", "in the set", *shares(()), "seconds: median", "most")
    lines = [f"{'By what is rough':<20} {'n':>3}  " + "  ".join(f"{title:>8}" for title in titles)]
    for kind in kinds:
        own = [j for j in judgements if kind in j.roughness]
        cells = [cell([j.right for j in own]), cell([j.within for j in own if j.true_names])]
        cells += [cell(found) for found in shares(own).values()]
        taken = [j.seconds for j in own if j.seconds is not None]
        cells += [f"{np.median(taken):.1f}", f"{max(taken):.1f}"] if taken else ["-", "-"]
        aligned = (f"{one:>{max(8, len(title))}}" for one, title in zip(cells, titles, strict=True))
        lines.append(f"{kind:<20} {len(own):>3}  " + "  ".join(aligned))
    return "\n".join(lines)


def totals(judgements: Sequence[Judgement]) -> str:
    """Of logs that are kept for proof: how many, and nothing of which."""
    if not judgements:
        return ""
    there = [j for j in judgements if j.report is not None]
    effects = [j for j in there if j.kind in ("single", "pair")]
    lines = [
        f"For proof: {len(there)} reports of {len(judgements)} logs; totals alone",
        counted("right: the names, or nothing, or without a name", [j.right for j in there]),
        counted("effects in the reported sets", [j.within for j in effects]),
        *(counted(title, found) for title, found in shares(there).items()),
        counted("95 % intervals of named effects that hold", effect_intervals(there)),
    ]
    taken = [j.seconds for j in there if j.seconds is not None]
    if taken:
        lines.append(f"{'seconds for a log':<52} median {np.median(taken):.1f}, most {max(taken):.1f}")
    return "\n".join(lines)


def counted(title: str, found: Sequence[bool]) -> str:
    share = f"{100 * sum(found) / len(found):5.1f} %" if found else ""
    return f"{title:<52} {sum(found):>3} of {len(found):<3} {share}".rstrip()


def cell(found: Sequence[bool]) -> str:
    return f"{sum(found)} of {len(found)}"
