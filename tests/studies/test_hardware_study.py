"""The hardware study: its bound by hand, its figures on made-up runs, and a short experiment."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.motion import Motion
from cartgrasp.studies import hardware
from cartgrasp.studies.findings import all_kept
from cartgrasp.studies.hardware import (
    CONTROL_PERIOD,
    EXPERIMENTS,
    PUSH_PULL,
    SENSOR_NOISE,
    STRAIGHT_RUN,
    WITH_CASTERS,
    Drive,
    Experiment,
    Outcome,
    attempt,
    mass_bound,
    reversal_times,
)
from cartgrasp.studies.hardware_report import (
    COLUMNS,
    REVERSAL_COLUMNS,
    claims,
    figure,
    findings,
    paper_claims,
    reversal_rows,
    rows,
)
from planning.references import PathReference, straight


def ideal(path):
    """A drive that follows its reference."""
    reference = PathReference(path)
    times = CONTROL_PERIOD * np.arange(round(reference.duration / CONTROL_PERIOD))
    followed = [reference.at(time) for time in times]
    return Drive(tuple(Motion(one.pose_sb, one.velocity) for one in followed), np.zeros((len(times), 6)))


def made_up(bias=0.0, scatter=1.0, told=1.0, casters=0.2):
    """Runs whose masses are off by `bias` and, in multiples of the bound, scatter and say they do; `casters` (kg) is
    what a reversal does to them."""
    random = np.random.default_rng(0)
    outcomes = []
    for experiment in EXPERIMENTS:
        time, bound, runs = np.arange(0.0, 12.0, 0.1), 0.4, 200
        off = random.permutation(np.sort(random.standard_normal(runs)))
        off = bias + scatter * bound * (off - off.mean()) / off.std(ddof=1)
        shove = np.where(time > 6.0, casters if experiment.casters == WITH_CASTERS else 2.0, 0.0) * (
            experiment.name == "E5"
        )
        mass = experiment.mass + off[:, None] + shove
        errors = np.column_stack([off, *[0.01 * np.ones(runs)] * 3])
        std = np.full(mass.shape, told * bound)
        outcomes.append(Outcome(experiment, time, mass, std, errors, bound, np.array([6.0])))
    return outcomes


def test_bound_by_hand(monkeypatch):
    """On a straight run a force is m u' + c u + k, and c and k as good as unknown; noise of the motion costs some."""
    driven = ideal(STRAIGHT_RUN)
    u = np.array([motion.velocity[0] for motion in driven.motions])
    middle, a = (u[1:] + u[:-1]) / 2, np.diff(u) / CONTROL_PERIOD
    X = np.column_stack([a, middle, np.ones_like(a)])[middle >= 0.05]
    by_hand = SENSOR_NOISE.force * np.sqrt(np.linalg.inv(X.T @ X)[0, 0])
    whole = mass_bound(Experiment("run", 25.0, STRAIGHT_RUN), driven)
    exact = dict.fromkeys(("position", "heading", "linear_velocity", "yaw_rate"), 1e-7)
    monkeypatch.setattr(hardware, "SENSOR_NOISE", replace(SENSOR_NOISE, **exact))
    assert mass_bound(Experiment("run", 25.0, STRAIGHT_RUN), driven) == pytest.approx(by_hand, rel=0.01)
    assert by_hand < whole < 1.1 * by_hand


def test_reversals():
    """Four times forth and back: seven reversals, none of them a stop."""
    times = reversal_times(ideal(PUSH_PULL))
    assert len(times) == 7
    assert np.allclose(np.diff(times), 7.55, atol=0.011)
    assert len(reversal_times(ideal(STRAIGHT_RUN))) == 0


def test_figures():
    outcomes = made_up()
    assert all_kept(claims(outcomes)), [claim for claim in claims(outcomes) if not claim.holds]
    assert {len(row) for row in rows(outcomes)} == {len(COLUMNS)}
    assert {len(row) for row in reversal_rows(outcomes)} == {len(REVERSAL_COLUMNS)}
    assert [row[2] for row in reversal_rows(outcomes)] == ["+0.20", "+2.00"]
    assert all(claim.holds for claim in paper_claims(outcomes))
    assert len(figure(outcomes).axes) == len(EXPERIMENTS)
    assert findings(outcomes).document["experiments"][4]["reversals"][0]["mean_error"] == pytest.approx(0.2)


@pytest.mark.parametrize("wrong", [{"bias": 0.2}, {"scatter": 1.3}, {"told": 0.5}, {"told": 2.0}, {"casters": 0.7}])
def test_claims_can_fail(wrong):
    assert not all_kept(claims(made_up(**wrong)))


def test_a_short_experiment():
    """MuJoCo's cart, two recordings: masses are told to within what is said of them."""
    found = attempt(Experiment("short", 25.0, straight(1.5, 0.5, 0.5)), seeds=(1, 2))
    assert found.mass.shape == found.std.shape == (2, len(found.time))
    assert (np.abs(found.errors[:, 0]) < 4 * found.std[:, -1]).all()
    assert (found.std[:, -1] < 2.0).all()
    assert found.mass[0, -1] != found.mass[1, -1]
