"""The study of estimators: its logs and figures by hand, and (long) its claims."""

import numpy as np
import pytest

from cartgrasp.first_guess import PHYSICAL_NAMES as PHYSICAL
from cartgrasp.motion import ParameterEstimate
from cartgrasp.studies.estimators import PATHS, SENSOR_SETS, WAYS, Answer, Job, Trial, drive_cart, run_seeds, truth
from cartgrasp.studies.estimators_report import (
    BETTER_COLUMNS,
    COLUMNS,
    MOTION_COLUMNS,
    as_dict,
    better_rows,
    claims,
    findings,
    motion_rows,
    rows,
    score,
)
from cartgrasp.studies.findings import all_kept

TRUE = (24.0, 0.28, 0.06, 2.2)


def drive(job, duration):
    return drive_cart(truth(), job, duration).log


def made_up(errors):
    """Trials with two seeds each, whose estimates are off by what `errors(way, seed)` says, in standard deviations of
    a hundredth of the true values."""
    trials = []
    for path in PATHS:
        for sensors in SENSOR_SETS:
            for seed in (0, 1):
                answers = {}
                for way in WAYS:
                    off = 1 + 0.01 * errors(way, seed)
                    found = {
                        name: ParameterEstimate(value * off, 0.01 * value, "", True)
                        for name, value in zip(PHYSICAL, TRUE, strict=True)
                    }
                    motion = (0.001, 0.002) if way == "filter" else (0.002, 0.003)
                    answers[way] = Answer(found, "ok", 1e-3 if way == "filter" else 2e-4, motion)
                trials.append(Trial(Job(path, sensors, seed), answers))
    return trials


def test_what_is_driven():
    """The wrenches of a quiet log move the true cart as recorded: momentum along a straight line."""
    log = drive(Job("straight", "quiet", 1), duration=1.2)
    force = sum(arm.wrench[:, 0] for arm in log.arms.values())
    u = log.velocity[:, 0]
    impulse = 0.01 * np.sum(force[:-1] - 3.0 * u[:-1] - 0.015 * 24.0 * 9.81 * np.tanh(u[:-1] / 0.002))
    assert 24.0 * u[-1] == pytest.approx(impulse, abs=0.3)
    assert u[-1] == pytest.approx(0.6, abs=0.03)
    assert drive(Job("straight", "poses alone", 1), duration=0.1).velocity is None
    assert np.array_equal(drive(Job("curves", "usual", 3), 0.1).pose, drive(Job("curves", "usual", 3), 0.1).pose)


def test_figures():
    trials = made_up(lambda way, seed: (0.6 if way == "regressor" else 1.2) * (1 if seed else -1))
    found = score(trials[:2], "regressor")
    assert found.errors == pytest.approx(0.006 * np.array(TRUE))
    assert found.bias == pytest.approx(np.zeros(4))
    assert found.z == pytest.approx(0.6)
    assert found.motion == pytest.approx([0.002, 0.003])
    assert found.spread == pytest.approx(0.006 * np.array(TRUE))
    assert {len(row) for row in rows(trials)} == {len(COLUMNS)}
    assert {row[2:4] for row in motion_rows(trials) if row[1] == "regressor"} == {("2", "3")}
    assert {len(row) for row in motion_rows(trials)} == {len(MOTION_COLUMNS)}
    better = better_rows(trials)
    assert {len(row) for row in better} == {len(BETTER_COLUMNS)}
    assert {row[2:] for row in better} == {(*["2.00"] * 4, "0.50", "0.67", "regressor", "filter")}
    assert all_kept(claims(trials))
    assert [section.title[:6] for section in findings(trials).sections] == ["When w", "Claims", "Rms er", "Rms er"]
    assert as_dict(trials[0])["answers"]["identify"]["parameters"]["mass"]["std"] == pytest.approx(0.24)
    assert truth().inertia.mass == TRUE[0]


@pytest.mark.parametrize("off", [3.0, 0.0])
def test_claims_can_fail(off):
    """Too heavy every time, or right every time with deviations that are too large."""
    wrong = [claim for claim in claims(made_up(lambda way, seed: off)) if claim.promised and not claim.holds]
    assert wrong
    assert all_kept(claims(made_up(lambda way, seed: 1.0 if seed else -1.0)))


@pytest.mark.prove
def test_every_claim_is_kept():
    kept = claims(run_seeds(range(50, 54)))
    assert all_kept(kept), [claim for claim in kept if not claim.holds]
