"""`ShownRun`: what pictures show of a run, be it simulated or read from a log."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..frames import Array, body_to_world
from ..logs.alignment import aligned
from ..logs.run_log import ArmLog, RunLog
from ..model import CartModel
from ..motion import Estimate
from ..simulation.record import RunRecord, Series
from .from_poses import trailing_headings, velocity_of_poses

HEALTH_OK = "ok"
"""The health of an estimate that is as it should be."""
MAX_CREDIBLE_VALUE = 1e5
"""m, N, N·m, m/s: what is larger can't be SI units, and counts as missing."""
EPOCH_THRESHOLD = 1e6
"""s; a clock beyond it counts from an epoch, and the picture from the run's start."""
OUTLINE_MARGIN = 0.08
"""m, from the wheels to the drawn edge of the body."""

Outline = tuple[float, float, float, float]
"""(x_min, x_max, y_min, y_max) in {b}, m."""


@dataclass(frozen=True)
class ShownRun:
    """n instants. Poses (n, 3) of {b} in {s}; velocity (n, 3) of its origin, in {b}; contacts (n, 3) in {b} and
    wrenches (n, 6) in {a} by arm; `com_covariance` (n, 2, 2) in {b}, m²; headings (n, casters) in {b}. A missing
    sample is NaN. `statuses` of plans and `healths` of estimates are words spread over the run."""

    name: str
    cart: CartModel | None
    time: Array
    pose: Array
    velocity_b: Array
    contacts: Mapping[str, Array]
    wrenches: Mapping[str, Array]
    reference_pose: Array | None = None
    parameters: Mapping[str, Series] = field(default_factory=dict)
    com_covariance: Array | None = None
    caster_headings: Array | None = None
    statuses: tuple[str, ...] = ()
    healths: tuple[str, ...] = ()

    @classmethod
    def of_record(cls, record: RunRecord) -> ShownRun:
        """A simulated run: motion and wrenches as they really were, where that is known."""
        arms, headings = record.log.arms, record.caster_headings
        return cls(
            name=record.log.name,
            cart=record.cart,
            time=record.time,
            pose=record.pose,
            velocity_b=record.velocity @ record.cart.basis_b.T,
            contacts={arm: log.contact for arm, log in arms.items()},
            wrenches={arm: np.asarray(record.wrenches.get(arm, log.wrench)) for arm, log in arms.items()},
            reference_pose=record.reference_pose,
            parameters=_estimated(record.parameters),
            com_covariance=record.com_covariance,
            caster_headings=trailing_headings(record.pose, record.cart) if headings is None else headings,
            statuses=record.statuses,
            healths=record.healths,
        )

    @classmethod
    def of_log(cls, log: RunLog, cart: CartModel | None = None, estimates: Sequence[Estimate] = ()) -> ShownRun:
        """A log as measured, with the estimates (one a row) of what was learned from it. What it does not hold is told
        by its poses: velocity by their differences, casters by where their wheels trail."""
        log = _credible(log if cart is None else aligned(log, cart))
        start = float(log.time[0])
        spreads = [spread for estimate in estimates if (spread := estimate.com_covariance) is not None]
        return cls(
            name=log.name,
            cart=cart,
            time=log.time - (start if abs(start) > EPOCH_THRESHOLD else 0.0),
            pose=log.pose,
            velocity_b=_velocity_b(log),
            contacts={arm: one.contact for arm, one in log.arms.items()},
            wrenches={arm: one.wrench for arm, one in log.arms.items()},
            parameters=_parameters(estimates),
            com_covariance=np.array(spreads) if len(spreads) == len(log) else None,
            caster_headings=None if cart is None else trailing_headings(log.pose, cart),
            healths=tuple(str(estimate.health) for estimate in estimates),
        )

    def averaged(self, rate: float = 20.0) -> ShownRun:
        """At most about `rate` rows a second, for print: velocities and wrenches averaged, all else as in between."""
        step = float(np.median(np.diff(self.time))) if len(self.time) > 1 else np.inf
        size = int(min(1.0 / (rate * step) + 1e-6, len(self.time)))
        if size < 2:
            return self
        n = len(self.time) // size * size
        rows = slice(size // 2, n, size)

        def mean(columns: Array) -> Array:
            return np.asarray(columns[:n].reshape(-1, size, columns.shape[1]).mean(axis=1))

        def between(columns: Array | None) -> Array | None:
            return None if columns is None else columns[rows]

        return replace(
            self,
            time=self.time[rows],
            pose=self.pose[rows],
            velocity_b=mean(self.velocity_b),
            contacts={arm: contact[rows] for arm, contact in self.contacts.items()},
            wrenches={arm: mean(wrench) for arm, wrench in self.wrenches.items()},
            reference_pose=between(self.reference_pose),
            parameters={name: series.at(rows) for name, series in self.parameters.items()},
            com_covariance=between(self.com_covariance),
            caster_headings=between(self.caster_headings),
        )

    @property
    def doubtful(self) -> np.ndarray:
        """Where (n,) the estimate says of itself that it is not as it should be."""
        said = np.array(self.healths or (HEALTH_OK,))
        return np.asarray(said[np.arange(len(self.time)) * len(said) // len(self.time)] != HEALTH_OK)

    @property
    def outline(self) -> Outline:
        """The outline of the cart's body as drawn."""
        return body_outline(self.cart, self.contacts.values())

    def estimated_com(self, i: int) -> tuple[tuple[float, float], Array] | None:
        """At instant i, in {b}, m, with its covariance (2, 2), m²; None where it is not known."""
        if not {"com_x", "com_y"} <= self.parameters.keys():
            return None
        along, across = self.parameters["com_x"], self.parameters["com_y"]
        covariance = np.diag([along.std[i] ** 2, across.std[i] ** 2])
        covariance = covariance if self.com_covariance is None else self.com_covariance[i]
        com = float(along.value[i]), float(across.value[i])
        return (com, covariance) if np.isfinite([*com, *covariance.ravel()]).all() else None

    @property
    def tracking_error(self) -> Array | None:
        """Distance of {b}'s origin from the reference, (n,), m."""
        if self.reference_pose is None:
            return None
        difference = self.pose[:, :2] - self.reference_pose[:, :2]
        return np.asarray(np.hypot(difference[:, 0], difference[:, 1]))


def body_outline(cart: CartModel | None, contacts: Iterable[Array]) -> Outline:
    """Round wheels and CoM, a box of the same inertia, or, of a cart that isn't known, round {b}'s origin and the usual
    contact of each arm, out of (n, 3)."""
    if cart is None:
        known = (contact[np.isfinite(contact[:, :2]).all(axis=1), :2] for contact in contacts)
        return _round(np.array([(0.0, 0.0), *(np.median(held, axis=0) for held in known if len(held))]))
    (x, y), about_com, mass = cart.inertia.com, cart.inertia.about_com, cart.inertia.mass
    if not cart.wheels:
        half_width = float(np.sqrt(3.0 * about_com / mass / 3.25))
        return x - 1.5 * half_width, x + 1.5 * half_width, y - half_width, y + half_width
    return _round(np.array([*((w.x, w.y) for w in cart.wheels), (x, y)]))


def _round(points: Array) -> Outline:
    centre, half = (points.min(0) + points.max(0)) / 2, (points.max(0) - points.min(0)) / 2
    half = np.maximum(half + OUTLINE_MARGIN, 0.15)
    low, high = centre - half, centre + half
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _credible(log: RunLog) -> RunLog:
    def masked(values: Array) -> Array:
        return np.where(np.abs(values) > MAX_CREDIBLE_VALUE, np.nan, values)

    arms = {name: ArmLog(masked(arm.contact), masked(arm.wrench)) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else masked(log.velocity)
    return replace(log, pose=masked(log.pose), velocity=velocity, arms=arms)


def _velocity_b(log: RunLog) -> Array:
    velocity = velocity_of_poses(log.time, log.pose) if log.velocity is None else log.velocity
    return np.asarray(velocity[:, None, :] @ body_to_world(log.pose[:, 2]))[:, 0]


def _parameters(estimates: Sequence[Estimate]) -> dict[str, Series]:
    if not estimates:
        return {}
    found = {}
    for name, last in estimates[-1].parameters.items():
        values, deviations = np.array([[e.parameters[name].value, e.parameters[name].std] for e in estimates]).T
        found[name] = Series(values, deviations, None, last.unit)
    return _estimated(found)


def _estimated(parameters: Mapping[str, Series]) -> dict[str, Series]:
    """Without those that stand as the cart's file has them."""
    return {name: series for name, series in parameters.items() if series.std.any()}
