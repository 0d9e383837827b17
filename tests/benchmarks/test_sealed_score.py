"""The score of reports whose answers are known."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks import true_structures
from benchmarks.sealed.calibration import coverage, probabilities, reliability
from benchmarks.sealed.judging import Estimate, Judgement, matched
from benchmarks.sealed.locality import acting, is_local, localisation, named
from benchmarks.sealed.reliability_plot import save_reliability
from benchmarks.sealed.score import gaps, judged, score

CART = {"mass": 20.0, "com_x": 0.3, "com_y": 0.0, "inertia": 2.0, "viscous_drag": {"linear": 5.0, "angular": 2.0}}


def effect(name, parameters=None, outside=False, roughly=None, arm=""):
    return {"name": name, "parameters": parameters or {}, "roughly": roughly or {}, "outside": outside, "arm": arm}


def truth(*effects):
    return {"case": "+".join(e["name"] for e in effects) or "nothing", "effects": list(effects), "cart": CART}


def report(verdict, *effects, **more):
    return {"verdict": verdict, "effects": list(effects), "parameter_mismatch": {}, "unexplained": {}, **more}


def entry(name, confusable=(), told=None, **parameters):
    values = {k: {"value": v, "std": s, "unit": ""} for k, (v, s) in parameters.items()}
    probability = {} if told is None else {"probability": told}
    return {"name": name, "confusable_with": list(confusable), "parameters": values, **probability}


def test_a_name_is_exact_or_within():
    rolling = truth(effect("rolling_resistance"))
    right = Judgement(rolling, report("explained", entry("rolling_resistance")))
    assert right.exact
    assert right.within
    confused = Judgement(rolling, report("explained", entry("stribeck_friction", ["rolling_resistance"])))
    assert not confused.exact
    assert confused.within
    too_much = Judgement(rolling, report("explained", entry("rolling_resistance"), entry("force_bias.left")))
    assert not too_much.exact
    assert too_much.within
    wrong = Judgement(rolling, report("explained", entry("force_bias.left")))
    assert wrong.names == ("force_bias",)
    assert not wrong.within


def test_each_of_a_pair_needs_an_entry_of_its_own():
    sets = [frozenset("ab"), frozenset("b")]
    assert matched(["a", "b"], sets)
    assert not matched(["a", "b"], [frozenset("ab")])
    assert not matched(["a", "a"], sets)
    pair = truth(effect("floor_slope"), effect("time_delay"))
    assert Judgement(pair, report("explained", entry("time_delay"), entry("floor_slope"))).exact


def test_nothing_and_what_has_no_name():
    assert Judgement(truth(), report("no_discrepancy")).called_nothing
    assert not Judgement(truth(), report("explained", entry("force_bias"))).called_nothing


def law(of, value=None, unit="m"):
    period = value and {"value": value, "std": 0.001, "unit": unit}
    return entry("learned_force") | {"law": {"acts_on": "forward_force", "of": of, "period": period}}


GAP = {"gap": {"refitted": 0.1, "after": 0.03, "noise_floor": 0.01}}


def test_what_has_no_name_is_a_law_of_its_variable():
    flat = truth(effect("flat_spot", {"period": 0.4}, outside=True))
    good = Judgement(flat, report("explained", law("travelled_distance", 0.402)) | GAP)
    assert good.variable_right
    assert good.period_right
    assert good.closed == pytest.approx((0.1**2 - 0.03**2) / (0.1**2 - 0.01**2))
    assert good.law_right
    open_gap = Judgement(
        flat, report("explained", law("travelled_distance", 0.402)) | {"gap": GAP["gap"] | {"after": 0.06}}
    )
    assert not open_gap.law_right
    forced = Judgement(flat, report("partly_explained", entry("wheel_drag_imbalance")))
    assert not forced.variable_right
    assert forced.period_right is False
    assert forced.wrong_names == ("wheel_drag_imbalance",)
    assert not forced.law_right
    other = Judgement(flat, report("explained", law("travelled_distance", 0.42)) | GAP)
    assert other.period_right is False
    seconds = Judgement(flat, report("explained", law("time", 0.4, "s")) | GAP)
    assert not seconds.variable_right
    assert seconds.period_right is False


def test_the_name_beside_a_law_is_asked_for_and_a_law_alone_is_a_wrong_answer_to_a_name():
    both = truth(effect("warming", outside=True), effect("rolling_resistance"))
    assert Judgement(both, report("explained", law("time"), entry("rolling_resistance")) | GAP).law_right
    assert not Judgement(both, report("explained", law("time")) | GAP).law_right
    alone = Judgement(truth(effect("rolling_resistance")), report("explained", law("time")))
    assert alone.wrong_names == ("learned_force",)
    assert not alone.exact
    cubic = Judgement(truth(effect("cubic_drag", outside=True)), report("explained", entry("quadratic_drag")) | GAP)
    assert cubic.law_right


def test_probabilities_beside_truth():
    said = [("floor_slope", 0.9), ("force_bias.left", 0.7), ("force_bias.right", 0.2), ("time_delay", None)]
    judged = Judgement(
        truth(effect("floor_slope")), report("explained", *(entry(name, told=told) for name, told in said))
    )
    assert sorted(judged.probabilities) == [(0.7, False), (0.9, True)]
    lines = {" ".join(line.split()) for line in reliability([judged]).splitlines()}
    assert {"0.5 to 0.8 1 0.700 0.000", "0.8 to 0.95 1 0.900 1.000", "Brier score 2 0.250"} <= lines
    assert reliability([Judgement(truth(), report("no_discrepancy"))]) == ""


def test_the_mass_is_of_the_whole_whatever_swings():
    refitted = {"mass": {"refitted": CART["mass"] - 6.0, "std": 0.5}}
    swings = Judgement(
        truth(effect("load_slosh")), report("explained", entry("load_slosh"), parameter_mismatch=refitted)
    )
    assert [(e.name, e.error, e.roughly) for e in swings.mismatches] == [("mass", pytest.approx(-6.0), False)]


def test_intervals_that_hold():
    far, near = Estimate("a", 1.0, 1.5, 0.25), Estimate("a", 1.0, 1.4, 0.25)
    vague = [Estimate("a", 1.0, 9.0, 0.1, roughly=True), Estimate("a", 1.0, 9.0, float("nan"))]
    assert "1 of 2    50.0 %" in coverage({"some": [far, near, *vague]})
    assert coverage({"none": vague}) == ""


def test_each_part_of_a_drag_is_judged():
    parts = {f"viscous_drag.{k}": {"nominal": 1, "refitted": v, "std": 0.1} for k, v in (("linear", 5), ("angular", 2))}
    found = Judgement(truth(), report("no_discrepancy") | {"parameter_mismatch": parts}).mismatches
    assert [(e.name, e.error) for e in found] == [("linear", 0.0), ("angular", 0.0)]


def test_a_refitted_drag_counts_where_the_file_has_none():
    drag = truth(effect("viscous_drag", {"linear": 5.0}))
    mismatch = {"viscous_drag": {"nominal": 0.0, "refitted": 5.4, "std": 0.2}}
    found = Judgement(drag, report("no_discrepancy") | {"parameter_mismatch": mismatch})
    assert found.exact
    assert found.mismatches[0].z == pytest.approx(2.0)
    missed = {"viscous_drag": {"nominal": 0.0, "refitted": 1.0, "std": 0.2}}
    assert not Judgement(drag, report("no_discrepancy") | {"parameter_mismatch": missed}).exact


def test_parameters_are_compared_where_both_state_them():
    bias = truth(effect("force_bias", {"fx": 3.0, "fy": -2.0}, arm="left"))
    both = Judgement(
        bias, report("explained", entry("force_bias.left", fx=(3.5, 0.25)), entry("force_bias.right", fx=(9, 1)))
    )
    (found,) = both.estimates
    assert (found.name, found.error, found.z) == ("force_bias.fx", 0.5, 2.0)


def test_the_score_counts(tmp_path):
    def write(name, true, said=None):
        (tmp_path / "truth").mkdir(exist_ok=True)
        (tmp_path / "truth" / f"{name}.json").write_text(json.dumps(true))
        if said is not None:
            out = tmp_path / "logs" / name / "out"
            out.mkdir(parents=True)
            (out / "report.json").write_text(json.dumps(said))

    gap = {"gap": {"before": 9.0, "refitted": 4.0, "after": 1.0, "noise_floor": 0.8}}
    write(
        "a",
        truth(effect("floor_slope", {"grade_x": 0.02})),
        report("explained", entry("floor_slope", grade_x=(0.021, 0.001)), **gap),
    )
    write("b", truth(effect("floor_slope")), report("explained", entry("force_bias", ["floor_slope", "wind"])))
    (tmp_path / "logs" / "a" / "refit.json").write_text('{"gap": 0.8}')
    write("c", truth(effect("floor_slope")))
    write("d", truth(), report("explained", entry("force_bias")))
    (tmp_path / "logs" / "a" / "out" / "seconds.json").write_text('{"seconds": 12.5}')
    text = score(tmp_path)
    assert "0 reports of 4 logs; 4 missing" in score(tmp_path, "out-other")
    lines = {" ".join(line.split()) for line in text.splitlines()}
    assert "3 reports of 4 logs; 1 missing" in lines
    assert "all 1 12.5 12.5 12.5" in lines
    assert "names told that are not hidden 2 of 3 66.7 %" in lines
    assert "single effect: its name and no other 1 of 2 50.0 %" in lines
    assert "single effect: in the reported set 2 of 2 100.0 %" in lines
    assert "single effect: wrong name, but the truth in its set 1 of 1 100.0 %" in lines
    assert "single effect: mean size of the reported set 2.00" in lines
    assert "nothing: false alarms 1 of 1 100.0 %" in lines
    assert any(line.startswith("single 1 0.250; 0.250 1.250; 1.250") for line in lines)
    assert any(line.startswith("floor_slope.grade_x 1 0.001 0.001") for line in lines)
    assert "Names given in vain: force_bias 2" in lines
    assert "single 1 1.250 1.250 0 of 1 0.0 %" in lines
    assert any("1 (no report)" in line for line in lines)


WORLD = {"half_track": 0.2, "caster_x": 0.6, "caster_y": 0.25}
CRAWL = np.column_stack([np.arange(0.0, 10.0, 0.1), np.arange(0.0, 5.0, 0.05), np.zeros((100, 2))])
"""Along x at 0.5 m/s, for ten seconds."""


def local(name, told, **parameters):
    """A local effect's truth beside a report."""
    hidden = truth(effect(name, parameters)) | {"world": WORLD}
    return Judgement(hidden, report("explained", **told), course=CRAWL)


