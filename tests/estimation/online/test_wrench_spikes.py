"""A wrench that leaps for a sample or three is left out and told; a push that stays is only a sample late."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.logs import ArmLog
from cartgrasp.motion import Measurement
from estimation import CartFilter, FilterNoise, RegressorEstimator
from estimation.online.wrench_spikes import LASTS, WrenchSpikes
from estimation.whole_log.replay import replay

from ..runs import simulate
from .test_sensor_watch import EXACT, GUESS, KINDS, NOISY, PLANT, run

ONLINE = pytest.mark.parametrize("which", KINDS)


def sifted(forces, period=0.01, noise=1.0):
    """What comes through of forces, by sample, in the order in which it comes; and what is told."""
    spikes, came = WrenchSpikes(FilterNoise(force=noise)), []
    for k, force in enumerate(forces):
        sample = Measurement(period * k, wrenches={"hand": [force, 0, 0, 0, 0, 0]})
        held, now = spikes.sift(sample)
        came += [(round(one.time / period), one.wrenches["hand"][0]) for one in (*held, now) if one.wrenches]
    return came, list(spikes.suspicions)


@pytest.mark.parametrize("lasts", range(1, LASTS + 1))
def test_what_returns_is_left_out(lasts):
    forces = [0.0] * 10 + [100.0 * (1 + 1j**k).real + 500.0 * k for k in range(lasts)] + [0.0] * 10
    came, told = sifted(forces)
    assert came == [(k, 0.0) for k in range(len(forces)) if not 10 <= k < 10 + lasts]
    assert [(one.kind, one.where) for one in told] == [("jumps", "hand")]


@pytest.mark.parametrize("forces", [[0.0] * 5 + [200.0] * 9, [0.0] * 5 + [300.0 * k for k in range(1, 9)]])
def test_what_stays_or_goes_on_comes_whole(forces):
    came, told = sifted(forces)
    assert sorted(came) == list(enumerate(forces))
    assert not told


def test_sensors_that_are_slower_than_a_push_are_taken_as_they_are():
    forces = [0.0, 0.0, 200.0, 0.0, 0.0]
    assert sifted(forces, period=0.2) == (list(enumerate(forces)), [])


@ONLINE
@pytest.mark.parametrize("size", [1e3, 1e5])
def test_a_spike_teaches_nothing(which, size):
    """As if that sample had brought no wrench; nor is a load told, or a unit."""
    kind, noise = KINDS[which]
    log, found = run(), []
    arm = log.arms["hand"]
    for value in (size, np.nan):
        wrench = arm.wrench.copy()
        wrench[300] = wrench[300] + [value, 0, 0, 0, 0, 0]
        found.append(
            replay(replace(log, arms={"hand": ArmLog(arm.contact, wrench)}), kind(GUESS, ["hand"], noise=noise))
        )
    np.testing.assert_allclose(*[one.last.model_parameters for one in found], rtol=1e-9)
    assert [(one.kind, one.where) for one in found[0].last.suspicions] == [("jumps", "hand")]
    assert found[0].last.health == found[1].last.health


@pytest.mark.parametrize(("online", "noise"), [(CartFilter, NOISY), (CartFilter, EXACT), (RegressorEstimator, NOISY)])
def test_a_push_that_steps_is_learned_from_as_without_the_look(online, noise, monkeypatch):
    """But for the parameters around which a row is linear, which are a sample older."""
    log, _ = simulate(PLANT, 6, duration=6.0, noise=(0.0004, 0.005, 0.3))
    arm = log.arms["hand"]
    step = np.where(log.time > 3.0, 60.0, 0.0)[:, None] * [1, 0, 0, 0, 0, 0]
    stepped, found = replace(log, arms={"hand": ArmLog(arm.contact, arm.wrench + step)}), []
    for sift in (WrenchSpikes.sift, lambda self, measurement: ([], measurement)):
        monkeypatch.setattr(WrenchSpikes, "sift", sift)
        found.append(replay(stepped, online(GUESS, ["hand"], noise=noise)).last)
    np.testing.assert_allclose(*[one.model_parameters for one in found], rtol=1e-5)
