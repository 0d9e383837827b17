"""The study of robust margins: a first stop, seen by our own eyes, and (long) all of its claims."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.studies.findings import all_kept
from cartgrasp.studies.robust_margins import LIMIT_TOLERANCE, PRIOR, believed, drawn, drive, run_seeds
from cartgrasp.studies.robust_margins_report import (
    COLUMNS,
    as_dict,
    claims,
    figure,
    laps,
    rows,
)


@pytest.fixture(scope="module")
def stop():
    """The first, of a cart whose load lies farther back than believed."""
    return drive(5, duration=0.8)


def test_a_first_stop(stop):
    """Its casters really lift off their least load without margins, and don't with them, at a price."""
    assert drawn(5).inertia.com[0] < believed().inertia.com[0] - PRIOR.com
    hard = stop.is_hard
    assert hard.sum() > 10
    assert (stop.room[hard, 0] < -LIMIT_TOLERANCE).all()
    assert (stop.room[hard, 1] > 0).all()
    assert np.abs(stop.room[hard, 2]).max() < LIMIT_TOLERANCE, "the known cart is planned to its limit"
    assert stop.efforts[hard, 1].mean() > 1.1 * stop.efforts[hard, 2].mean()
    assert stop.reserve[hard].min() > 10.0
    assert set(stop.statuses.ravel()) <= {"optimal", "relaxed"}
    assert stop.com_x_std[-1] > 0.5 * PRIOR.com, "a straight line does not teach it"


def test_its_figures(stop):
    """The same stop six times over fills the laps; what is said of them is counted here by hand."""
    again = {name: np.concatenate([part] * 6) for name, part in vars(stop).items() if name != "seed"}
    run = replace(stop, **again | {"time": 0.01 * np.arange(480)})
    hard = [i for i, at_limit in enumerate(stop.at_limit) if at_limit[0] or at_limit[2]]
    whole = laps([run])[0]  # 80 ticks and 20 more, before it brakes
    assert whole.reserve == pytest.approx(max(stop.reserve[i] for i in hard))
    assert whole.broken.tolist() == [1.0, 0.0, 0.0]
    paid = sum(run.efforts[:100, 1]) / sum(run.efforts[:100, 2]) - 1
    assert whole.paid == pytest.approx(paid)
    assert [row[0] for row in rows([run])] == ["1 straight", "2 straight", "3 curved", "4 curved"]
    assert {len(row) for row in rows([run])} == {len(COLUMNS)}
    kept = {claim.what: claim.holds for claim in claims([run])}
    assert kept == {"99 % margins": True, "no margins": True, "learning": False, "effort": False, "proof": True}
    assert as_dict(run)["laps"][0]["broken"] == {"no margins": 1.0, "99 % margins": 0.0, "cart known": 0.0}
    assert len(figure([run, run]).axes) == 3


@pytest.mark.prove
def test_every_claim_is_kept():
    runs = run_seeds(range(20, 28))
    kept = claims(runs)
    assert all_kept(kept), [claim for claim in kept if not claim.holds]