def test_samples_told_to_disagree_are_held_against_those_on_which_it_acts():
    """Of a push from 2 to 4 s: told are 3 to 5 s, half of it, and half of what is told; then that and much else."""
    other = {"start": 0.0, "stop": 9.9}
    half = {"where": [{"start": 0.0, "stop": 9.9, "intervals": [[2.95, 4.95]]}, other]}
    push = local("external_push", half, start=1.95, duration=2.0)
    whole = local("external_push", {"where": [other]}, start=1.95, duration=2.0)
    none = local("external_push", {"where": []}, start=1.95, duration=2.0)
    for told, wanted in ((push, 0.5), (whole, 2 * 20 / (20 + 100)), (none, 0.0)):
        (line,) = (one for one in localisation([told]).splitlines() if "told first" in one)
        assert [float(word) for word in line.split()[-5:-2]] == pytest.approx([1, wanted, wanted], abs=0.006)
    assert "told first" not in localisation([local("external_push", {}, start=1.95, duration=2.0)])
    both = truth(effect("external_push"), effect("time_delay"))
    assert is_local(push.truth)
    assert not is_local(both)
    assert not is_local(truth())


def test_a_named_effect_tells_its_own_time_or_place():
    """A carpet from 2 to 3 m: casters come to it after 1.4 m of way, fixed wheels leave it after 3."""
    box = {"x_min": 2.0, "x_max": 3.0, "y_min": 0.0, "y_max": 1.0}
    there = acting([effect("floor_patch", box)], CRAWL, WORLD)
    assert CRAWL[there, 1][[0, -1]] == pytest.approx((1.45, 2.95))
    assert there.sum() == 31
    aside = acting([effect("floor_patch", box | {"y_min": 0.22, "y_max": 1.0})], CRAWL, WORLD)
    assert CRAWL[aside, 1][[0, -1]] == pytest.approx((1.45, 2.35))
    loaded = acting(named({"effects": [entry("payload_change", time=(6.95, 0.1), mass=(3.0, 0.1))]}), CRAWL, WORLD)
    assert loaded.tolist() == [False] * 70 + [True] * 30
    assert not acting([effect("external_push", {"force": 3.0}), effect("floor_slope")], CRAWL, WORLD).any()


