"""The regression beside which the workflow is judged: its parts by other roads, and reports that can be scored."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.sealed.baselines import all_free, regress, regress_all, selected, thresholded
from benchmarks.sealed.columns import candidates, followed, swung
from benchmarks.sealed.effects import VOCABULARY
from benchmarks.sealed.generate import generate
from benchmarks.sealed.recorded import HALF_WIDTH, STEP, Cart, Recorded, read_cart, read_recorded, slid
from benchmarks.sealed.score import score
from benchmarks.sealed.world import GRAVITY

SEEDS = st.integers(0, 2**32 - 1)


def test_a_cubic_is_smoothed_into_itself():
    time = STEP * np.arange(200)
    found = slid(1 + 2 * time - 3 * time**2 + 0.5 * time**3)
    wanted = 1 + 2 * time - 3 * time**2 + 0.5 * time**3, 2 - 6 * time + 1.5 * time**2, -6 + 3 * time
    for one, other in zip(found, wanted, strict=True):
        inside = slice(HALF_WIDTH, -HALF_WIDTH)
        assert one[inside] == pytest.approx(other[inside], abs=1e-8)


@settings(max_examples=25, deadline=None)
@given(seed=SEEDS, stop=st.sampled_from([0.01, 0.05, 0.2]))
def test_with_everything_free_a_term_counts_for_what_the_fit_would_miss(seed, stop):
    random = np.random.default_rng(seed)
    nominal, library = random.standard_normal((60, 2)), [random.standard_normal((60, k)) for k in (1, 2, 1)]
    target = nominal @ [1.0, -2.0] + 0.6 * library[1] @ [1.0, 0.5] + 0.3 * random.standard_normal(60)

    def left(terms):
        design = np.hstack([nominal, *(library[i] for i in terms)])
        return float(((target - design @ np.linalg.lstsq(design, target, rcond=None)[0]) ** 2).sum())

    missed = [(left({0, 1, 2} - {i}) - left({0, 1, 2})) / left(set()) for i in range(3)]
    if min(abs(one - stop) for one in missed) > 1e-3:
        wanted = [i for i in np.argsort(missed)[::-1] if missed[i] > stop]
        assert all_free(nominal, target, library, stop) == wanted


@settings(max_examples=25, deadline=None)
@given(seed=SEEDS, stop=st.sampled_from([0.01, 0.05, 0.2]))
def test_error_reduction_is_what_least_squares_gain(seed, stop):
    random = np.random.default_rng(seed)
    nominal, library = random.standard_normal((60, 2)), [random.standard_normal((60, k)) for k in (1, 1, 2, 3, 1)]
    target = nominal @ [1.0, -2.0] + 0.6 * library[3] @ [1.0, 0.5, -0.4] + 0.3 * random.standard_normal(60)

    def left(chosen):
        design = np.hstack([nominal, *(library[i] for i in chosen)])
        return float(((target - design @ np.linalg.lstsq(design, target)[0]) ** 2).sum())

    chosen = selected(nominal, target, library, stop)
    for at in range(len(chosen) + 1):
        gains = {i: left(chosen[:at]) - left([*chosen[:at], i]) for i in range(5) if i not in chosen[:at]}
        best = max(gains, key=gains.__getitem__, default=None)
        if at < len(chosen):
            assert chosen[at] == best
            assert gains[best] >= stop * left([]) * (1 - 1e-9)
        elif best is not None:
            assert gains[best] < stop * left([]) * (1 + 1e-9)


@pytest.mark.filterwarnings("ignore")  # of what pysindy brings
def test_thresholded_terms_are_those_that_are_there():
    pytest.importorskip("pysindy")
    random = np.random.default_rng(0)
    nominal, library = random.standard_normal((400, 2)), [random.standard_normal((400, k)) for k in (1, 1, 2, 3, 1)]
    target = nominal @ [1.0, -2.0] + 0.8 * library[3] @ [1.0, 0.9, 0.0] + library[0][:, 0]
    assert sorted(thresholded(nominal, target, library, 0.05)) == [0, 3]


def made_up(seed):
    """Motion of sines and a wrench of Newton and Euler on a slope, without noise; and the cart."""
    random = np.random.default_rng(seed)
    time = 0.1 * np.arange(500)
    a, b, p, q = random.uniform(0.3, 0.9, 4)
    u, du = a * np.sin(p * time), a * p * np.cos(p * time)
    r, dr = b * np.sin(q * time + 1), b * q * np.cos(q * time + 1)
    heading = -b / q * np.cos(q * time + 1)
    cart, (dx, dy), grade = Cart(30.0, (0.3, 0.05), 2.0, (4.0, 1.5)), (0.3, 0.05), random.uniform(-0.03, 0.03, 2)
    along, across = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]]).swapaxes(1, 2)
    pull_x, pull_y = 30 * GRAVITY * along @ grade, 30 * GRAVITY * across @ grade
    force = 30 * (du - dr * dy - r**2 * dx) + 4 * u + pull_x
    moment = (2 + 30 * (dx**2 + dy**2)) * dr + 30 * (dx * u * r - dy * du) + 1.5 * r + dx * pull_y - dy * pull_x
    wrench = np.column_stack([force, *np.zeros((4, 500)), moment])
    zero = np.zeros(500)
    rate = np.column_stack([np.gradient(force, time), np.gradient(moment, time)])
    log = Recorded(time, zero, zero, heading, u, zero, r, du, dr, {"arm": wrench}, {"arm": np.zeros((500, 3))}, rate)
    return log, cart, grade


@settings(max_examples=10, deadline=None)
@given(seed=SEEDS)
def test_a_slope_without_noise_is_found_exactly(seed):
    log, cart, grade = made_up(seed)
    report = regress(log, cart)
    assert [e["name"] for e in report["effects"]] == ["floor_slope"]
    found = report["effects"][0]["parameters"]
    assert [found[k]["value"] for k in ("grade_x", "grade_y")] == pytest.approx(grade, abs=1e-6)
    assert report["parameter_mismatch"]["mass"]["refitted"] == pytest.approx(30.0, rel=1e-6)


def test_a_bob_swings_at_its_frequency():
    log, _, _ = made_up(0)
    kicked = Recorded(**{**vars(log), "du": np.where(log.time < 0.15, 1.0, 0.0)})
    swing = swung(kicked, 0.8)
    spectrum = np.abs(np.fft.rfft(swing, 4096))
    assert np.fft.rfftfreq(4096, 0.1)[spectrum.argmax()] == pytest.approx(0.8, abs=0.02)


def test_casters_follow_with_the_way():
    way = np.linspace(0, 2, 2001)
    assert followed(np.where(way < 1, -1.0, 1.0), way)[1100] == pytest.approx(1 - 2 / np.e, abs=0.01)


def test_reports_can_be_scored(tmp_path):
    generate(tmp_path, ["force_scale", "viscous_drag"], [0], "straight")
    assert regress_all(tmp_path, "other", 0.02) == 2
    for folder in (tmp_path / "logs").iterdir():
        log, cart = read_recorded(folder / "run.csv"), read_cart(folder / "cart.yaml")
        assert {one.name for one in candidates(log, cart)} <= set(VOCABULARY)
        report = json.loads((folder / "other" / "report.json").read_text())
        assert {e["name"] for e in report["effects"]} <= set(VOCABULARY)
    text = score(tmp_path, "other")
    assert "2 reports of 2 logs" in text
    assert "Seconds for a log" in text
