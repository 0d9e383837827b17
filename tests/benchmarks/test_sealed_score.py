"""The score of reports whose answers are known."""

from __future__ import annotations

import json

import pytest

from benchmarks.sealed.judging import Judgement, matched
from benchmarks.sealed.score import score

CART = {"mass": 20.0, "com_x": 0.3, "com_y": 0.0, "inertia": 2.0, "viscous_drag": {"linear": 5.0, "angular": 2.0}}


def effect(name, parameters=None, outside=False, roughly=None, arm=""):
    return {"name": name, "parameters": parameters or {}, "roughly": roughly or {}, "outside": outside, "arm": arm}


def truth(*effects):
    return {"case": "+".join(e["name"] for e in effects) or "nothing", "effects": list(effects), "cart": CART}


def report(verdict, *effects, **more):
    return {"verdict": verdict, "effects": list(effects), "parameter_mismatch": {}, "unexplained": {}, **more}


def entry(name, confusable=(), **parameters):
    values = {k: {"value": v, "std": s, "unit": ""} for k, (v, s) in parameters.items()}
    return {"name": name, "confusable_with": list(confusable), "parameters": values}


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
    flat = truth(effect("flat_spot", {"period": 0.4}, outside=True))
    good = Judgement(flat, report("unexplained", unexplained={"period": {"value": 0.41}}))
    assert good.called_unexplained
    assert good.period_right
    forced = Judgement(flat, report("partly_explained", entry("wheel_drag_imbalance")))
    assert not forced.called_unexplained
    assert forced.partly
    assert forced.period_right is False


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
    write("c", truth(effect("floor_slope")))
    write("d", truth(), report("explained", entry("force_bias")))
    text = score(tmp_path)
    lines = {" ".join(line.split()) for line in text.splitlines()}
    assert "3 reports of 4 logs; 1 missing" in lines
    assert "single effect: its name and no other 1 of 2 50.0 %" in lines
    assert "single effect: in the reported set 2 of 2 100.0 %" in lines
    assert "single effect: mean size of the reported set 2.00" in lines
    assert "nothing: false alarms 1 of 1 100.0 %" in lines
    assert any(line.startswith("single 0.250; 0.250 1.250; 1.250") for line in lines)
    assert any(line.startswith("floor_slope.grade_x 1 0.001 0.001") for line in lines)
    assert "Names given in vain: force_bias 2" in lines
    assert any("1 (no report)" in line for line in lines)
