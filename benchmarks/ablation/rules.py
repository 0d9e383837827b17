"""Whole rules of the discrepancy engine: functions, each with what it would say were there no such rule."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

from .constants import Constant, Group


@dataclass(frozen=True)
class Without:
    """In place of a rule: what is said without it, by its arguments."""

    said: Callable[..., Any]
    words: str

    def __call__(self, *arguments: Any) -> Any:
        return self.said(*arguments)

    def __repr__(self) -> str:
        return self.words


def says(value: Any) -> Without:
    """Always the same."""
    return Without(lambda *_: value, repr(value))


FIRST = Without(lambda first, *_: first, "its first argument")
BOTH = Without(lambda first, second, *_: (first, second), "its first two arguments")


def _rule(module: str, name: str, without: Without, why: str) -> Constant:
    return Constant(f"discrepancy.{module}", name, Group.RULES, without, why)


RULES = (
    _rule("search.search_in_band", "is_narrower", says(False), "searches in a band that tells the mass"),
    _rule("search.search", "named_instead", BOTH, "names take the place of laws that explain no more"),
    _rule("search.search", "simplified", BOTH, "a simpler effect takes the place of one that explains about as much"),
    _rule("search.search", "resized", FIRST, "effects of the file at other sizes"),
    _rule("search.search", "_closing", says(None), "adds what gains little and closes most of the gap"),
    _rule("search.search", "missing_evidence", says(""), "no name for what the logs lack"),
    _rule("search.backward_elimination", "pruned", FIRST, "drops what later additions made superfluous"),
    _rule("search.plausibility", "is_plausible", says(True), "no name for what nobody would call so"),
    _rule("findings.validation", "within_bracket", says([]), "no load within what bands leave open of the mass"),
    _rule("findings.named_effects", "doubtful_names", says([]), "no name that is more likely wrong than right"),
    _rule("findings.refusal", "is_beyond", says(True), "withdraws only what is surely farther off than noise"),
    _rule("findings.reported_mass", "reported_mass", BOTH, "the mass in the middle of what bands leave open"),
    _rule("findings.half_sine_push", "half_sine_gain", says(-inf), "pushes that rise and fall"),
)
