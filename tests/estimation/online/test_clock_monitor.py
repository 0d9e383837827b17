"""Stamps in other units than seconds are told where velocities are there; samples too far apart are never `ok`."""

from dataclasses import replace

import pytest

from cartgrasp.motion import Measurement
from estimation.health import Health
from estimation.online.clock_monitor import TIME_UNITS
from estimation.whole_log.replay import replay

from ..runs import CONTACT
from .test_sensor_monitor import GUESS, KINDS, at_rate, run

ONLINE = pytest.mark.parametrize("which", KINDS)


def told(log, which):
    kind, noise = KINDS[which]
    return replay(log, kind(GUESS, ["hand"], noise=noise)).estimates


@pytest.mark.long
@pytest.mark.some(4)
@ONLINE
@pytest.mark.parametrize("unit", ["ms", "μs", "ns"])
def test_units_of_time_are_told(which, unit):
    found = told(replace(run(), time=run().time / TIME_UNITS[unit]), which)
    at_five = found[500]
    assert [(one.kind, one.where, one.factor) for one in at_five.suspicions] == [("unit", "time", TIME_UNITS[unit])]
    assert {one.health for one in found[1:]} == {Health.STALE}


@ONLINE
def test_without_velocities_nothing_is_ok(which):
    found = told(replace(run(), time=1000 * run().time, velocity=None), which)
    assert {one.health for one in found[1:]} == {Health.STALE}
    assert not any(one.suspicions for one in found)


@pytest.mark.long
@pytest.mark.some(1)
@ONLINE
def test_samples_that_really_are_far_apart_are_only_stale(which):
    """Every 1.5 s."""
    from ..runs import simulate
    from .test_sensor_monitor import PLANT

    log = simulate(PLANT, 3, duration=120.0, noise=(0.0004, 0.005, 0.3))[0]
    rows = slice(None, None, 150)
    arms = {name: type(arm)(arm.contact[rows], arm.wrench[rows]) for name, arm in log.arms.items()}
    sparse = replace(log, time=log.time[rows], pose=log.pose[rows], velocity=log.velocity[rows], arms=arms)
    found = told(sparse, which)
    assert not any(one.suspicions for one in found)
    assert {one.health for one in found[1:]} == {Health.STALE}


@pytest.mark.parametrize("which", KINDS)
@pytest.mark.parametrize(("rate", "late"), [(1000, 0.0), (2000, 0.0), (1000, 0.0001), (100, 0.005)])
def test_milliseconds_are_told_of_quick_loops_too(which, rate, late):
    """At 1 kHz stamps are no more than 1 s apart, and health was ok though nothing could be learned. Wrenches of their
    own stamps hid the unit, too."""
    kind, noise = KINDS[which]
    made = kind(GUESS, ["hand"], noise=noise)
    for time, pose, velocity, wrench in zip(*(part[:1000] for part in at_rate(rate)), strict=True):
        estimate = made.update(Measurement(1000.0 * time, pose, velocity))
        if late:
            estimate = made.update(Measurement(1000.0 * (time + late), None, None, {"hand": wrench}, {"hand": CONTACT}))
        elif time == 0.0:
            made.update(Measurement(0.0, None, None, {"hand": wrench}, {"hand": CONTACT}))
    assert estimate.health == Health.STALE
    assert [(one.kind, one.where, one.factor) for one in estimate.suspicions] == [("unit", "time", 1e-3)]
