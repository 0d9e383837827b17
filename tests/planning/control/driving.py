"""One control period after another: sense, step, push, feel; what is sensed and done may be spoiled between."""

from __future__ import annotations

from typing import NamedTuple

from cartgrasp.contacts import ContactWrenches
from cartgrasp.motion import Measurement, Motion
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from planning.control.step import Step


class Tick(NamedTuple):
    """A step, what was felt after it, and the cart's true motion at its end."""

    step: Step
    felt: Measurement
    motion: Motion


# Many parameters: what may be spoiled, each with a default.
def ticks(
    controller,
    truth,
    duration,
    noise=None,
    seed=3,
    blind=lambda time: False,
    spoiled=lambda felt, given: (felt, given),
    pose_sb=(0.0, 0.0, 0.0),
):
    """Of a controller, warmed up, that drives a true cart, which stands at `pose_sb`, for so many s; `blind` at some
    times, with what is felt and given `spoiled`."""
    controller.warm_up()
    plant = ModelPlant(truth, pose_sb=pose_sb)
    sensors = Sensors(truth, noise or SensorNoise(force=1.0, moment=0.05), seed=seed)
    for _ in range(round(duration / controller.period)):
        sensed = sensors.motion(plant.time, plant.motion)
        step = controller.step(Measurement(plant.time) if blind(plant.time) else sensed)
        felt, given = spoiled(sensors.wrenches(plant.time, step.given), step.given)
        controller.observe(felt)
        plant.step(given, controller.period)
        yield Tick(step, felt, plant.motion)


def without(arm, felt, given):
    """An arm that gives nothing, whose sensor says so."""
    nothing = {arm: 0.0 * given.wrenches[arm]}
    told = Measurement(felt.time, wrenches={**felt.wrenches, **nothing}, contacts=felt.contacts)
    return told, ContactWrenches({**given.wrenches, **nothing}, given.contacts)
