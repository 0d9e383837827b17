"""An operator's stop in mid-path: the cart comes to rest along it, is held, and goes on from there."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.effects import FloorSlope
from cartgrasp.motion import Measurement
from planning import Controller, RegraspTimes

from .driving import ticks
from .test_caution import GUESS, PATH, TRUTH, arms
from .test_controller import Later
from .test_controller import arms as two_places

TIMES = RegraspTimes(speed=0.5, unload=0.3, take_hold=0.2, load=0.3)


def made(**options):
    return Controller(GUESS, arms(), PATH, **options)


def told_at(controller, times, truth=TRUTH, duration=12.0):
    """Each tick of a controller of which methods are called at times (s)."""
    driven, due = [], sorted(times.items())
    for tick in ticks(controller, truth, duration):
        driven.append(tick)
        while due and due[0][0] <= tick.step.time:
            getattr(controller, due.pop(0)[1])()
    return driven


@pytest.mark.some(1)
@pytest.mark.parametrize("options", [{}, {"caution": None}, {"regrasp": None}])
def test_it_comes_to_rest_along_its_path_and_goes_on(options):
    controller = made(**options)
    driven = told_at(controller, {2.0: "stop", 6.0: "resume"})
    speeds = np.array([tick.motion.velocity[0] for tick in driven])
    assert speeds[195] > 0.4
    assert np.abs(speeds[420:600]).max() < 0.02
    assert "stops along its path, as it was told" in driven[500].step.words
    assert "stops" not in driven[800].step.words
    assert speeds[700:].max() > 0.4
    off = [np.linalg.norm((tick.motion.pose_sb - tick.step.reference.pose_sb)[:2]) for tick in driven]
    assert max(off) < 0.05
    rates = [tick.step.reference.acceleration[0] for tick in driven[200:420]]
    assert -0.35 < min(rates) < -0.2  # 0.5/s of 0.6 m/s: no harder than it slows for health
    along = [tick.step.reference.pose_sb[0] for tick in driven]
    assert np.diff(along).min() > -1e-9


def test_it_is_held_on_a_slope():
    driven = told_at(made(), {2.0: "stop"}, TRUTH.with_effect(FloorSlope(0.02, 0.0)))
    assert np.linalg.norm((driven[-1].motion.pose_sb - driven[500].motion.pose_sb)[:2]) < 0.02


def test_no_further_hand_lets_go():
    """One that is on its way takes hold where it was to go; the other stays until the cart goes on."""
    held = two_places()
    first, second = ({arm.name: arm.contacts.points[i] for arm in held} for i in (0, 1))
    controller = Controller(GUESS, held, PATH, contacts=Later(held, 1.8), regrasp=TIMES)
    driven = told_at(controller, {2.0: "stop", 7.0: "resume"})
    assert driven[200].step.placed["left"].phase != "holds"
    stopped = driven[690].step
    assert stopped.contacts["left"].tolist() == list(second["left"])
    assert stopped.contacts["right"].tolist() == list(first["right"])
    assert stopped.words.startswith("holds left at (0.10, 0.20): stopped; holds right at (−0.25, −0.20): stopped")
    assert driven[-1].step.contacts["right"].tolist() == list(second["right"])


def test_one_that_was_told_before_its_first_step_does_not_begin():
    controller = made()
    controller.stop()
    driven = told_at(controller, {2.0: "resume"}, duration=5.0)
    assert np.abs([tick.motion.velocity[0] for tick in driven[:200]]).max() < 0.01
    assert driven[-1].motion.velocity[0] > 0.3


def test_it_is_stopped_when_it_is_restored(tmp_path):
    controller = made()
    last = told_at(controller, {2.0: "stop"}, duration=4.5)[-1]
    again = Controller.restored(controller.save(tmp_path / "controller.yaml"), arms(), PATH)
    assert again.is_stopped
    velocity = np.append(last.motion.velocity[0], [0.0, 0.0])
    step = again.step(Measurement(last.step.time + 0.01, last.motion.pose_sb, velocity))
    assert not step.reference.velocity.any()
    assert "as it was told" in step.words
    again.resume()
    again.save(tmp_path / "on.yaml")
    assert "stopped" not in (tmp_path / "on.yaml").read_text()
