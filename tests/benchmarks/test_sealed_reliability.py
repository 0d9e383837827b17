"""Probabilities of names, fitted to names of which it is known how they were drawn."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.special import expit

from benchmarks.sealed.reliability import Names, fitted, names, reliability
from estimation.discrepancy.named import true_alone


def drawn(at, more, count, seed, left=1.0):
    random = np.random.default_rng(seed)
    gain = random.uniform(0.0, 3.0, count)
    right = (random.random(count) < left * expit(at + more * gain)).astype(float)
    return Names(np.full(count, 0.5), np.full(count, left), gain, right, random.integers(0, 2, count))


@pytest.mark.parametrize(("at", "more", "left"), [(0.5, 1.0, 1.0), (-1.0, 2.0, 0.8)])
def test_a_map_is_found_again(at, more, left):
    """Within three standard deviations of such a logistic fit, for whose size the information is summed here."""
    told = drawn(at, more, 4000, 3, left)
    likely = expit(at + more * told.gain)
    slopes = left * likely * (1 - likely) / np.sqrt(left * likely * (1 - left * likely))
    rows = slopes[:, None] * np.column_stack([np.ones(4000), told.gain])
    std = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert np.abs(np.array(fitted(told)) - (at, more)).max() < 3 * std.max()


def test_a_map_never_falls_and_says_nothing_of_what_no_step_added():
    told = drawn(2.0, 0.0, 400, 5)
    falling = Names(told.said, told.left, told.gain, (told.gain < 1.5).astype(float), told.half)
    assert fitted(falling)[1] == 0.0
    unknown = Names(told.said, told.left, np.full(400, np.nan), told.right, told.half)
    assert (unknown.by(1.0, 1.0) == 0.5).all()


def test_names_are_read_with_their_gains_and_judged_on_the_other_half(tmp_path):
    for k in range(24):
        name, is_right = f"log{k}", k % 4 > 0
        hidden = {"name": "floor_slope", "parameters": {}, "roughly": {}, "outside": False, "arm": ""}
        truth = {"case": "floor_slope", "effects": [hidden], "cart": {}}
        gain = 300.0 if is_right else 12.0
        found = {"name": "floor_slope" if is_right else "time_delay", "label": "", "gain": gain}
        found |= {"probability": 0.5 * true_alone(gain), "confusable_with": []}
        for path, told in (("truth", truth), (f"logs/{name}/out", {"verdict": "explained", "effects": [found]})):
            (tmp_path / path).mkdir(parents=True, exist_ok=True)
            file = f"{name}.json" if path == "truth" else "report.json"
            (tmp_path / path / file).write_text(json.dumps(told), encoding="utf-8")
    every = names([tmp_path], "out")
    assert every.left == pytest.approx(0.5)
    assert every.right.sum() == 18
    assert set(np.round(every.gain, 3)) == {round(float(np.log(30)), 3), round(float(np.log(1.2)), 3)}
    text = reliability([tmp_path], "out", tmp_path / "drawn.svg")
    count = int((every.half == 1).sum())
    assert f"Fitted to {24 - count} names" in text
    assert sum(int(line.split("|")[2]) for line in text.splitlines() if " to " in line and line[0] == "|") == count
    assert (tmp_path / "drawn.svg").is_file()
    assert "give more logs" in reliability([tmp_path / "nowhere"], "out", None)
