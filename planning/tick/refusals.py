"""Plans without wrenches that need no program to be solved, and what is told of contacts when none would do."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from ..allocation.infeasibility import Certificate
from ..contacts.contact_bounds import Candidates
from ..contacts.contact_choice import Choice
from ..plan import TIMEOUT, ChoiceProof, Figures, Plan
from ..quadratic_program import INFEASIBLE, NUMERICAL


def refusal(status: str, message: str, start: float) -> Plan:
    return Plan(status, solve_time=time.perf_counter() - start, message=message)


def undecided(choice: Choice, start: float) -> Plan:
    """A search found no feasible contacts, and no proof that there are none; what it has proven is `choice`."""
    if choice.complete:
        status, message = NUMERICAL, "at some contacts no solver gave a verified answer"
    else:
        message = f"no feasible contacts among the {choice.solved} programs solved until the search's limit"
        status, message = TIMEOUT, f"{message}; raise search_limit, or offer fewer contacts"
    return replace(refusal(status, message, start), tell=partial(Figures, choice=choice.proof))


def unproven(plan: Plan) -> Plan:
    """At contacts chosen by limits that don't hold there: others may be better."""
    return Plan.of(vars(plan) | {"tell": lambda: plan.figures._replace(choice=ChoiceProof(-math.inf, math.inf, 1))})


def at_nearest(plan: Plan, candidates: Candidates) -> Plan:
    """The plan at the nearest of all choices of contacts, which says so."""
    if plan.certificate is None:
        return plan
    choices = "all" if candidates.has_segments else f"{candidates.count}"
    words = f"{plan.certificate.words} (at the nearest of {choices} choices of contacts; none is feasible)"
    return replace(plan, certificate=replace(plan.certificate, words=words), message=words)


def too_near(candidates: Candidates, start: float) -> Plan:
    """No choice of contacts keeps the hands apart."""
    asked, most = candidates.distance, candidates.widest
    words = f"min_hand_distance: no choice of contacts keeps the hands {asked:g} m apart"
    if most < asked:
        words += f"; at most {most:.6g} m is possible"
    else:
        most = math.nan  # proven by exhaustion
    return certified(Certificate(words, asked, most, limits={"min_hand_distance": asked}), start)


def out_of_reach(beyond: Mapping[str, float], start: float) -> Plan:
    """Contacts are given by so many m (by arm) beyond the arms' reach."""
    words = "; ".join(f"{name}: reach: the contact is {excess:.3g} m beyond it" for name, excess in beyond.items())
    limits = {f"{name}: reach": excess for name, excess in beyond.items()}
    return certified(Certificate(words, max(beyond.values()), 0.0, limits=limits), start)


def certified(certificate: Certificate, start: float) -> Plan:
    spent = time.perf_counter() - start
    return Plan(INFEASIBLE, certificate=certificate, solve_time=spent, message=certificate.words)
