"""Blocks that are taken in once more when more is known."""

import numpy as np
import pytest

from cartgrasp.studies.estimators import HANDS, SENSORS, Job, drive, filter_noise, guess, truth
from estimation import CartFilter, Prior, RegressorEstimator
from estimation.online.kernels.filtered_row import FilteredRow
from estimation.online.regressor import parameter_learner
from estimation.online.regressor.parameter_learner import ParameterLearner
from estimation.online.regressor.second_look import blur
from estimation.physical_set import PhysicalSet


def drawn_row(random, p=3, f=2):
    """Of exact motion."""
    root = random.standard_normal((f, f))
    noise = root @ root.T + np.eye(f)
    still = np.eye(f) * 1e-6
    slopes = np.column_stack([random.standard_normal((f, p)), np.zeros(f)])
    return FilteredRow(
        random.standard_normal(f),
        slopes,
        np.zeros((f, f)),
        0.7,
        noise,
        still,
        still,
        np.zeros(p + 1),
        0.2 * noise,
        np.zeros((f, f)),
    )


def test_blur():
    """Curvature of three times the noise, in some direction."""
    row = drawn_row(np.random.default_rng(1))
    assert blur(row._replace(curvature=3.0 * row.noise)) == pytest.approx(3.0)
    assert blur(row) == 0.0


def test_a_second_look_is_what_a_first_would_have_been(monkeypatch):
    """Rows around one guess and what was first believed of it, blurred or not up to 1.5 s: taken in later, in their
    order, they say the same."""
    log, noise = drive(Job("straight", "usual", 2), 3.0), filter_noise(SENSORS["usual"])
    monkeypatch.setattr(PhysicalSet, "holds", lambda *_: False)
    monkeypatch.setattr(PhysicalSet, "nearest", lambda *_: guess().parameters)
    work_out, told, first = ParameterLearner._worked_out, [], Prior().covariance(guess())
    root = np.sqrt(first)
    for blurred_until in (0.0, 1.5):

        def worked_out(self, block, until=blurred_until):
            believed, self.covariance, self._spread = (self.covariance, self._spread), first, root
            row = work_out(self, block)
            self.covariance, self._spread = believed
            return row._replace(curvature=(self.time < until) * row.noise)

        monkeypatch.setattr(ParameterLearner, "_worked_out", worked_out)
        online = RegressorEstimator(guess(), list(HANDS), noise=noise)
        for measurement in log.measurements():
            online.update(measurement)
        told.append(online.belief)
    assert told[1].mean == pytest.approx(told[0].mean, rel=1e-9)
    assert told[1].covariance == pytest.approx(told[0].covariance, rel=1e-9)


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
