"""No table says that anything was taught under a health that is not ok, and each says the health."""

from __future__ import annotations

import pytest

from cartgrasp.cli import demo
from cartgrasp.cli.run_tables import identifiable_word, print_parameters, print_run
from cartgrasp.motion import ParameterEstimate
from cartgrasp.studies.run_figures import RunFigures


def figures(health):
    learned = {"truth": 0.05, "value": -0.525, "std": 0.01, "unit": "m", "identifiable": True}
    names = ("mass", "com_x", "com_y", "inertia", "viscous_drag.linear")
    return RunFigures(10.0, 0.1, 0.1, 0.1, 5, 5, 0, 20.0, dict.fromkeys(names, learned), health)


@pytest.mark.parametrize("health", ["inconsistent", "load_changed", "outliers", "stale", "no_wrench"])
def test_a_run_whose_estimate_is_not_ok(capsys, health):
    print_run(figures("ok"), "a run")
    assert " yes\n" in capsys.readouterr().out
    print_run(figures(health), "a run")
    shown = capsys.readouterr().out
    assert f"health: {health}" in shown
    assert " yes\n" not in shown
    assert ("taught nothing" if health == "inconsistent" else "nothing counts as taught") in shown
    assert identifiable_word(True) == "yes"
    assert identifiable_word(True, health) == identifiable_word(False) == "no"


def test_the_demo_says_what_leaving_effects_out_does_to_the_estimate(capsys):
    demo._print_cost(figures("ok"), figures("inconsistent"))
    shown = capsys.readouterr().out
    assert "health of the estimate" in shown
    assert "inconsistent" in shown
    assert "the model without them does not fit this log, so it taught nothing" in shown


def test_what_rounding_left_is_printed_as_nought(capsys):
    print_parameters("cart", {"drag": ParameterEstimate(2.2e-16, 4.4, "N·s/m", False)}, "taught")
    (row,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("drag")]
    assert row.split()[:3] == ["drag", "0", "4.4"]
