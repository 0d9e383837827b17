"""Probabilities of names, fitted to names of which it is known how they were drawn."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.name_probabilities import Names, fitted, names, reliability
from estimation.discrepancy.findings.named_effects import ALTERNATIVE_ODDS_WEIGHT, name_probability


def drawn(numbers, count, seed):
    random = np.random.default_rng(seed)
    gain, beside, rivals = random.uniform(0.0, 3.0, count), -random.exponential(0.8, count), random.random(count)
    right = np.zeros(count)
    unproven = (random.random(count) < 0.3).astype(float)
    told = Names(np.full(count, 0.5), rivals, gain, beside, unproven, right, random.integers(0, 2, count))
    return replace(told, right=(random.random(count) < told.by(*numbers)).astype(float))


@pytest.mark.parametrize("numbers", [(0.5, 1.0, 1.2, 0.3, 1.5), (-1.0, 2.0, 0.4, 0.8, 0.6)])
def test_a_map_is_found_again(numbers):
    """Within four standard deviations, by the information of slopes that are taken by finite differences."""
    told = drawn(numbers, 6000, 3)
    likely = told.by(*numbers)
    slopes = [(told.by(*(np.array(numbers) + step)) - likely) / 1e-5 for step in 1e-5 * np.eye(5)]
    rows = np.stack(slopes, axis=1) / np.sqrt(likely * (1 - likely))[:, None]
    std = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert (np.abs(np.array(fitted(told)) - numbers) < 4 * std).all()


def test_a_map_never_falls_and_says_nothing_of_what_no_step_added():
    told = drawn((2.0, 0.0, 0.0, 0.0, 0.0), 400, 5)
    falling = replace(told, right=(told.gain < 1.5).astype(float))
    assert fitted(falling)[1] == 0.0
    unknown = replace(told, gain=np.full(400, np.nan), beside=np.full(400, np.nan))
    assert (unknown.by(1.0, 1.0, 1.0, 1.0, 1.0) == 0.5).all()


def test_names_are_read_with_their_gains_and_judged_on_the_other_half(tmp_path):
    for k in range(24):
        name, is_right = f"log{k}", k % 4 > 0
        hidden = {"name": "floor_slope", "parameters": {}, "roughly": {}, "outside": False, "arm": ""}
        truth = {"case": "floor_slope", "effects": [hidden], "cart": {}}
        gain = 300.0 if is_right else 12.0
        found = {
            "name": "floor_slope" if is_right else "time_delay",
            "label": "",
            "gain": gain,
            "gap_share": 0.1 * is_right,
        }
        found |= {
            "probability": name_probability(gain, 400.0, is_right) / (1.0 + 0.5 * ALTERNATIVE_ODDS_WEIGHT),
            "confusable_with": [],
        }
        steps = [{"added": "first", "candidates": [{"key": "first", "score": 400.0}, {"key": "other", "score": 500.0}]}]
        for path, told in (
            ("truth", truth),
            (f"logs/{name}/out", {"verdict": "explained", "effects": [found], "steps": steps}),
        ):
            (tmp_path / path).mkdir(parents=True, exist_ok=True)
            file = f"{name}.json" if path == "truth" else "report.json"
            (tmp_path / path / file).write_text(json.dumps(told), encoding="utf-8")
    every = names([tmp_path], "out")
    assert every.rivals == pytest.approx(0.5)
    assert every.right.sum() == 18
    assert (every.unproven == 1.0 - every.right).all()
    assert set(np.round(every.gain, 3)) == {round(float(np.log(30)), 3), round(float(np.log(1.2)), 3)}
    assert every.beside == pytest.approx(every.gain - np.log(40.0))
    text = reliability([tmp_path], [], "out", tmp_path / "drawn.svg")
    count = int((every.half == 1).sum())
    assert f"Fitted to {24 - count} names" in text
    assert sum(int(line.split("|")[2]) for line in text.splitlines() if " to " in line and line[0] == "|") == count
    assert (tmp_path / "drawn.svg").is_file()
    assert "Fitted to 24 names" in reliability([tmp_path], [tmp_path], "out", None)
    assert "give more logs" in reliability([tmp_path / "nowhere"], [], "out", None)
