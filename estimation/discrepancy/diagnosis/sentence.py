"""What a diagnosis says, in one sentence that a person can act on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.effects import Effect

from ..findings.named_effects import grouped, words_of
from ..findings.verdicts import verdict
from ..search.gains import CONFUSABLE_NATS

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

REFIT_IMPROVEMENT_RATIO = 2.0
"""Factor by which a refit shrinks the error of rollouts, from which on it is told that it does."""


def sentence(found: Diagnosis) -> str:
    """The verdict, and what makes all of it worthless."""
    wrong = "; ".join(one.words for check in found.checks for one in check.suspicions if one.is_refused)
    return f"{_of_model(found)}{_beside(found)}" + (
        f" But nothing of this holds if sensors are wrong: {wrong}." if wrong else ""
    )


def _of_model(found: Diagnosis) -> str:
    gap, floor = found.gap, f"noise alone makes {1e3 * found.gap.noise_floor:.1f} mm"
    refitted = f"{1e3 * gap.refitted:.1f} mm after 1 s"
    if not found.is_moved:
        return f"Nothing moves, so nothing is learned and the file's values stay; {floor}."
    if found.verdict == "no_discrepancy":
        if not gap.is_beyond_noise and gap.before > REFIT_IMPROVEMENT_RATIO * max(gap.refitted, gap.noise_floor):
            refitted += f" ({1e3 * gap.before:.1f} mm with the file's)"
            return f"With the parameters refitted, simulation and measurement agree: {refitted}, and {floor}."
        if gap.is_beyond_noise:
            open_to = f"what so little motion leaves open of the cart makes {1e3 * (gap.left_open or 0.0):.1f} mm"
            return f"Nothing speaks against the model: {refitted}; {floor}, and {open_to}."
        return f"Simulation and measurement agree: {refitted}, and {floor}."
    if found.verdict == "unexplained":
        return f"They disagree, and nothing surely explains it: {refitted}, while {floor}.{_likeliest(found)}"
    several = len(found.effects) > 1
    names, them = "; ".join(map(words_of, grouped(found.effects))), "them" if several else "it"
    part = "" if found.verdict == "explained" else f", which {'explain' if several else 'explains'} a part"
    shrinks = f"the 1 s rollout error goes from {1e3 * gap.refitted:.1f} mm to {1e3 * gap.after:.1f} mm"
    share = (gap.refitted**2 - gap.after**2) / max(gap.refitted**2 - gap.noise_floor**2, 1e-12)
    closed = f"which closes {100 * min(max(share, 0.0), 1.0):.0f} % of the gap"
    return f"The model lacks {names}{part}: with {them} {shrinks}, {closed}; {floor}."


def _likeliest(found: Diagnosis) -> str:
    """What came nearest to being named."""
    left = [one for step in found.steps[-1:] for one in step.attempts if isinstance(one.candidate, Effect)]
    best = max(left, key=lambda one: one.gain, default=None)
    if best is None or best.gain < CONFUSABLE_NATS:
        return ""
    return f" Nearest comes {best.candidate.name} ({best.gain:.1f} nats): {verdict(found.steps[-1], best)}."


def _beside(found: Diagnosis) -> str:
    told = "".join(f" What is left may follow {law.words}." for law in found.may_follow)
    if found.is_refused:
        told += " A refit predicts unseen stretches no better than the file's values, which stay."
    if not found.nominal.is_pushed:
        mass = found.nominal_cart.inertia.mass
        told += f" Nobody pushes: the mass ({mass:g} kg) can't be learned and is as given; forces are told for it."
    return told
