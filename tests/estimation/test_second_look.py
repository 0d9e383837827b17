"""Blocks that are taken in by two powers of their likelihood."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.studies.estimators import HANDS, SENSORS, Job, drive, filter_noise, guess, truth
from estimation import CartFilter
from estimation.gaussian import Gaussian
from estimation.regressor import parameter_learner, regression_belief
from estimation.regressor.filtered_row import FilteredRow
from estimation.regressor.second_look import blur, left_after, rest_of


def drawn_row(random, p=3, f=2):
    """Of exact motion."""
    root = random.standard_normal((f, f))
    noise = root @ root.T + np.eye(f)
    still = np.eye(f) * 1e-6
    slopes = np.column_stack([random.standard_normal((f, p)), np.zeros(f)])
    return FilteredRow(random.standard_normal(f), slopes, np.zeros((f, f)), 0.7, noise, still, still, np.zeros(p + 1))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_two_powers_make_the_whole(share, monkeypatch):
    """Where rows are linear it does not matter when a likelihood is taken in."""
    monkeypatch.setattr(regression_belief, "KEPT", 1.0)
    random = np.random.default_rng(int(10 * share))
    first, at = Gaussian(np.zeros(3), np.diag([1.0, 4.0, 0.3])), np.zeros(3)
    at_once, later = (regression_belief.RegressionBelief(np.arange(3), first, 2) for _ in range(2))
    rows = [drawn_row(random) for _ in range(4)]
    for row in rows:
        at_once.absorb(row, at)
        later.absorb(replace(row, noise=row.noise / share), at)
    for row in rows:
        later.absorb_rest(rest_of(row, np.zeros((2, 2)), 1.0 - share), at)
    assert later.parameters.mean == pytest.approx(at_once.parameters.mean, abs=1e-9)
    assert later.parameters.covariance == pytest.approx(at_once.parameters.covariance, abs=1e-9)


def test_exponents():
    """A curvature of three times the noise lets a quarter through."""
    row = drawn_row(np.random.default_rng(1))
    assert blur(row, 3.0 * row.noise) == pytest.approx(3.0)
    assert left_after(3.0) == pytest.approx(0.75)


def test_the_first_push_is_not_lost(monkeypatch):
    """With nothing known of load and friction, a straight push and pull tells the mass better, and as honestly."""
    log, noise = drive(Job("straight", "usual", 2), 6.0), filter_noise(SENSORS["usual"])
    told = {}
    for name, blurred in (("again", parameter_learner.BLURRED), ("once", np.inf)):
        monkeypatch.setattr(parameter_learner, "BLURRED", blurred)
        online = CartFilter(guess(), list(HANDS), noise=noise)
        for measurement in log.measurements():
            told[name] = online.update(measurement).parameters["mass"]
    assert told["again"].std < 0.97 * told["once"].std
    assert abs(told["again"].value - truth().inertia.mass) < 3 * told["again"].std
