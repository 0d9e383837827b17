"""What was said of one measured log, held against what is known of it, criterion by criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .at_a_bound import at_a_bound
from .logs import MeasuredLog
from .running import Outcome
from .told_values import VALUES, Name, Number, mass, names, number
from .truths import Interval

DEVIATIONS = 2.0
"""Within which an interval is said to meet another: 95 %."""
SURE = 0.5
"""A wrong name is no matter below."""


@dataclass(frozen=True)
class Judgement:
    """One row. `base` is what was said of the same log as it is; None for that itself, and where it was not run."""

    log: MeasuredLog
    outcome: Outcome
    base: Outcome | None = None

    @cached_property
    def criteria(self) -> dict[str, bool | None]:
        """By the words of CRITERIA: whether it holds; None where there is nothing to judge."""
        return {words: judge(self) for words, judge in CRITERIA.items()}

    @property
    def faults(self) -> tuple[str, ...]:
        return tuple(words for words, holds in self.criteria.items() if holds is False)

    @property
    def is_right(self) -> bool:
        """Names and values both, as the report tells them."""
        return not any(judge(self) is False for judge in RIGHT)

    @property
    def is_base(self) -> bool:
        return self.base is None

    @property
    def report(self) -> Mapping[str, Any]:
        return self.outcome.said("discrepancy")

    @property
    def names(self) -> tuple[Name, ...]:
        return names(self.report)

    @property
    def values(self) -> dict[str, Number | None]:
        """What the truth has an interval of, as told."""
        return {name: VALUES[name](self.report) for name in self.log.truth.values}

    def mass(self, command: str) -> Number | None:
        """kg."""
        if command == "discrepancy":
            return mass(self.report)
        return number(self.outcome.said(command).get("parameters", {}).get("mass"))

    def taught(self, command: str, name: str = "mass") -> bool:
        """Whether `estimate` or `identify` says that the motion taught it."""
        told = self.outcome.said(command).get("parameters", {}).get(name)
        return bool(told and told["identifiable"])

    @property
    def is_healthy(self) -> bool:
        return self.outcome.said("estimate").get("health") == "ok"


def ended(j: Judgement) -> bool:
    return not j.outcome.errors


def filter_meets(j: Judgement) -> bool | None:
    """It may say that it is not well, and that nothing was taught."""
    is_excused = j.mass("estimate") is not None and not j.is_healthy and not j.taught("estimate")
    meets = _meets(j, "estimate")
    return True if meets is False and is_excused else meets


def identify_meets(j: Judgement) -> bool | None:
    return _meets(j, "identify")


def report_holds(j: Judgement) -> bool | None:
    """The value itself, on the log as it is; on a variant its interval."""
    true, told = j.log.truth.mass, j.mass("discrepancy")
    if true is None:
        return None
    return told is not None and (true.holds(told[0]) if j.is_base else _near(true, told))


def told_what_must_be(j: Judgement) -> bool | None:
    """Each as itself or as what a name can't be told apart from, by as many names; in order where there is one."""
    if not j.log.truth.must:
        return None
    told = [one.either for one in j.names]
    places = [i for must in j.log.truth.must for i, either in enumerate(told) if either & must]
    first = [next((i for i, either in enumerate(told) if either & must), -1) for must in j.log.truth.must]
    if -1 in first or len(set(places)) < len(j.log.truth.must):
        return False
    return not j.log.truth.in_order or first == sorted(first)


def no_wrong_name(j: Judgement) -> bool | None:
    if not j.report:
        return None
    return not any(one.probability > SURE and not one.either & j.log.truth.allowed for one in j.names)


def values_hold(j: Judgement) -> bool | None:
    """Those that are told; as with the mass."""
    told = [(j.log.truth.values[name], value) for name, value in j.values.items() if value is not None]
    if not told:
        return None
    return all(true.holds(*value) if j.is_base else _near(true, value) for true, value in told)


def nothing_taught_at_a_bound(j: Judgement) -> bool | None:
    return not at_a_bound(j.outcome, j.log.cart) if any(a.said for a in j.outcome.answers.values()) else None


def taught_in_health(j: Judgement) -> bool | None:
    """An inconsistent filter teaches nothing; without a force, nobody a mass."""
    told = j.outcome.said("estimate").get("parameters", {})
    if j.log.truth.mass is None and (told or j.outcome.said("identify")):
        return not (j.taught("estimate") or j.taught("identify"))
    if not told:
        return None
    inconsistent = j.outcome.said("estimate").get("health") == "inconsistent"
    return not (inconsistent and any(p["identifiable"] for p in told.values()))


def refit_is_no_worse(j: Judgement) -> bool | None:
    """Than the nominal model, beyond what noise adds; a floor above the nominal gap is of a model that is wrong."""
    gap = j.report.get("gap")
    if not gap or gap["before"] is None or gap["refitted"] is None:
        return None
    before, floor = gap["before"], gap.get("noise_floor") or 0.0
    return bool(gap["refitted"] <= math.hypot(before, min(before, floor)))


def filter_and_identify_agree(j: Judgement) -> bool | None:
    """Their masses, where both say that they were taught."""
    online, whole = j.mass("estimate"), j.mass("identify")
    if online is None or whole is None or not (j.taught("estimate") and j.taught("identify")):
        return None
    return abs(online[0] - whole[0]) <= DEVIATIONS * math.hypot(online[1], whole[1])


def same_names(j: Judgement) -> bool | None:
    """As on the log as it is: each name there is here, or what it can't be told apart from, and the other way round."""
    if j.base is None:
        return None
    if not j.report:
        return False
    here, there = j.names, names(j.base.said("discrepancy"))
    return _among(here, there) and _among(there, here)


def _among(some: tuple[Name, ...], others: tuple[Name, ...]) -> bool:
    return all(any(one.name in other.either or other.name in one.either for other in others) for one in some)


def _meets(j: Judgement, command: str) -> bool | None:
    true, told = j.log.truth.mass, j.mass(command)
    if true is None:
        return None
    return told is not None and _near(true, told)


def _near(true: Interval, told: Number) -> bool:
    """Whether intervals meet; one that reaches nought says nothing, and its value alone counts."""
    value, std = told
    return true.holds(value, std, DEVIATIONS if DEVIATIONS * std < abs(value) else 0.0)


CRITERIA: dict[str, Callable[[Judgement], bool | None]] = {
    "all three commands end well": ended,
    "the filter's mass meets the truth, or is not taught in poor health": filter_meets,
    "the mass of identify meets the truth": identify_meets,
    "the report's mass is true": report_holds,
    "names that must be told are told": told_what_must_be,
    "no wrong name above one half": no_wrong_name,
    "values are true": values_hold,
    "nothing at a bound is taught": nothing_taught_at_a_bound,
    "nothing is taught by an inconsistent filter, nor a mass without a force": taught_in_health,
    "the refit is no worse on unseen stretches": refit_is_no_worse,
    "filter and identify agree": filter_and_identify_agree,
    "names as of the log as it is": same_names,
}
RIGHT = (ended, report_holds, told_what_must_be, no_wrong_name, values_hold)
