"""Fits that noise in the motion does not pull, that are refused where they foretell worse, or are contradicted."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate
from estimation.discrepancy.findings import held_out, refusal
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances
from estimation.whole_log.agreement import disagreements
from estimation.whole_log.identification import identify

RAIL = RollingConstraints(0.0, no_rotation=True)


def pushed(mass, noise, seed, duration=40.0, wrong=0.0):
    """A cart on a rail, pushed by a sum of sines without drag: positions in closed form, poses alone. `wrong` (N) is a
    force in proportion to the acceleration that nobody records, in the second half."""
    random, time = np.random.default_rng(seed), 0.01 * np.arange(round(duration * 100))
    rates, sizes = np.array([1.1, 2.3, 3.7]), np.array([0.8, 0.6, 0.4])
    acceleration = (sizes * np.sin(np.outer(time, rates))).sum(axis=1)
    x = -(sizes / rates**2 * np.sin(np.outer(time, rates))).sum(axis=1) + (sizes / rates).sum() * time
    wrench = np.zeros((len(time), 6))
    wrench[:, 0] = mass * acceleration + wrong * acceleration * (time > duration / 2)
    wrench[:, 0] += 0.5 * random.standard_normal(len(time))
    pose = np.zeros((len(time), 3))
    pose[:, 0] = x + noise * random.standard_normal(len(time))
    pose[:, 2] = 1e-6 * random.standard_normal(len(time))
    return RunLog(time, pose, None, {"hand": ArmLog(np.zeros((len(time), 3)), wrench)})


def guess(mass):
    return CartModel(Inertia(mass, (0.0, 0.0), 1.0), RAIL, (ViscousDrag(1.0, 0.0),))


@pytest.mark.long
def test_noise_in_poses_pulls_no_mass():
    """Over 5 logs, whose poses are noisy to 4 mm: the mean is within three of its own deviations."""
    found = [identify([pushed(30.0, 0.004, seed)], guess(20.0)).parameters["mass"] for seed in range(5)]
    off = np.array([one.value for one in found]) - 30.0
    assert abs(off.mean()) < 3 * np.hypot(off.std(ddof=1), np.mean([one.std for one in found])) / 5**0.5
    assert abs(off.mean()) < 0.6


@pytest.mark.parametrize("share", [1 / 3, 1.0, 3.0])
def test_the_first_guess_does_not_matter(share):
    mass = identify([pushed(30.0, 0.0005, 1)], guess(share * 30.0)).parameters["mass"]
    assert mass.identifiable
    assert mass.value == pytest.approx(30.0, abs=max(4 * mass.std, 0.15))


@pytest.mark.long
def test_a_turned_round_sensor_teaches_nothing():
    """Were the pushes as they are recorded, the cart would have a mass below 0: no mass is taught, and none is at a
    bound."""
    log = pushed(30.0, 0.0005, 2)
    hand = log.arms["hand"]
    found = identify([replace(log, arms={"hand": ArmLog(hand.contact, -hand.wrench)})], guess(30.0))
    assert not found.parameters["mass"].identifiable


@pytest.mark.long
def test_a_long_hole_makes_two_stretches_of_a_log():
    log = pushed(30.0, 0.0005, 3)
    later = log.time + np.where(log.time > 20.0, 1e7, 0.0)
    mass = identify([replace(log, time=later)], guess(20.0)).parameters["mass"]
    assert mass.value == pytest.approx(30.0, abs=max(4 * mass.std, 0.15))


@pytest.mark.parametrize(
    ("first", "fitted", "is_refused"), [(30.0, 60.0, True), (60.0, 30.0, False), (30.0, 30.0, False)]
)
def test_a_fit_that_foretells_worse_is_refused(monkeypatch, first, fitted, is_refused):
    """Of 30 kg, believed to be `first` and fitted as `fitted`."""
    model = Model.started([Balances.of(pushed(30.0, 0.0005, 4), guess(first))], guess(first))
    monkeypatch.setattr(held_out, "fold_carts", lambda _: [guess(fitted)] * 3)
    words = refusal.refused(model, guess(first))
    assert bool(words) == is_refused
    assert ("the first guess stays" in words) == is_refused


def test_a_refused_fit_leaves_the_first_guess(monkeypatch):
    monkeypatch.setattr("estimation.whole_log.identification.refused", lambda *_: "it is worse")
    found = identify([pushed(30.0, 0.0005, 4, duration=10.0)], guess(20.0))
    mass = found.parameters["mass"]
    assert (mass.value, mass.std, mass.identifiable) == (20.0, pytest.approx(8.0), False)
    assert found.cart().inertia.mass == pytest.approx(20.0)
    assert found.logs[0].words == ("it is worse",)


def estimate(value, std, is_taught=True):
    return ParameterEstimate(value, std, "kg", is_taught)


@pytest.mark.parametrize(
    ("whole", "online", "told"),
    [
        (estimate(20.0, 0.1), estimate(24.0, 0.1), True),
        (estimate(20.0, 0.1), estimate(20.6, 0.1), False),  # 3 %
        (estimate(20.0, 2.0), estimate(24.0, 0.1), False),  # 2 deviations
        (estimate(20.0, 0.1, is_taught=False), estimate(24.0, 0.1, is_taught=False), False),
        (estimate(20.0, 0.1, is_taught=False), estimate(24.0, 0.1), True),
    ],
)
def test_a_disagreement_is_told(whole, online, told):
    words = disagreements({"mass": whole}, {"mass": online}, "ok")
    assert bool(words) == told
    assert all("20 ± " in one and "24 ± 0.1 kg" in one for one in words)


def test_what_is_no_number_confirms_nothing():
    sound, lost = ({"mass": ParameterEstimate(value, 0.1, "kg", value > 0.0)} for value in (24.0, math.nan))
    for whole, online in ((sound, lost), (lost, sound)):
        (words,) = disagreements(whole, online, "diverged")
        assert "nan" in words