def test_a_method_without_a_gap_is_scored_by_that_of_its_names(tmp_path, monkeypatch):
    """Four logs: nothing is named, what the workflow names, and twice something else, once refitted."""
    rolling = truth(effect("rolling_resistance"))
    told = {"a": [], "b": [entry("rolling_resistance")], "c": [entry("floor_slope")], "d": [entry("floor_slope")]}
    (tmp_path / "truth").mkdir()
    for name, effects in told.items():
        (tmp_path / "truth" / f"{name}.json").write_text(json.dumps(rolling))
        own = report("explained", entry("rolling_resistance"), gap=GAP["gap"] | {"before": 0.2})
        for out, said in (("out", own), ("other", report("explained", *effects))):
            (tmp_path / "logs" / name / out).mkdir(parents=True)
            (tmp_path / "logs" / name / out / "report.json").write_text(json.dumps(said))
    (tmp_path / "logs" / "d" / "other" / "refit.json").write_text('{"gap": 0.06}')
    found = [j.report["gap"] and j.report["gap"]["after"] for j in judged(tmp_path, "other")]
    assert found == [0.1, 0.03, None, 0.06]
    refits = []
    monkeypatch.setattr(true_structures, "refitted", lambda log, effects: refits.append(effects) or {"gap": 0.05})
    assert true_structures.refit_told(tmp_path, "other") == 2  # one is there already
    assert [[one["name"] for one in effects] for effects in refits] == [["floor_slope"]]
    assert "squared gap above noise closed, of those (median)" in score(tmp_path, "other")


