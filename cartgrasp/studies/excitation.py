"""How to hold and drive so as to learn: fixed contacts, the paper's periodic switching, and chosen ones.

In closed loop two arms push a long cart of 24 kg that is first thought to weigh 16, its fixed wheels ahead. Each hand
may hold the handle 0.9 m behind the axle, the middle of the side rail, or the rail beside the axle. The force sensors
have 1 N and 0.05 N·m of noise at 100 Hz. The chosen ways are planned before the run from the first guess: what a motion
teaches does not depend on what there is to learn, only its effort does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, product

import numpy as np

from estimation import Prior
from planning import Choosing
from planning.contact_sources.by_time import FixedContacts, PeriodicContacts
from planning.excitation.excitation_choice import D_OPTIMAL, E_OPTIMAL, Allowance, ExcitationChooser
from planning.excitation.excitation_plan import ExcitationPlan, plan_excitation
from planning.references import PathReference, chain, pause, speed_change, turn

from ..arms import Arm
from ..constraints import RollingConstraints
from ..effects import ViscousDrag
from ..frames import Array
from ..inertia import N_PHI, Inertia
from ..information import KNOWN_INFORMATION, WrenchNoise, fisher_information, parameter_regressor, reduced_noise
from ..model import CartModel
from ..roles import ContactQuery, ContactSource, ReferencePath
from ..simulation.closed_loop import run
from ..simulation.record import RunRecord
from .parallel import Progress, run_all
from .scenario import Scenario, filter_noise, with_truth
from .shopping_cart import SENSOR_NOISE

DWELL_TIME = 3.0
FIXED_WAY, PERIODIC_WAY, CHOSEN_WAY = "fixed", "periodic", "chosen"
E_MOTION, D_MOTION = "weaving, E", "weaving, D"
"""The last three ways: `chosen` contacts keep to the path; the other two also weave by up to 3 cm."""
WAYS = (FIXED_WAY, PERIODIC_WAY, CHOSEN_WAY, E_MOTION, D_MOTION)
ALLOWANCES = {
    CHOSEN_WAY: Allowance(30.0, 0.0, E_OPTIMAL),
    E_MOTION: Allowance(30.0, 0.03, E_OPTIMAL),
    D_MOTION: Allowance(30.0, 0.03, D_OPTIMAL),
}
"""N² beyond the least, mean over each window; m to either side."""
KNOWN_PARAMETERS = frozenset({"viscous_drag"})
WRENCH_NOISE = WrenchNoise(SENSOR_NOISE.force, SENSOR_NOISE.moment, rate=100.0)
ARM_CONTACTS = ((-0.9, 0.2, 1.0), (-0.45, 0.3, 0.8), (0.0, 0.3, 0.8))


def arms() -> tuple[Arm, ...]:
    force, moment = (80.0, 60.0, 40.0), (10.0, 10.0, 15.0)
    sides = {"left": 1, "right": -1}
    return tuple(
        Arm(name, [(x, side * y, z) for x, y, z in ARM_CONTACTS], force_limit=force, moment_limit=moment)
        for name, side in sides.items()
    )


def scenario(way: str, seed: int) -> Scenario:
    """The run but for what is chosen."""
    drag = ViscousDrag(linear=3.0, angular=1.2)
    curves = (turn(np.pi / 2, 0.4), pause(4.0), turn(-np.pi / 2, 0.4))
    return Scenario(
        truth=CartModel(Inertia(24.0, (-0.35, 0.06), 2.6), RollingConstraints(), (drag,)),
        guess=CartModel(Inertia(16.0, (-0.45, 0.0), 2.0), RollingConstraints(), (drag,)),
        arms=arms(),
        stretches=chain(speed_change(0.6), pause(4.0), *curves, pause(4.0), speed_change(-0.6)),
        sensors=SENSOR_NOISE,
        noise=filter_noise(SENSOR_NOISE),
        contacts=PERIODIC_WAY if way == PERIODIC_WAY else FIXED_WAY,
        choosing=Choosing(every=DWELL_TIME),
        known=KNOWN_PARAMETERS,
        seed=seed,
    )


def excitation(allowance: Allowance) -> ExcitationPlan:
    """Planned from the first guess and what the filter believes of it."""
    base = scenario(FIXED_WAY, 0)
    chooser = ExcitationChooser(base.guess, base.arms, WRENCH_NOISE, allowance)
    reference = PathReference(base.stretches, base.guess.rolling)
    return plan_excitation(chooser, reference, first_information(base.guess), DWELL_TIME)


def first_information(guess: CartModel) -> Array:
    """(p, p) of the filter's prior, with what is known fixed."""
    information = np.linalg.inv(Prior().covariance(guess))
    information[N_PHI:, N_PHI:] = KNOWN_INFORMATION * np.eye(len(information) - N_PHI)
    return np.asarray(information)


