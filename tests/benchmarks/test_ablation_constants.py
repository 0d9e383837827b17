"""The list of the engine's constants is whole, and a patched one is another wherever it is read, and for a while."""

from __future__ import annotations

import ast
import pkgutil
import re
import sys
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import estimation
from benchmarks.ablation import sources
from benchmarks.ablation.constants import MOVES, OFF, Constant, Group, times
from benchmarks.ablation.every import CONSTANTS
from benchmarks.ablation.patching import patched
from benchmarks.ablation.sources import copies, declared, names_in, worked_out_from
from cartgrasp.effects import FloorSlope
from cartgrasp.errors import UsageError
from estimation.discrepancy.findings import verdicts
from estimation.discrepancy.search import gains, scored_candidates

ABLATED = [c for c in CONSTANTS if c.group is not Group.WORKS_OUT]
BY_NAME = {c.full_name: c for c in CONSTANTS}
SURE = BY_NAME["gains.GAIN_SIGMAS"]


def test_every_constant_is_in_the_list_once():
    listed = [(c.module, c.name) for c in CONSTANTS]
    assert len(listed) == len(set(listed)) == len(BY_NAME)
    assert declared() - set(listed) == set(), "give each of these a row in benchmarks/ablation"
    assert set(listed) - declared() == set(), "these are no more: delete their rows"


def test_constants_are_found_as_a_reader_finds_them():
    source = (
        "A, B_2 = 1, 2\nC: float = 3.0\nD: float\nE = F = 4\nT = {'x': 1.0, 'y.z': 2}\nWORDS = {'x': 'y'}\n"
        "N = {A: 1.0}\nAlias = int\nlower = 5\ndef f():\n    INNER = 6\nclass K:\n    OWN = 7\n"
    )
    found = set(names_in(ast.parse(source)))
    assert found == {"A", "B_2", "C", "E", "F", "T[x]", "T[y.z]", "WORDS", "N"}


def test_what_decides_can_be_switched_off():
    for one in CONSTANTS:
        assert one.off is not None or one.group is not Group.DECIDES, one.full_name
        assert one.off is None or one.group is not Group.WORKS_OUT, one.full_name
        assert one.group is not Group.DECIDES or one.off != one.value, one.full_name
        assert one.why, one.full_name


def test_what_decides_are_twenty_at_most():
    """Issue 28."""
    assert sum(one.group is Group.DECIDES for one in CONSTANTS) <= 20


def test_what_is_ablated_can_be_moved():
    """Each is a number, numbers, or a table or tuple of names that can be emptied, but for a tuple of effects."""
    for one in ABLATED:
        assert any(one.moved(move) is not None for move in MOVES) or one.name == "NUISANCE_EFFECTS", one.full_name


@given(st.integers(1, 10**6), st.sampled_from([0.7, 0.9, 1.1, 1.3]))
def test_integers_move_by_one_at_least(value, factor):
    moved = times(value, factor)
    assert isinstance(moved, int)
    assert (moved - value) * (factor - 1) > 0
    assert abs(moved - value) == max(1, abs(round(value * factor) - value))


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=4), st.floats(0.1, 10))
def test_numbers_move_together(values, factor):
    assert times(tuple(values), factor) == tuple(factor * v for v in values)
    assert (times(np.array(values), factor) == factor * np.array(values)).all()
    assert times((*values, "word"), factor) is None
    assert times({"a": values[0]}, factor) is None


def everywhere():
    """Every module of `estimation` that can be loaded, by name."""
    for one in pkgutil.walk_packages(estimation.__path__, "estimation."):
        import_module(one.name)
    return {name: module for name, module in list(sys.modules.items()) if name.split(".")[0] == "estimation"}


@pytest.mark.some(40)
@pytest.mark.parametrize("constant", ABLATED, ids=lambda c: f"{c.full_name}")
def test_a_patched_constant_is_another_in_every_module(constant):
    """Found by the objects themselves, not by what sources import: all that was the constant, by its name."""
    before = getattr(import_module(f"estimation.{constant.module}"), constant.attribute)
    here = {n: m for n, m in everywhere().items() if vars(m).get(constant.attribute) is before}
    assert f"estimation.{constant.module}" in here
    told = object()
    with patched(constant, told):
        for name, module in here.items():
            now = vars(module)[constant.attribute]
            assert (now[constant.entry] if constant.entry else now) is told, name
        if constant.entry:
            others = {k: v for k, v in before.items() if k != constant.entry}
            assert {k: v for k, v in now.items() if k != constant.entry} == others
    assert all(vars(module)[constant.attribute] is before for module in here.values())


