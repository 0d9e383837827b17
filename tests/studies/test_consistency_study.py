"""The study of consistency: its figures by hand, a run of it, and (long) its claims."""

import numpy as np
import pytest
from scipy.stats import chi2

from cartgrasp.studies.consistency import (
    MATCHED_MODEL,
    MODELS,
    MOTION_NEES,
    PRIOR,
    SQUARES,
    WRONG_MODEL,
    Trace,
    drawn_cart,
    run_seeds,
    trace_both,
)
from cartgrasp.studies.consistency_report import (
    COLUMNS,
    SCORE_COLUMNS,
    claims,
    consistency,
    figure,
    findings,
    rows,
    score_rows,
)
from cartgrasp.studies.estimators import guess
from cartgrasp.studies.findings import all_kept

DIMENSIONS = dict(zip(SQUARES, (5, 7, 3, 2), strict=True))


def drawn_traces(n, wrong=3.0, seed=1):
    """Squares that are chi-squared; where the model is wrong, of errors `wrong` times as large."""
    random = np.random.default_rng(seed)
    told = []
    for _ in range(n):
        scale = {MATCHED_MODEL: 1.0, WRONG_MODEL: wrong**2}
        told.append(
            {
                model: Trace(
                    {name: scale[model] * random.chisquare(size, 400) for name, size in DIMENSIONS.items()},
                    DIMENSIONS,
                    random.standard_normal((400, 7 if model == MATCHED_MODEL else 6)),
                )
                for model in MODELS
            }
        )
    return told


def test_figures():
    runs = drawn_traces(30)
    found = consistency(runs, MATCHED_MODEL, MOTION_NEES)
    assert chi2.cdf(150 * found.low, 150) == pytest.approx(0.025)
    assert chi2.cdf(150 * found.high, 150) == pytest.approx(0.975)
    assert found.mean[7] == pytest.approx(np.mean([run[MATCHED_MODEL].squares[MOTION_NEES][7] for run in runs]) / 5)
    assert found.inside == pytest.approx(0.95, abs=0.04)
    assert {len(row) for row in rows(runs)} == {len(COLUMNS)}
    assert {len(row) for row in score_rows(runs)} == {len(SCORE_COLUMNS)}
    assert len(figure(runs).axes) == len(SQUARES) * len(MODELS)
    assert len(findings(runs).document["squares"]) == len(SQUARES) * len(MODELS)


def test_claims_can_fail():
    assert all_kept(claims(drawn_traces(30)))
    assert not all_kept(claims(drawn_traces(30, wrong=1.0)))
    timid = drawn_traces(30)
    for run in timid:
        run[MATCHED_MODEL].squares[MOTION_NEES] *= 0.5
    assert [claim.what for claim in claims(timid) if not claim.holds] == [MOTION_NEES]


def test_carts_are_drawn_from_the_prior():
    """Whitened by the prior's covariance, they are standard normal (Kolmogorov's 1e-6 bound of their squares)."""
    wrong = np.array([drawn_cart(seed).parameters for seed in range(400)]) - guess().parameters
    squares = np.sort((wrong * np.linalg.solve(PRIOR.covariance(guess()), wrong.T).T).sum(axis=1))
    distance = np.abs(chi2.cdf(squares, 7) - np.arange(400) / 400).max()
    assert distance < np.sqrt(np.log(2e6) / 800)


def test_a_run():
    """Squares whose chance is one in a thousand are rare with the right model, and the rule with the wrong one."""
    runs = [trace_both(seed) for seed in (3,)]
    for name, size in DIMENSIONS.items():
        seen = np.array([run[MATCHED_MODEL].squares[name] for run in runs])
        assert (seen[np.isfinite(seen)] < chi2.ppf(0.9999, size)).mean() > 0.99
    assert all(run[WRONG_MODEL].squares["NEES of parameters"][-1] > chi2.ppf(0.9999, 6) for run in runs)


@pytest.mark.prove
def test_every_claim_is_kept():
    kept = claims(run_seeds(range(500), workers=2))
    assert all_kept(kept), [claim for claim in kept if not claim.holds]
