"""A whole reference made to teach: window after window, each the best of its family given what is known by then.

With criterion D and no unknowns but phi, the volume's logarithm is a monotone submodular function of what is taught, so
this order wins at least half of what the best of all sequences of the same families wins.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cartgrasp.checks import positive
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.roles import ContactChoice, ContactQuery, ReferencePath

from ..quadratic_program import OPTIMAL
from .deviation import DeviatedReference
from .excitation_choice import Excitation, ExcitationChooser


@dataclass(frozen=True, eq=False)
class ExcitationPlan:
    """The reference with its deviations, and where to hold in each window. It is a `ContactSource`."""

    reference: DeviatedReference
    windows: tuple[Excitation, ...]

    def contacts(self, query: ContactQuery) -> ContactChoice:
        starts = [window.window[0] for window in self.windows]
        k = max(0, int(np.searchsorted(starts, query.time + 1e-9, side="right")) - 1)
        return ContactChoice(self.windows[k].contacts, "teaches most, as planned")


def plan_excitation(
    chooser: ExcitationChooser, reference: ReferencePath, information: Array, dwell: float
) -> ExcitationPlan:
    """In windows of `dwell` (s) to the reference's end, from what is known before; pure, so call it again when more is
    known. A window whose reference can't be driven is an error that names it."""
    n = max(1, round(reference.duration / positive("excitation: dwell", dwell, np.inf, "give s")))
    edges = np.linspace(0.0, reference.duration, n + 1).tolist()
    windows: list[Excitation] = []
    for window in pairwise(edges):
        found = chooser.choose(reference, window, information)
        if found.status != OPTIMAL:
            raise UsageError(f"excitation: from {window[0]:g} to {window[1]:g} s no contacts can drive the reference")
        windows.append(found)
        information = found.information
    deviations = tuple(window.deviation for window in windows if window.deviation is not None)
    return ExcitationPlan(DeviatedReference(reference, deviations, chooser.cart.rolling), tuple(windows))