@dataclass(frozen=True, eq=False)
class Drive:
    """One way of driving, over seeds."""

    way: str
    records: tuple[RunRecord, ...]

    @property
    def time(self) -> Array:
        return self.records[0].time

    def std(self, parameter: str) -> Array:
        """Standard deviation that the filter reports, (n,), root mean square over seeds."""
        return np.asarray(np.sqrt(np.mean([r.parameters[parameter].std ** 2 for r in self.records], axis=0)))

    def errors(self, parameter: str) -> Array:
        """Estimate minus truth at the end, by seed."""
        series = [record.parameters[parameter] for record in self.records]
        return np.array([s.value[-1] - s.truth[-1] for s in series if s.truth is not None])

    @property
    def effort(self) -> Array:
        """Paid up to each time (n,), N²·s, mean over seeds."""
        weights = {arm.name: np.array(arm.weights) for arm in arms()}
        rates = [sum(w**2 @ weights[arm] for arm, w in r.wrenches.items()) for r in self.records]
        return np.asarray(np.cumsum(np.mean(rates, axis=0)) * float(self.time[1] - self.time[0]))

    @property
    def tracking_error(self) -> float:
        """The largest from 5 s on, m."""
        return max(float(r.tracking_error[r.time >= 5.0].max()) for r in self.records)


def run_seeds(seeds: Sequence[int], workers: int = 1, progress: Progress = None) -> list[Drive]:
    """Every way with every seed, over `workers` processes."""
    records = iter(run_all(_drive, list(product(WAYS, seeds)), workers, progress))
    return [Drive(way, tuple(islice(records, len(seeds)))) for way in WAYS]


def drive(way: str, seed: int, duration: float | None = None) -> RunRecord:
    """One closed-loop run, whole or of a duration (s)."""
    base = scenario(way, seed)
    parts = {}
    if way in ALLOWANCES:
        plan = excitation(ALLOWANCES[way])
        parts = {"reference": plan.reference, "contacts": plan}
    return with_truth(run(base.build(**parts), duration), base.truth)


def way_information(way: str) -> Array:
    """Information (p, p) at the end, the prior's included, of a drive along the way's own reference."""
    if way in ALLOWANCES:
        plan = excitation(ALLOWANCES[way])
        return information_along(plan.reference, plan)
    base = scenario(way, 0)
    source = PeriodicContacts(base.arms, DWELL_TIME) if way == PERIODIC_WAY else FixedContacts(base.arms)
    return information_along(PathReference(base.stretches, base.truth.rolling), source)


def information_along(reference: ReferencePath, source: ContactSource) -> Array:
    """Information (p, p) at the end of a drive along a reference, held where `source` says, the prior's included."""
    base = scenario(FIXED_WAY, 0)
    cart = base.truth
    times = (np.arange(round(reference.duration * WRENCH_NOISE.rate)) + 0.5) / WRENCH_NOISE.rate
    wanted = [reference.at(time) for time in times]
    states = np.array([cart.state(w.pose_sb, w.velocity) for w in wanted])
    regressors = parameter_regressor(cart, states, np.array([w.acceleration for w in wanted]))
    points = np.array([list(source.contacts(ContactQuery(time, np.zeros(3))).contacts.values()) for time in times])
    each = fisher_information(regressors[:, None], reduced_noise(cart, points, WRENCH_NOISE))
    return np.asarray(first_information(base.guess) + each.sum(axis=0))


def _drive(job: tuple[str, int]) -> RunRecord:
    return drive(*job)