def test_who_has_copies_is_found_by_text_too():
    """Of every constant that more than one module has."""
    count = 0
    for constant in ABLATED:
        found = {where for where, _ in copies(f"estimation.{constant.module}", constant.attribute)}
        tail = constant.module.rpartition(".")[2]
        line = re.compile(rf"^from [.\w]*\b{tail} import [^#\n]*\b{constant.attribute}\b", re.MULTILINE)
        for path in sorted((sources.HERE / "estimation").rglob("*.py")):
            name = ".".join(path.relative_to(sources.HERE).with_suffix("").parts)
            if line.search(path.read_text(encoding="utf-8")):
                assert name in found, (constant.full_name, name)
                count += 1
    assert count > 5


def test_what_reads_a_copy_follows():
    """`verdicts` has a copy of `gains.GAIN_SIGMAS`: a gain of twice its error is sure, but not if ten times are
    asked for."""
    slope = scored_candidates.ScoredCandidate(FloorSlope(0.01, 0.0), 50.0, 1, error=25.0)
    best = scored_candidates.ScoredCandidate(FloorSlope(0.02, 0.0), 90.0, 1)
    step = scored_candidates.SearchStep((best, slope), best)
    assert verdicts.verdict(step, slope) == "gains 40.0 nats less than floor_slope"
    with patched(SURE, 10.0):
        assert "less than 10 standard deviations of its gain" in verdicts.verdict(step, slope)
    assert verdicts.verdict(step, slope) == "gains 40.0 nats less than floor_slope"


def test_what_fails_leaves_nothing_behind():
    before = gains.GAIN_SIGMAS
    with pytest.raises(KeyError), patched(SURE, 1.0):
        {1.0: "another"}.pop(gains.GAIN_SIGMAS + verdicts.GAIN_SIGMAS)
    assert gains.GAIN_SIGMAS is before
    assert verdicts.GAIN_SIGMAS is before


def test_what_others_are_worked_out_from_is_not_patched():
    with (
        pytest.raises(UsageError, match=r"residual_map\.PROFILE_BINS: modules work out others"),
        patched(BY_NAME["residual_map.PROFILE_BINS"], 9),
    ):
        pass
    assert [c.full_name for c in ABLATED if worked_out_from(f"estimation.{c.module}", c.attribute)] == []


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """A package with copies of copies, one by another name."""
    files = {
        "__init__": "",
        "own": "SIZE, FREE, MADE = 1.0, 2.0, 3.0\nHALF = MADE / 2\n",
        "near": "from .own import SIZE as LENGTH, FREE\ndef f(a=FREE):\n    return a + LENGTH\n",
        "inner/__init__": "from ..near import LENGTH\n",
        "inner/far": "from toy.inner import LENGTH\nclass K:\n    def f(self):\n        return LENGTH\n",
        "inner/late": "def f():\n    from ..own import SIZE\n    return SIZE\n",
    }
    for name, text in files.items():
        path = tmp_path / "toy" / f"{name}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(sources, "HERE", tmp_path)
    monkeypatch.setattr(sources, "PACKAGES", ("toy",))
    cached = [one for one in vars(sources).values() if hasattr(one, "cache_clear")]
    for one in cached:
        one.cache_clear()
    yield
    for one in cached:
        one.cache_clear()


@pytest.mark.usefixtures("toy")
def test_copies_of_copies_are_found():
    assert set(copies("toy.own", "SIZE")) == {
        ("toy.own", "SIZE"),
        ("toy.near", "LENGTH"),
        ("toy.inner", "LENGTH"),
        ("toy.inner.far", "LENGTH"),
    }
    assert not worked_out_from("toy.own", "SIZE")
    assert worked_out_from("toy.own", "FREE")
    assert worked_out_from("toy.own", "MADE")


def test_a_move_says_its_value():
    one = Constant("discrepancy.search.gains", "MIN_GAIN_NATS", Group.DECIDES, 0.0, "least gain")
    assert (one.moved(OFF), one.moved("0.7"), one.moved("1.3")) == (
        0.0,
        0.7 * gains.MIN_GAIN_NATS,
        1.3 * gains.MIN_GAIN_NATS,
    )
    assert (one.full_name, one.attribute, one.entry) == ("gains.MIN_GAIN_NATS", "MIN_GAIN_NATS", "")
    entry = BY_NAME["plausibility.MAX_SETTINGS[time_delay.delay]"]
    assert (entry.attribute, entry.entry) == ("MAX_SETTINGS", "time_delay.delay")
    assert entry.value == import_module("estimation.discrepancy.search.plausibility").MAX_SETTINGS["time_delay.delay"]
