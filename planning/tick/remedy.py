"""Where else a wrench that can't be given could be: with the planner's own candidates, or one hand moved aside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.contacts import MAX_POSITION, ContactSet, Segment
from cartgrasp.frames import Array

from ..allocation.infeasibility import Certificate
from ..contacts.contact_bounds import Candidates
from ..contacts.contact_cases import CaseSolver, Question
from ..contacts.contact_choice import ContactSearch, SearchLimit

CONTACT_SEARCH_HALF_WIDTH = 0.5  # m, to either side along {b}'s y
REMEDY_SEARCH = SearchLimit(solves=40)


def find_remedy(
    solver: CaseSolver, question: Question, own: Candidates | None, held: Mapping[str, Array], distance: float
) -> dict[str, Array]:
    """Contacts by arm, those that would have to move, for a question that has no answer at `held`. `own` are
    the planner's candidates if they were not all tried. Empty if none is found; that proves nothing."""
    names, points = solver.template.names, np.array(list(held.values()))
    tries = [] if own is None else [own]
    tries += [_aside(solver.template.arms, points, i, distance) for i in range(len(names))]
    for candidates in tries:
        found = ContactSearch(candidates, solver, question, REMEDY_SEARCH).run().contacts
        if found is not None:
            moved = np.linalg.norm(found - points, axis=1) > 1e-9
            return {name: found[i] for i, name in enumerate(names) if moved[i]}
    return {}


def with_remedy(certificate: Certificate, remedy: Mapping[str, Array], held: Mapping[str, Array]) -> Certificate:
    """The certificate, with the contacts that would do, told by what is new of them."""
    if not remedy:
        return certificate
    parts = " and ".join(f"{name} at {_spoken(point, held[name])}" for name, point in remedy.items())
    contacts = {name: (float(x), float(y), float(z)) for name, (x, y, z) in remedy.items()}
    return replace(certificate, words=f"{certificate.words}; with {parts} it would be feasible", remedy=contacts)


def _spoken(point: Array, old: Array) -> str:
    new = np.abs(point - old) > 1e-9
    return ", ".join(f"{axis} = {value:.3g} m" for axis, value, is_new in zip("xyz", point, new, strict=True) if is_new)


def _aside(arms: Sequence[Arm], held: Array, index: int, distance: float) -> Candidates:
    """One hand anywhere to either side that is in its reach, the others where they are."""
    sets = [ContactSet(((x, y, z),)) for x, y, z in held.tolist()]
    x, y, z = held[index].tolist()
    low = max(y - CONTACT_SEARCH_HALF_WIDTH, -MAX_POSITION)
    high = min(y + CONTACT_SEARCH_HALF_WIDTH, MAX_POSITION)
    aside = ContactSet(segments=(Segment((x, low, z), (x, high, z)),))
    reach = arms[index].reach
    left = aside if reach is None else reach.clip(aside)
    sets[index] = sets[index] if left is None else left
    return Candidates.of(sets, distance)
