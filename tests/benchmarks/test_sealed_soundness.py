"""The rows of the score that rough logs, two arms, proof and other first guesses need; of reports whose answers are
known."""

from __future__ import annotations

import json
import sys

import pytest

from benchmarks.sealed import __main__ as command
from benchmarks.sealed.arms import by_arm, told_arms
from benchmarks.sealed.comparing import compare
from benchmarks.sealed.judging import Judgement
from benchmarks.sealed.score import score
from benchmarks.sealed.soundness import by_roughness, likely_and_wrong, mass_is_close, refit_is_worse, soundness, waits
from tests.benchmarks.test_sealed_score import effect, entry, report, truth


def rough(true, *kinds, tolerates=()):
    return true | {"roughness": [{"name": kind, "parameters": {}, "tolerates": list(tolerates)} for kind in kinds]}


def refitted(mass, **more):
    return {"parameter_mismatch": {"mass": {"nominal": 25.0, "refitted": mass, "std": 0.5}}, **more}


def gap(before, after):
    return {"gap": {"before": before, "refitted": after, "after": after, "noise_floor": 0.1}}


def lines_of(text):
    return {" ".join(line.split()) for line in text.splitlines()}


def test_a_mass_is_close_within_three_percent():
    def close(mass):
        return mass_is_close(Judgement(truth(), report("no_discrepancy") | refitted(mass)))

    assert [close(mass) for mass in (19.41, 20.59, 19.39, 20.61)] == [True, True, False, False]
    assert mass_is_close(Judgement(truth(), report("no_discrepancy"))) is None
    assert mass_is_close(Judgement(truth(), None)) is None


def test_a_refit_is_worse_beyond_noise():
    def worse(before, after):
        return refit_is_worse(Judgement(truth(), report("no_discrepancy") | gap(before, after)))

    assert [worse(1.0, 0.5), worse(1.0, 1.04), worse(1.0, 1.06)] == [False, False, True]
    assert refit_is_worse(Judgement(truth(), report("no_discrepancy"))) is None


def test_wrong_names_count_where_they_are_likely():
    said = [entry("floor_slope", told=0.9), entry("force_bias", told=0.6), entry("time_delay", told=0.4)]
    judged = Judgement(truth(effect("floor_slope")), report("explained", *said))
    assert likely_and_wrong(judged) == ("force_bias",)
    lines = lines_of(soundness([judged, Judgement(truth(), report("no_discrepancy") | refitted(20.1) | gap(1, 2))]))
    assert {"a wrong name above 0.5 1 of 2 50.0 %", "wrong names above one half force_bias 1"} <= lines
    assert {"mass within 3% 1 of 1 100.0 %", "refit worse than before 1 of 1 100.0 %"} <= lines
    assert soundness([Judgement(truth(), None)]) == ""


def test_a_lag_may_be_called_a_delay_where_no_effect_is_meant():
    said = report("explained", entry("time_delay", told=0.9))
    lagging = Judgement(rough(truth(), "force_lag", tolerates=["time_delay"]), said)
    assert lagging.right
    assert likely_and_wrong(lagging) == ()
    assert lagging.probabilities == [(0.9, True)]
    assert not Judgement(rough(truth(), "bursts"), said).right
    slope = rough(truth(effect("floor_slope")), "force_lag", tolerates=["time_delay"])
    assert Judgement(slope, report("explained", entry("floor_slope"), entry("time_delay"))).right
    assert not Judgement(slope, said).right
    late = rough(truth(effect("time_delay")), "force_lag", tolerates=["time_delay"])
    assert Judgement(late, said).right
    assert not Judgement(late, report("no_discrepancy")).right


def test_a_log_counts_for_each_of_its_kinds():
    slope = report("explained", entry("floor_slope"))
    told = [
        Judgement(rough(truth(effect("floor_slope")), "rail", "bursts"), slope | refitted(20.0), 3.0),
        Judgement(rough(truth(), "rail"), slope | refitted(30.0), 9.0),
    ]
    rows = lines_of(by_roughness(told))
    assert {
        "bursts 1 1 of 1 1 of 1 1 of 1 0 of 0 0 of 1 3.0 3.0",
        "rail 2 1 of 2 1 of 1 1 of 2 0 of 0 0 of 2 6.0 9.0",
    } <= rows
    assert "single 1 3.0 3.0 3.0" in lines_of(waits(told))
    assert by_roughness([Judgement(truth(), slope)]) == ""


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ([{"name": "force_bias", "label": "left"}], "named"),
        ([{"name": "force_bias.left"}], "named"),
        ([{"name": "force_bias", "label": "right"}], "the other alone"),
        ([{"name": "force_bias", "label": "right", "confusable_with": ["floor_slope"]}], "the other alone"),
        ([{"name": "force_bias", "label": "right", "confusable_with": ["force_bias"]}], "told as a tie"),
        ([{"name": "force_bias", "label": "right", "confusable_with": ["force_bias.left"]}], "told as a tie"),
        ([{"name": "force_bias", "label": "right"}, {"name": "force_bias", "label": "left"}], "both named"),
        ([{"name": "floor_slope", "label": ""}], "effect not named"),
    ],
)
def test_an_arm_is_named_or_ties(entries, said):
    true = truth(effect("force_bias", arm="left")) | {"settings": {"arms": ["left", "right"]}}
    judged = Judgement(true, report("explained", *entries))
    assert told_arms(judged) == [said]
    right = said in ("named", "told as a tie")
    whole = f"The arm of two: rightly named, or a tie {int(right)} of 1 {100.0 if right else 0.0} %"
    assert whole in lines_of(by_arm([judged]))
    alone = Judgement(truth(effect("force_bias", arm="arm")) | {"settings": {"arms": ["arm"]}}, report("unexplained"))
    assert by_arm([alone]) == ""


