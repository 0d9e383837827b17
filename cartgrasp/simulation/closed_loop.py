"""The closed loop: reference, tracker, planner, plant, sensors and estimator, known only by their roles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..frames import Array
from ..logs.run_log import RunLog
from ..model import CartModel
from ..motion import Estimate, Measurement, Motion, Reference
from ..roles import ContactSource, Estimator, Planner, Plant, ReferencePath, Tracker
from .record import RunRecord, Series
from .sensors import Sensors


@dataclass(frozen=True)
class Loop:
    """What takes part. `period` is the control period (s); `cart` is the first guess, and all that the controller
    believes where it does not `learn`."""

    reference: ReferencePath
    tracker: Tracker
    contacts: ContactSource
    planner: Planner
    plant: Plant
    sensors: Sensors
    estimator: Estimator
    cart: CartModel
    period: float = 0.01
    learn: bool = True


@dataclass(frozen=True)
class _Row:
    measurement: Measurement
    motion: Motion
    reference: Reference
    estimate: Estimate
    wrenches: Mapping[str, Array]
    headings: Array | None
    status: str


def run(loop: Loop, duration: float | None = None, progress: Callable[[float], None] | None = None) -> RunRecord:
    """Runs to the end of the reference; `progress` is told the share done."""
    duration = loop.reference.duration if duration is None else duration
    n = round(duration / loop.period)
    rows = []
    for k in range(n):
        rows.append(_tick(loop))
        if progress is not None and k % 50 == 0:
            progress(k / n)
    return _record(loop, rows)


def _tick(loop: Loop) -> _Row:
    """One control period: sense, estimate, track, plan, push."""
    time, motion = loop.plant.time, loop.plant.motion
    sensed = loop.sensors.motion(time, motion)
    estimate = loop.estimator.update(sensed)
    reference = loop.reference.at(time)
    model = estimate.cart() if loop.learn else loop.cart
    wanted = loop.tracker.wrench_b(reference, estimate.motion, model)
    plan = loop.planner.plan_or_hold(wanted, contacts=loop.contacts.contacts(time, wanted))
    given = plan.contact_wrenches
    acceleration = loop.plant.acceleration(given) if loop.sensors.cart.feels_motion else None
    felt = loop.sensors.wrenches(time, given, acceleration)
    estimate = loop.estimator.update(felt)
    headings = getattr(loop.plant, "caster_headings", None)
    loop.plant.step(given, loop.period)
    measurement = Measurement(time, sensed.pose, sensed.velocity, felt.wrenches, felt.contacts)
    return _Row(measurement, motion, reference, estimate, given.wrenches, headings, plan.status)


def _record(loop: Loop, rows: list[_Row]) -> RunRecord:
    arms = list(rows[0].wrenches)
    names = list(rows[0].estimate.parameters) if loop.learn else []
    parameters = {}
    for name in names:
        estimates = [row.estimate.parameters[name] for row in rows]
        values, deviations = np.array([[e.value, e.std] for e in estimates]).T
        parameters[name] = Series(values, deviations, None, estimates[0].unit)
    headings = [row.headings for row in rows]
    spreads = [row.estimate.com_covariance for row in rows] if loop.learn else [None]
    return RunRecord(
        log=RunLog.from_measurements([row.measurement for row in rows], arms),
        cart=loop.cart,
        pose=np.array([row.motion.pose_sb for row in rows]),
        velocity=np.array([row.motion.velocity for row in rows]),
        reference_pose=np.array([row.reference.pose_sb for row in rows]),
        reference_velocity=np.array([row.reference.velocity for row in rows]),
        wrenches={arm: np.array([row.wrenches[arm] for row in rows]) for arm in arms},
        parameters=parameters,
        caster_headings=None if headings[0] is None else np.array(headings),
        statuses=tuple(row.status for row in rows),
        identifiable={name: rows[-1].estimate.parameters[name].identifiable for name in names},
        com_covariance=None if spreads[0] is None else np.array(spreads),
        healths=tuple(str(row.estimate.health) for row in rows) if loop.learn else (),
    )
