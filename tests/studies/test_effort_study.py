"""The study of effort: its comparison at equal error on known laws, its figures by hand, and one short drive."""

from dataclasses import replace
from itertools import product
from math import inf, log

import numpy as np
import pytest

from cartgrasp.studies import effort, effort_report
from cartgrasp.studies.effort import (
    BEST_PLACE,
    CHOSEN_PLACE,
    FIRST_GUESS,
    GRIP_CHOICES,
    GRIPS,
    KNOWLEDGE,
    LEARNED,
    MIDDLE_PLACE,
    USUAL_LOAD_KEPT,
    WRONG_GUESS_KEPT,
    Comparison,
    Job,
    RunCost,
    arms,
    at_error,
    best_by_statics,
    best_grips,
    cart,
    drive,
    scenario,
)
from planning.references import chain, pause, speed_change


@pytest.mark.parametrize("power", [-0.7, -1.5, -2.0])
def test_what_is_paid_at_an_error(power):
    """Where error and force are powers of the gains, both are found exactly between two tries."""
    tried = []

    def law(gain):
        tried.append(gain)
        return RunCost(gain, 0.02 * gain**power, *[10.0 * gain**0.3] * 5)

    paid = at_error(0.005, law)
    gain = 4.0 ** (-1 / power)
    assert paid.is_equal(0.005)
    assert (paid.gain, paid.force) == pytest.approx((gain, 10 * gain**0.3), rel=0.03)
    assert len(tried) <= effort.MAX_GAIN_TRIES


def test_errors_that_no_gain_has():
    assert at_error(0.001, lambda gain: RunCost(gain, 0.5 / gain, *[1.0] * 5)).gain == effort.GAIN_RANGE[1]
    assert at_error(0.001, lambda gain: RunCost(gain, inf)).error == inf


def test_best_places_answer_the_offset():
    """One hand goes to where the CoM is, and what it saves by statics is bounded: the force along stays."""
    assert best_grips(cart(40.0, 0.2), arms(1)) == [0.2]
    assert best_by_statics(0.0, 1) == (1.0, 1.0)
    force, paid = best_by_statics(0.2, 1)
    assert 0.94 < force < 0.97
    assert 0.8 < paid < 0.87


def test_a_drive(monkeypatch):
    """A start: rms and largest of what the hands gave, by our own sum; where a guess is kept nothing is learned."""
    monkeypatch.setattr(effort, "PATH", chain(speed_change(0.3), pause(0.2), speed_change(-0.3)))
    job = Job(40.0, 0.1, 2, 3)
    paid = drive(job, LEARNED, MIDDLE_PLACE, 1.0)
    record = scenario(cart(40.0, 0.1), arms(2, [0.15, -0.15]), LEARNED, MIDDLE_PLACE, 1.0, 3).run()
    forces = np.array([record.wrenches[arm][:, :3] for arm in GRIPS[2]])
    assert paid.force == pytest.approx(np.sqrt((forces**2).sum() / len(record.time)))
    assert paid.largest_force == pytest.approx(np.linalg.norm(forces, axis=2).max())
    assert paid.error == pytest.approx(np.sqrt((record.tracking_error**2).mean()))
    kept = scenario(cart(40.0, 0.1), arms(2), USUAL_LOAD_KEPT, CHOSEN_PLACE, 2.0, 3)
    assert (kept.estimation, kept.guess.inertia.mass, kept.gains.velocity) == (FIRST_GUESS, 40.0, 10.0)


def test_its_figures():
    """Three trucks, of which a wrong guess has the error of one, falls with one, and is far off with one."""
    first = RunCost(1.0, 0.002, 10.0, 2.0, 20.0, 4.0, 140.0)
    paid = dict.fromkeys(product(KNOWLEDGE, GRIP_CHOICES), first)
    paid[LEARNED, BEST_PLACE] = replace(first, force=9.8, effort=100.0)
    paid[LEARNED, CHOSEN_PLACE] = replace(first, force=7.9, effort=120.0, regrasps=1)
    found = [
        Comparison(Job(15.0, 0.0, 1, 0), 0.002, paid),
        Comparison(Job(80.0, 0.2, 2, 0), 0.002, {**paid, (WRONG_GUESS_KEPT, MIDDLE_PLACE): RunCost(1.0, inf)}),
        Comparison(
            Job(80.0, 0.1, 2, 0),
            0.002,
            {**paid, (WRONG_GUESS_KEPT, MIDDLE_PLACE): replace(first, gain=8.0, error=0.02, force=12.0)},
        ),
    ]
    ways, trucks, statics, _ = (section.rows for section in effort_report.findings(found).sections)
    assert ways[0] == ("wrong guess kept, middle", "1 of 3", "1.00", *["1.00"] * 5, "10.00×", "1")
    assert trucks[0][2] == "10.0, 2.00 (20, 4.0)"
    assert (trucks[1][2], trucks[2][2]) == ("falls", "[20.0 mm]")
    assert len(statics) == 4
    holds = {claim.claim.split(":")[0]: claim.holds for claim in effort_report.claims(found)}
    assert holds["chosen places"]
    assert not holds["20 % less rms force than a guess kept that has its error"]
    assert effort_report.as_dict(found[0])["paid"]["learned, best"]["effort"] == 100.0
    assert len(effort_report.figure(found).axes) == 4
    assert log(found[0].share("force", (LEARNED, BEST_PLACE), (LEARNED, MIDDLE_PLACE))) == pytest.approx(log(0.98))
