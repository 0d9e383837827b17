"""Judgements of answers that are made up, each with one fault or none; and the table of them."""

from __future__ import annotations

import math

import pytest

from benchmarks.measured import truths
from benchmarks.measured.at_a_bound import at_a_bound
from benchmarks.measured.judging import CRITERIA, Judgement
from benchmarks.measured.logs import LOGS, undeclared
from benchmarks.measured.running import COMMANDS, Answer, Outcome
from benchmarks.measured.table import section
from benchmarks.measured.truths import Interval
from cartgrasp.effects import KNOWN_EFFECTS

BY_NAME = {log.name: log for log in LOGS}
NOT_YET = {"end_stop", "learned_force"}
"""In the vocabulary, and perhaps not in KNOWN_EFFECTS."""
TWO_DEGREES_DOWN = -math.tan(math.radians(2.0))
(
    ENDED,
    FILTER,
    IDENTIFY,
    REPORT,
    MUST,
    WRONG,
    VALUES,
    BOUND,
    HEALTH,
    REFIT,
    AGREE,
    SAME,
) = CRITERIA


def parameters(mass, std=2.0, identifiable=True, **effects):
    told = {"mass": {"value": mass, "std": std, "unit": "kg", "identifiable": identifiable}}
    for name, value in effects.items():
        told[name.replace("__", ".")] = {"value": value, "std": 0.1, "unit": "", "identifiable": True}
    return told


def effect(name, probability=0.99, confusable=(), **values):
    told = {key: {"value": value, "std": std, "unit": ""} for key, (value, std) in values.items()}
    return {"name": name, "probability": probability, "parameters": told, "confusable_with": list(confusable)}


def report(*effects, mass=(105.0, 2.0), gap=(0.1, 0.05, 0.02, 0.01)):
    keys = ("before", "refitted", "after", "noise_floor")
    return {
        "verdict": "explained" if effects else "no_discrepancy",
        "effects": list(effects),
        "parameter_mismatch": {"mass": {"nominal": 1.0, "refitted": mass[0], "std": mass[1]}} if mass else {},
        "gap": dict(zip(keys, gap, strict=True)),
    }


ROLLS = effect("rolling_resistance", coefficient=(13.5 / (105 * 9.81), 0.001))


def judged(log, said, online=None, identified=None, health="ok", guess=110.0, base=None):
    """Where nothing else is given, both fits say the report's mass."""
    mass = said["parameter_mismatch"].get("mass", {"refitted": 0.5})["refitted"]
    own = parameters(mass, identifiable=bool(said["parameter_mismatch"]))
    answers = {
        "estimate": Answer({"parameters": online or own, "health": health}, seconds=3.0),
        "identify": Answer({"parameters": identified or own}, seconds=2.0),
        "discrepancy": Answer(said, seconds=8.0),
    }
    return Judgement(BY_NAME[log], Outcome(log, "as it is", guess, answers), base)


def test_what_is_right_has_no_fault():
    found = judged("wheelchair", report(ROLLS))
    assert found.faults == ()
    assert found.is_right
    assert found.criteria[SAME] is None
    assert sum(one is True for one in found.criteria.values()) == len(CRITERIA) - 1


