"""The excitation study: what its references can teach, a short drive, and (long) all of its claims."""

import numpy as np
import pytest

from cartgrasp.roles import ContactQuery
from cartgrasp.studies.excitation import (
    ALLOWANCES,
    E_MOTION,
    FIXED_WAY,
    PERIODIC_WAY,
    WAYS,
    Drive,
    drive,
    excitation,
    run_seeds,
)
from cartgrasp.studies.excitation_report import COLUMNS, as_dict, bounds, claims, figure, rows
from cartgrasp.studies.findings import all_kept


def test_what_the_references_can_teach():
    """By the bounds alone: a lever arm less halves the noise on the CoM; the weave teaches every parameter more."""
    foretold = {way: bounds(way) for way in (FIXED_WAY, PERIODIC_WAY, E_MOTION)}
    assert foretold[PERIODIC_WAY][1] < 0.6 * foretold[FIXED_WAY][1]
    assert foretold[PERIODIC_WAY][0] == pytest.approx(foretold[FIXED_WAY][0], rel=0.01), "mass needs no lever"
    assert (foretold[E_MOTION] < np.minimum(foretold[PERIODIC_WAY], foretold[FIXED_WAY])).all()
    for window in excitation(ALLOWANCES[E_MOTION]).windows:
        assert window.effort <= window.least_effort + ALLOWANCES[E_MOTION].effort + 1e-6
        assert window.after <= window.before


def test_a_short_drive_holds_where_it_was_planned():
    record = drive(E_MOTION, seed=1, duration=5.5)
    plan = excitation(ALLOWANCES[E_MOTION])
    assert set(record.statuses) == {"optimal"}
    assert record.tracking_error[record.time > 1.0].max() < 0.03
    for i in (50, 350, 549):
        expected = plan.contacts(ContactQuery(float(record.time[i]), np.zeros(3))).contacts
        for arm, log in record.log.arms.items():
            assert np.array_equal(log.contact[i], expected[arm])
    one = Drive(E_MOTION, (record,))
    weights, wrenches = np.array([1, 1, 1, 10, 10, 10]), record.wrenches
    paid = 0.01 * sum(float(weights @ w**2) for i in range(550) for w in (wrenches["left"][i], wrenches["right"][i]))
    assert one.effort[-1] == pytest.approx(paid)
    assert len(rows([one])[0]) == len(COLUMNS)
    assert as_dict(one)["way"] == E_MOTION
    assert len(figure([one]).axes) == 6


@pytest.mark.prove
def test_every_claim_is_kept():
    drives = run_seeds(range(50, 53))
    assert [d.way for d in drives] == list(WAYS)
    kept = claims(drives)
    assert all_kept(kept), [claim for claim in kept if not claim.holds]