def test_a_coasting_cart_is_judged_per_mass():
    """The file says twice the mass, so twice the drags are right, and the mass is nobody's to know."""
    drag = effect("quadratic_drag", roughly={"coefficient": 8.0}) | {"per_mass": {"coefficient": 0.4}}
    true = truth(drag) | {"settings": {"arms": []}, "cart_file": {"mass": 40.0}}
    mismatch = {"mass": (40.0, 9.0), "inertia": (4.0, 0.1), "com_x": (0.3, 0.1), "viscous_drag.linear": (10.0, 0.1)}
    entries = {name: {"nominal": 0.0, "refitted": value, "std": std} for name, (value, std) in mismatch.items()}
    said = report("explained", entry("quadratic_drag", coefficient=(16.0, 0.5))) | {"parameter_mismatch": entries}
    judged = Judgement(true, said)
    assert [e.error for e in judged.estimates] == [0.0]
    assert {e.name: e.error for e in judged.mismatches} == {"com_x": 0.0, "inertia": 0.0, "linear": 0.0}
    assert mass_is_close(judged) is None


# --- folders --------------------------------------------------------------------------------------------------


def write(folder, name, true, said=None, seed=0, **more):
    document = {"seed": seed, "motion": "rich", **true, **more}
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    (folder / "truth" / f"{name}.json").write_text(json.dumps(document))
    out = folder / "logs" / name / "out"
    out.mkdir(parents=True)
    if said is not None:
        (out / "report.json").write_text(json.dumps(said))
        (out / "seconds.json").write_text('{"seconds": 4.0}')


def test_proof_is_told_in_totals_alone(tmp_path):
    slope, empty = truth(effect("floor_slope", {"grade_x": 0.02})), rough(truth(), "rail")
    right = report("explained", entry("floor_slope", grade_x=(0.021, 0.001))) | refitted(20.0) | gap(2.0, 1.0)
    write(tmp_path, "a", slope, right, proof=True)
    write(tmp_path, "b", empty, report("explained", entry("force_bias", told=0.8)) | gap(1.0, 2.0), proof=True)
    write(tmp_path, "c", slope, proof=True)
    text = score(tmp_path)
    assert not [word for word in ("floor_slope", "force_bias", "rail", "Case:", "in vain") if word in text]
    wanted = {
        "For proof: 2 reports of 3 logs; totals alone",
        "right: the names, or nothing, or without a name 1 of 2 50.0 %",
        "effects in the reported sets 1 of 1 100.0 %",
        "mass within 3% 1 of 1 100.0 %",
        "refit worse than before 1 of 2 50.0 %",
        "a wrong name above 0.5 1 of 2 50.0 %",
        "95 % intervals of named effects that hold 1 of 1 100.0 %",
        "seconds for a log median 4.0, most 4.0",
    }
    assert wanted <= lines_of(text)


def test_rough_logs_have_tables_of_their_own(tmp_path):
    write(tmp_path, "a", truth(), report("no_discrepancy"))
    write(tmp_path, "b", rough(truth(effect("floor_slope")), "rail"), report("no_discrepancy"))
    plain, _, ours = score(tmp_path).partition("Rough on purpose")
    assert "1 reports of 1 logs" in plain
    assert "nothing: false alarms 0 of 1 0.0 %" in lines_of(plain)
    assert "single effect: its name and no other 0 of 1 0.0 %" in lines_of(ours)
    assert any(line.startswith("rail 1 0 of 1") for line in lines_of(ours))


def two_folders(tmp_path, proof=False):
    good, bad = tmp_path / "good", tmp_path / "bad"
    slope = report("explained", entry("floor_slope")) | refitted(20.0)
    both = report("explained", entry("floor_slope"), entry("force_bias")) | refitted(14.0)
    bias = rough(truth(effect("force_bias")), "rail")
    for seed, (ours, theirs) in enumerate([(slope, slope), (slope, both), (report("no_discrepancy"), None)]):
        for folder, said in ((good, ours), (bad, theirs)):
            true = bias if seed else truth(effect("floor_slope"))
            write(folder, f"{folder.name}{seed}", true, said, seed, proof=proof, guess=[seed, 1.0])
    write(bad, "more", truth(), slope, seed=9, proof=proof)
    return good, bad


def test_verdicts_with_two_guesses_are_compared_log_by_log(tmp_path):
    lines = lines_of(compare(*two_folders(tmp_path)))
    wanted = {
        "2 logs with reports in both folders, of 3 and 4",
        "the same set of names 1 of 2 50.0 %",
        "right in the first 1 of 2 50.0 %",
        "right in the second 1 of 2 50.0 %",
        "mass within 3 % in both, or known in neither 1 of 2 50.0 %",
        "the same set of names: @rail 0 of 1 0.0 %",
        "the same set of names: single 1 of 2 50.0 %",
        "1 force_bias: floor_slope -> floor_slope+force_bias",
    }
    assert wanted <= lines


def test_of_proof_only_totals_are_compared(tmp_path):
    text = compare(*two_folders(tmp_path, proof=True))
    assert "for proof: the same set of names 1 of 2 50.0 %" in lines_of(text)
    assert not [word for word in ("rail", "single", "force_bias", "->") if word in text]


def test_a_folder_holds_one_guess_of_a_log(tmp_path, monkeypatch, capsys):
    good, bad = two_folders(tmp_path)
    monkeypatch.setattr(sys, "argv", ["sealed", "compare", str(good), str(bad)])
    command.main()
    assert "the same set of names" in capsys.readouterr().out
    write(bad, "again", truth(effect("floor_slope")), seed=0)
    with pytest.raises(SystemExit):
        command.main()
    assert "give each first guess a folder of its own" in capsys.readouterr().err
