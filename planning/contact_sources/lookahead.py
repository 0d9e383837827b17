"""What each choice of contacts costs and teaches in a window ahead, along the reference, for a cart as now believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array
from cartgrasp.information import WrenchNoise, fisher_information, reduced_noise
from cartgrasp.model import CartModel
from cartgrasp.roles import ReferencePath

from ..allocation.allocation_template import AllocationTemplate
from ..control.hand import RegraspTimes
from ..excitation.excitation_family import FreeSplit, as_sensed, contact_choices, motions
from ..planner import WrenchPlanner
from ..quadratic_program import OPTIMAL

SAME_CHOICE_DISTANCE = 1e-6  # m


@dataclass(frozen=True, eq=False)
class ContactFamily:
    """Every choice (J, n, 3) of the arms' points, with what does not depend on the cart's load; `without` each of the
    arms (none where one is alone) the split over the others."""

    names: tuple[str, ...]
    choices: Array
    split: FreeSplit
    noise: WrenchNoise
    reduced: Array
    planner: WrenchPlanner
    without: tuple[FreeSplit, ...]

    @classmethod
    def of(cls, cart: CartModel, arms: Sequence[Arm], noise: WrenchNoise, min_hand_distance: float) -> ContactFamily:
        template = AllocationTemplate.of(cart, arms)
        choices = contact_choices(arms, min_hand_distance)
        noise = as_sensed(noise)
        return cls(
            names=tuple(arm.name for arm in arms),
            choices=choices,
            split=FreeSplit.of(template, choices),
            noise=noise,
            reduced=reduced_noise(cart, choices, noise, template.yaws),
            planner=WrenchPlanner(cart, arms),
            without=tuple(_without(cart, arms, choices, i) for i in range(len(arms)) if len(arms) > 1),
        )

    def index_of(self, held: Mapping[str, Array]) -> int | None:
        """The choice that is held; None where it is none of these, as while a hand is on its way."""
        if set(held) != set(self.names):
            return None
        away = np.abs(self.choices - np.array([held[name] for name in self.names])).max(axis=(1, 2))
        best = int(away.argmin())
        return best if away[best] <= SAME_CHOICE_DISTANCE else None

    def contacts(self, choice: int) -> dict[str, Array]:
        return dict(zip(self.names, self.choices[choice], strict=True))

    def ahead(self, cart: CartModel, reference: ReferencePath, window: tuple[float, float]) -> Lookahead:
        way = motions(reference, cart, window, 0.0)
        samples = (window[1] - window[0]) * self.noise.rate / way.samples
        noise = self.reduced + self.noise.rate * _stiction(cart, reference, window, way.samples)
        taught = samples * fisher_information(way.regressors[0], noise)
        alone = np.array([split.efforts(way.needed)[0] for split in self.without])
        return Lookahead(self, cart.planar_wrench(way.needed[0]), self.split.efforts(way.needed)[0], taught, alone)


def _without(cart: CartModel, arms: Sequence[Arm], choices: Array, arm: int) -> FreeSplit:
    others = [i for i in range(len(arms)) if i != arm]
    return FreeSplit.of(AllocationTemplate.of(cart, [arms[i] for i in others]), choices[:, others])


def _stiction(cart: CartModel, reference: ReferencePath, window: tuple[float, float], samples: int) -> Array:
    """Mean density (k, k) of what stiction leaves open of the reduced wrench, as the filter counts it: no contact makes
    it less, so that where it is large there is nothing to gain by another one."""
    times = window[0] + (np.arange(samples) + 0.5) * (window[1] - window[0]) / samples
    wanted = [reference.at(time) for time in times.tolist()]
    states = np.array([cart.state(one.pose_sb, one.velocity) for one in wanted])
    roots = cart.basis_b.T @ cart.stiction(states, cart.parameters, time=float(times.mean()))
    return np.asarray((roots @ np.swapaxes(roots, -1, -2)).mean(axis=0))


@dataclass(frozen=True, eq=False)
class Lookahead:
    """The wrenches (T, 3) in {b} that the reference needs, and by choice the mean effort that no limit can lower,
    `lowest` (J,) in N², and the Fisher information `taught` (J, p, p); `alone` (n, J) is as `lowest`, without each arm.
    """

    family: ContactFamily
    wrenches: Array
    lowest: Array
    taught: Array
    alone: Array
    _efforts: dict[int, float] = field(default_factory=dict)

    def effort(self, choice: int) -> float:
        """Mean effort of the choice's QPs, N²; infinite where one has no solution."""
        if choice not in self._efforts:
            contacts, total = self.family.contacts(choice), 0.0
            for wrench in self.wrenches:
                plan = self.family.planner.plan(wrench, contacts=contacts)
                total += np.inf if plan.status != OPTIMAL or plan.effort is None else plan.effort
                if not np.isfinite(total):
                    break
            self._efforts[choice] = total / len(self.wrenches)
        return self._efforts[choice]

    def regrasps(self, held: int | None, times: RegraspTimes, effort: float) -> Array:
        """What it costs to go from a choice to each, (J,), N²·s: for each hand that moves an `effort`, and what the
        others bear more while it is away; where there are none, what it does not give, which has to be made up for.
        Nothing where nothing is held."""
        if held is None:
            return np.zeros(len(self.lowest))
        choices = self.family.choices
        distances = np.linalg.norm(choices - choices[held], axis=2)
        lasting = np.where(distances > SAME_CHOICE_DISTANCE, times.lasting(distances), 0.0)
        alone = self.alone[:, held] - self.lowest[held] if len(self.alone) else self.lowest[[held]]
        more = np.maximum(alone, 0.0)
        return np.asarray(lasting @ more + effort * (lasting > 0).sum(axis=1))

    def cheapest(self, charges: Array) -> int | None:
        """The choice of least effort and charge (J,), N²; None where no choice can drive the reference."""
        best, least = None, np.inf
        for choice in np.argsort(self.lowest + charges, kind="stable").tolist():
            if self.lowest[choice] + charges[choice] >= least * (1 - SAME_CHOICE_DISTANCE):
                break
            cost = self.effort(choice) + charges[choice]
            if cost < least:
                best, least = choice, cost
        return best
