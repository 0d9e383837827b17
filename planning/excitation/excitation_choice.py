"""Where to hold and how to drive in the next window, so as to learn most for the effort allowed.

Of a finite family (every choice of the arms' points times every small deviation) the best is found, for

    E: the largest standard deviation over directions of phi (scaled) is least,
    D: the volume of phi's ellipsoid of uncertainty is least,

after the window, by the Fisher information with the force sensors' noise at the lever arms. The split of the wrench
over the arms does not change what is learned, so it is the one of least effort: free of internal force unless a limit
binds. Information about phi does not depend on phi: only what it costs does.

The search is exact. Candidates are taken in falling order of what they teach; those whose effort without limits is
above the allowance are out, because limits only add to it; of the rest, the first whose QPs are all feasible and
within the allowance is the best of the family.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.information import (
    WrenchNoise,
    fisher_information,
    least_known,
    phi_covariance,
    phi_scales,
    reduced_noise,
)
from cartgrasp.model import CartModel
from cartgrasp.roles import ReferencePath

from ..allocation.allocation_template import AllocationTemplate
from ..planner import WrenchPlanner
from ..quadratic_program import INFEASIBLE, OPTIMAL
from .deviation import Deviation
from .excitation_family import FreeSplit, Motions, as_sensed, contact_choices, motions

E_OPTIMAL, D_OPTIMAL = "E", "D"
EFFORT_TOLERANCE = 1e-9
MERIT_DECIMALS = 9
"""Decimals to which the logarithm of the merit is rounded; motions that teach equally much are ordered by effort."""


@dataclass(frozen=True)
class Allowance:
    """What may be spent on learning: `effort` (N², mean over the window) beyond the least that the reference needs, and
    an `offset` (m) from it along and across; by which criterion, E or D; and the least distance between hands (m)."""

    effort: float = 50.0
    offset: float = 0.03
    criterion: str = E_OPTIMAL
    min_hand_distance: float = 0.0

    def __post_init__(self) -> None:
        numbers = [self.effort, self.offset, self.min_hand_distance]
        if not (np.isfinite(numbers).all() and min(numbers) >= 0):
            raise UsageError(f"excitation: {self} must have finite numbers >= 0")
        if self.criterion not in (E_OPTIMAL, D_OPTIMAL):
            raise UsageError(f"excitation: criterion {self.criterion!r} is neither {E_OPTIMAL!r} nor {D_OPTIMAL!r}")


@dataclass(frozen=True, eq=False)
class Excitation:
    """What to do in a window: contacts (3,) by arm, a deviation or None, the wrenches (T, 6) in {a} by arm.

    `effort` and `least_effort` are means (N²); `internal_force` is the largest part of the wrenches that presses arms
    against each other (N, 0 unless a limit binds). `information` (p, p) is the sum after the window; `before` and
    `after` are the largest standard deviations over directions of scaled phi, `direction` (4,) the least known one
    before. `solved` QPs settled the order of `tried` candidates. `infeasible`: no contacts do for the reference.
    """

    status: str
    window: tuple[float, float]
    contacts: Mapping[str, Array] = field(default_factory=dict)
    deviation: Deviation | None = None
    wrenches: Mapping[str, Array] = field(default_factory=dict)
    effort: float = np.inf
    least_effort: float = np.inf
    internal_force: float = 0.0
    information: Array = field(default_factory=lambda: np.zeros((0, 0)))
    before: float = np.inf
    after: float = np.inf
    direction: Array = field(default_factory=lambda: np.zeros(4))
    tried: int = 0
    solved: int = 0


class ExcitationChooser:
    """Knows cart, arms, sensor noise and allowance; `choose` is asked window by window."""

    def __init__(
        self, cart: CartModel, arms: Sequence[Arm], noise: WrenchNoise, allowance: Allowance = Allowance()
    ) -> None:
        self.cart, self.noise, self.allowance = cart, as_sensed(noise), allowance
        self._template = AllocationTemplate.of(cart, arms)
        self.choices = contact_choices(arms, allowance.min_hand_distance)
        self._planner = WrenchPlanner(cart, [arm.without_rate() for arm in arms])
        self._split = FreeSplit.of(self._template, self.choices)
        self._noise = reduced_noise(cart, self.choices, self.noise, self._template.yaws)
        self.scales = phi_scales(cart.inertia.phi)

    def choose(self, reference: ReferencePath, window: tuple[float, float], information: Array) -> Excitation:
        """`information` (p, p) on `cart.parameters` is what is known before, with a prior, so that it is regular."""
        if not window[0] < window[1]:
            raise UsageError(f"excitation: the window {window} s has no length")
        try:
            before, direction = least_known(information, self.scales)
        except np.linalg.LinAlgError as error:
            raise UsageError("excitation: the information is not finite, or singular; add a prior's") from error
        family = motions(reference, self.cart, window, self.allowance.offset)
        lowest = self._split.efforts(family.needed)
        least, solved = self._least_effort(family, lowest[0])
        if least is None:
            return Excitation(INFEASIBLE, window, before=before, direction=direction, solved=solved)
        totals = information + self.taught(family, window)
        best, more = self._search(family, self._merit(totals), lowest, least)
        after = totals[best.motion, best.choice]
        names = self._template.names
        return Excitation(
            status=OPTIMAL,
            window=window,
            contacts=dict(zip(names, self.choices[best.choice], strict=True)),
            deviation=family.deviations[best.motion],
            wrenches=dict(zip(names, np.moveaxis(best.wrenches.reshape(-1, len(names), 6), 1, 0), strict=True)),
            effort=best.effort,
            least_effort=least.effort,
            internal_force=self._internal_force(best, family),
            information=after,
            before=before,
            after=least_known(after, self.scales)[0],
            direction=direction,
            tried=lowest.size,
            solved=solved + more,
        )

    def taught(self, family: Motions, window: tuple[float, float]) -> Array:
        """Information (M, J, p, p) that each motion gives at each choice of contacts."""
        samples = (window[1] - window[0]) * self.noise.rate / family.samples
        return samples * fisher_information(family.regressors[:, None], self._noise[None])

    def _merit(self, information: Array) -> Array:
        """The larger, the better known is phi: of information (..., p, p)."""
        values = np.linalg.eigvalsh(phi_covariance(information) / np.outer(self.scales, self.scales))
        logs = -np.log(values)
        merit = logs[..., -1] if self.allowance.criterion == E_OPTIMAL else logs.sum(axis=-1)
        return np.asarray(np.round(merit, MERIT_DECIMALS))

    def _least_effort(self, family: Motions, lowest: Array) -> tuple[_Allocated | None, int]:
        """The reference itself at its best contacts (None: at none), and how many QPs it took; `lowest` (J,) bounds."""
        least: _Allocated | None = None
        solved = 0
        for choice in np.argsort(lowest).tolist():
            if least is not None and lowest[choice] * (1 - EFFORT_TOLERANCE) >= least.effort:
                break
            found = self._allocated(family, 0, choice)
            solved += family.samples
            if found is not None and (least is None or found.effort < least.effort):
                least = found
        return least, solved

    def _search(self, family: Motions, merits: Array, lowest: Array, least: _Allocated) -> tuple[_Allocated, int]:
        """The best within the allowance (`least` where nothing teaches more), and how many QPs it took."""
        budget, solved = (least.effort + self.allowance.effort) * (1 + EFFORT_TOLERANCE), 0
        for index in np.lexsort((lowest.ravel(), -merits.ravel())).tolist():
            motion, choice = divmod(index, merits.shape[1])
            if merits[motion, choice] <= merits[least.motion, least.choice]:
                break
            if lowest[motion, choice] > budget:
                continue
            found = self._allocated(family, motion, choice)
            solved += family.samples
            if found is not None and found.effort <= budget:
                return found, solved
        return least, solved

    def _allocated(self, family: Motions, motion: int, choice: int) -> _Allocated | None:
        """The QPs of a motion at a choice of contacts; None if one has no solution."""
        contacts = dict(zip(self._template.names, self.choices[choice], strict=True))
        efforts, wrenches = [], []
        for wrench_b in self.cart.planar_wrench(family.needed[motion]):
            plan = self._planner.plan(wrench_b, contacts=contacts)
            if plan.status != OPTIMAL or plan.effort is None:
                return None
            efforts.append(plan.effort)
            wrenches.append(np.concatenate(list(plan.wrenches.values())))
        return _Allocated(motion, choice, float(np.mean(efforts)), np.array(wrenches))

    def _internal_force(self, found: _Allocated, family: Motions) -> float:
        free = self._split.wrenches(found.choice, family.needed[found.motion])
        return float(np.abs(found.wrenches - free).reshape(-1, 6)[:, :3].max())


@dataclass(frozen=True, eq=False)
class _Allocated:
    """A candidate with its mean effort (N²) and wrenches (T, 6n)."""

    motion: int
    choice: int
    effort: float
    wrenches: Array
