"""The closed loop: a controller, a plant and its sensors, known only by their roles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..checks import MAX_NUMBER, number
from ..errors import UsageError
from ..frames import Array
from ..logs.run_log import RunLog
from ..motion import Estimate, Measurement, Motion, Reference
from ..roles import Controller, Plant
from .record import RunRecord, Series
from .sensors import Sensors


@dataclass(frozen=True)
class Loop:
    """What takes part."""

    controller: Controller
    plant: Plant
    sensors: Sensors


@dataclass(frozen=True)
class _Row:
    measurement: Measurement
    motion: Motion
    reference: Reference
    estimate: Estimate
    wrenches: Mapping[str, Array]
    headings: Array | None
    status: str
    words: str


def run(loop: Loop, duration: float | None = None, progress: Callable[[float], None] | None = None) -> RunRecord:
    """Runs to the end of the reference; `progress` is told the share done."""
    controller = loop.controller
    lasting = controller.reference.duration if duration is None else duration
    n = round(number("run: duration", lasting, 0.0, MAX_NUMBER, "give s") / controller.period)
    if n < 1:
        raise UsageError(f"run: duration: {lasting:g} s is no period of control; give at least {controller.period:g} s")
    rows = []
    for k in range(n):
        rows.append(_tick(loop))
        if progress is not None and k % 50 == 0:
            progress(k / n)
    return _record(controller, rows)


def _tick(loop: Loop) -> _Row:
    """One control period: sense, step, push, feel."""
    controller, plant, sensors = loop.controller, loop.plant, loop.sensors
    time, motion = plant.time, plant.motion
    sensed = sensors.motion(time, motion)
    step = controller.step(sensed)
    acceleration = plant.acceleration(step.given) if sensors.cart.feels_motion else None
    felt = sensors.wrenches(time, step.given, acceleration)
    estimate = controller.observe(felt)
    headings = getattr(plant, "caster_headings", None)
    plant.step(step.given, controller.period)
    measurement = Measurement(time, sensed.pose, sensed.velocity, felt.wrenches, felt.contacts)
    told = step.plan.status, step.words
    return _Row(measurement, motion, step.reference, estimate, step.given.wrenches, headings, *told)


def _record(controller: Controller, rows: list[_Row]) -> RunRecord:
    arms = list(rows[0].wrenches)
    names = list(rows[0].estimate.parameters) if controller.learns else []
    parameters = {}
    for name in names:
        estimates = [row.estimate.parameters[name] for row in rows]
        values, deviations = np.array([[e.value, e.std] for e in estimates]).T
        parameters[name] = Series(values, deviations, None, estimates[0].unit)
    headings = [row.headings for row in rows]
    spreads = [row.estimate.com_covariance for row in rows] if controller.learns else [None]
    return RunRecord(
        log=RunLog.from_measurements([row.measurement for row in rows], arms),
        cart=controller.cart,
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
        words=tuple(
            (row.measurement.time, row.words)
            for before, row in pairwise([None, *rows])
            if row is not None and (before is None or before.words != row.words)
        ),
        healths=tuple(str(row.estimate.health) for row in rows) if controller.learns else (),
    )