@pytest.mark.parametrize(
    ("fault", "found"),
    [
        (FILTER, judged("wheelchair", report(ROLLS), online=parameters(70.0, 2.4), identified=parameters(76.0, 2.0))),
        (
            IDENTIFY,
            judged("wheelchair", report(ROLLS), online=parameters(128.0, 4.0), identified=parameters(135.0, 2.0)),
        ),
        (REPORT, judged("wheelchair", report(effect("rolling_resistance", force=(14.0, 1.0)), mass=(131.0, 40.0)))),
        (MUST, judged("wheelchair", report())),
        (WRONG, judged("wheelchair", report(ROLLS, effect("time_delay", 0.51)))),
        (VALUES, judged("wheelchair", report(effect("rolling_resistance", coefficient=(0.02, 0.01))))),
        (BOUND, judged("wheelchair", report(ROLLS), online=parameters(105.0, viscous_drag__linear=0.0))),
        (HEALTH, judged("wheelchair", report(ROLLS), health="inconsistent")),
        (REFIT, judged("wheelchair", report(ROLLS, gap=(0.1, 0.102, 0.02, 0.01)))),
        (AGREE, judged("wheelchair", report(ROLLS), online=parameters(90.0, 1.0), identified=parameters(105.0, 1.0))),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_one_fault_is_found_by_its_own_criterion(fault, found):
    assert found.faults == (fault,)


@pytest.mark.parametrize(
    "found",
    [
        judged("wheelchair", report(ROLLS), online=parameters(70.0, 1.0, identifiable=False), health="inconsistent"),
        judged("wheelchair", report(effect("stribeck_friction", confusable=["rolling_resistance"]))),
        judged("wheelchair", report(ROLLS, effect("time_delay", 0.49))),
        judged("wheelchair", report(ROLLS, effect("payload_change", 0.9, ["force_bias"]))),
        judged("wheelchair", report(ROLLS, gap=(0.1, 0.1004, 0.02, 0.01))),
    ],
    ids=["unwell filter", "a tie", "a doubtful name", "a tie with what may be", "noise"],
)
def test_what_is_allowed_is_no_fault(found):
    assert found.faults == ()


def test_a_floor_above_the_nominal_gap_excuses_no_worse_refit():
    assert judged("wheelchair", report(ROLLS, gap=(0.064, 1.57, 1.57, 0.208))).faults == (REFIT,)


def test_names_are_told_in_order_where_there_is_one():
    rolling = effect("rolling_resistance", force=(20.0, 0.5))
    directional = effect("directional_drag", forward=(1.0, 1.0))
    right = judged("emps", report(rolling, directional, mass=(95.1, 0.2)), guess=80.0)
    assert right.faults == ()
    assert judged("emps", report(directional, rolling, mass=(95.1, 0.2)), guess=80.0).faults == (MUST,)
    one_for_both = effect("rolling_resistance", confusable=["directional_drag"], force=(20.0, 0.5))
    assert judged("emps", report(one_for_both, mass=(95.1, 0.2)), guess=80.0).faults == (MUST,)


@pytest.mark.parametrize(("force", "holds"), [((21.61, 1.3), True), ((21.61, 1.1), False), ((19.2, 1.3), True)])
def test_the_axis_friction_is_within_one_deviation_of_its_reference(force, holds):
    said = report(effect("rolling_resistance", force=force), effect("directional_drag"), mass=(95.1, 0.2))
    assert judged("emps", said, guess=80.0).criteria[VALUES] is holds


def incline(grade=TWO_DEGREES_DOWN, stop=1.15):
    slope = effect("floor_slope", grade_x=(grade, 0.001), grade_y=(0.0, 0.01))
    return report(slope, effect("end_stop", position=(stop, 0.01), restitution=(0.8, 0.02)), mass=None)


def test_on_an_incline_the_floor_falls_and_the_mass_is_given():
    right = judged("good cart", incline(), guess=0.5)
    assert right.faults == ()
    assert right.criteria[REPORT] is right.criteria[FILTER] is right.criteria[AGREE] is None
    told = dict(right.values)
    assert told["slope"][0] == pytest.approx(2.0)
    assert told["end stop"] == (1.15, 0.01)
    assert judged("good cart", incline(grade=0.0349), guess=0.5).faults == (VALUES,)
    assert judged("good cart", incline(stop=1.0), guess=0.5).faults == (VALUES,)
    taught = judged("good cart", incline(), identified=parameters(0.6, 0.01), guess=0.5)
    assert taught.faults == (HEALTH,)


def test_where_nothing_moves_nothing_is_named():
    assert judged("still", report(mass=None), guess=0.5).faults == ()
    assert judged("still", report(effect("floor_slope"), mass=None), guess=0.5).faults == (WRONG,)


def rolls(coefficient):
    return effect("rolling_resistance", coefficient=(coefficient, 0.1))


@pytest.mark.parametrize(
    ("answers", "told"),
    [
        ({"identified": parameters(11.00001)}, ["identify: mass"]),
        ({"identified": parameters(11.00001, identifiable=False)}, []),
        ({"online": parameters(660.0)}, ["estimate: mass"]),
        ({"online": parameters(100.0, viscous_drag__linear=1e-6)}, ["estimate: viscous_drag.linear"]),
        ({"online": parameters(100.0, viscous_drag__linear=0.1)}, []),
        ({"said": report(rolls(1.0))}, ["discrepancy: rolling_resistance.coefficient"]),
        ({"said": report(effect("wheel_drag_imbalance", force=(0.0, 1.0), moment=(1.0, 1.0)))}, []),
    ],
)
def test_a_parameter_where_a_fit_was_stopped(answers, told):
    found = judged("wheelchair", **{"said": report(ROLLS)} | answers)
    assert at_a_bound(found.outcome, found.log.cart) == told


def test_a_mass_at_a_share_of_the_guess_is_at_a_bound_in_a_report():
    said = report(ROLLS, mass=(30.00003, 17.0))
    found = judged("car", said, online=parameters(240.0, 20.0), identified=parameters(235.0, 9.0), guess=300.0)
    assert at_a_bound(found.outcome, found.log.cart) == ["discrepancy: mass"]
    said["parameter_mismatch"]["mass"]["identifiable"] = False
    assert at_a_bound(found.outcome, found.log.cart) == []


def test_a_variant_is_judged_by_intervals_and_by_the_names_of_the_log_itself():
    base = judged("wheelchair", report(ROLLS)).outcome
    near = report(effect("rolling_resistance", force=(18.0, 0.6)), mass=(134.0, 2.5))
    assert judged("wheelchair", near, base=base).faults == ()
    assert judged("wheelchair", near).faults == (REPORT, VALUES)
    vague = report(effect("rolling_resistance", force=(14.0, 1.0)), mass=(50.0, 40.0))
    assert judged("wheelchair", vague, online=parameters(105.0), identified=parameters(105.0), base=base).faults == (
        REPORT,
    )
    more = report(ROLLS, effect("force_bias"))
    assert judged("wheelchair", more, base=base).faults == (SAME,)
    tie = report(effect("stribeck_friction", confusable=["rolling_resistance"]))
    assert judged("wheelchair", tie, base=base).faults == ()


def crashed(log="wheelchair"):
    answers = dict.fromkeys(COMMANDS, Answer(error="status 3, cartgrasp: run.csv: why"))
    return Judgement(BY_NAME[log], Outcome(log, "half the rows", 110.0, answers), judged(log, report(ROLLS)).outcome)


def test_what_ended_badly_is_a_row_and_not_right():
    found = crashed()
    assert found.outcome.errors == ("estimate, identify, discrepancy: status 3, cartgrasp: run.csv: why",)
    assert set(found.faults) == {ENDED, FILTER, IDENTIFY, REPORT, MUST, SAME}
    assert not found.is_right


def test_the_table_tells_truth_beside_what_was_said_and_counts():
    right, wrong = judged("wheelchair", report(ROLLS)), judged("car", report(mass=(30.0, 17.0)), guess=300.0)
    text = section([right, wrong, crashed()], ["real/new.csv"])
    lines = [line for line in reversed(text.splitlines()) if line.startswith("|")]
    rows = {line.split(" | ")[0].strip("| "): line for line in lines}
    assert "rolling force 10 to 17 N" in rows["wheelchair"]
    assert "rolling_resistance 0.99; mass 105 ± 2; rolling force 13.5 ± 1" in text
    assert "| 100, 50, 20; 10 | 3 + 2 + 8 |" in rows["wheelchair"]
    assert rows[REPORT] == f"| {REPORT} | 1 of 2 | 0 of 1 |"
    assert rows[SAME] == f"| {SAME} | - | 0 of 1 |"
    assert f"- car, as it is: {IDENTIFY}" not in text
    assert f"; {REPORT}; " in next(line for line in text.splitlines() if line.startswith("- car, as it is:"))
    assert "- wheelchair, half the rows: estimate, identify, discrepancy: status 3, cartgrasp: run.csv: why; " in text
    assert "real/new.csv" in text
    assert not any("nan" in line.split() for line in text.splitlines())
    widths = {line.count(" | ") for line in text.split("\n\n")[2].splitlines()}
    assert len(widths) == 1


def test_truths_are_of_the_vocabulary():
    for log in LOGS:
        known = KNOWN_EFFECTS.keys() | NOT_YET
        assert log.truth.allowed <= known
        assert all(one.low <= one.high for one in log.truth.values.values())
        assert (log.truth.mass is None) == ("force" not in log.has)


def test_an_interval_reaches_as_far_as_its_deviations():
    exact = Interval(20.4, 20.4, "N", "", deviations=1.0)
    assert exact.holds(21.4, 1.0)
    assert not exact.holds(21.5, 1.0)
    assert exact.holds(22.4, 1.0, deviations=2.0)
    assert not exact.holds(20.5, 1.0, deviations=0.0)
    assert truths.downhill(-math.tan(math.radians(3.0))) == pytest.approx(3.0)


def test_files_of_which_nothing_is_known_are_told(tmp_path):
    for path in (
        "real/incline/new.csv",
        "real/sensor_track/turning_wheel.csv",
        "real/wheelchair/push.csv",
        "emps/A.mat",
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    assert undeclared(tmp_path) == ["emps/A.mat", "real/incline/new.csv"]