def test_gaps_that_are_more_than_noise_are_told_apart(tmp_path):
    def gap(refitted):
        return {"before": 0.2, "refitted": refitted, "after": 0.02, "noise_floor": 0.02}

    rolling = truth(effect("rolling_resistance"))
    told = [Judgement(rolling, report("explained", gap=gap(refitted))) for refitted in (0.025, 0.2)]
    assert [j.stands_out for j in told] == [False, True]
    lines = [line.split() for line in gaps(told).splitlines()]
    assert lines[1][:4] == ["single", "2", "0.450;", "0.730"]
    assert lines[2][-5:-2] == ["1", "0.100;", "0.100"]


def test_reliability_is_drawn(tmp_path):
    said = [("floor_slope", 0.9), ("force_bias.left", 0.7)]
    judgement = Judgement(
        truth(effect("floor_slope")), report("explained", *(entry(name, told=told) for name, told in said))
    )
    save_reliability(probabilities([judgement]), tmp_path / "reliability.svg")
    drawn = (tmp_path / "reliability.svg").read_text(encoding="utf-8")
    assert "Probability that is said" in drawn


def test_a_name_that_stands_for_a_law_is_as_large_as_both():
    """Dry drag at an axle, 0.02 of the weight, beside rolling resistance of 0.01; not where a law is told for it."""
    axle = {"name": "axle_drag", "parameters": {"size": 0.02 * 30.0 * 9.80665}}
    rolling = {"name": "rolling_resistance", "parameters": {"coefficient": 0.01}}
    blank = {"roughly": {}, "arm": "", "per_mass": {}}
    effects = [{**axle, **blank, "outside": True}, {**rolling, **blank, "outside": False}]
    said = {"name": "rolling_resistance", "parameters": {"coefficient": {"value": 0.03, "std": 0.001}}}
    law = {"name": "learned_force", "parameters": {}, "law": {"of": "speed", "period": None}}
    truth = {"effects": effects, "cart": {"mass": 30.0}, "cart_file": {"mass": 33.0}}
    for told, size in (([said], 0.03), ([said, law], 0.01)):
        (estimate,) = Judgement(truth, {"effects": told}).estimates
        assert estimate.truth == pytest.approx(size, rel=1e-3)
