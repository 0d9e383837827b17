"""Rules of the discrepancy engine that an ablation takes away: each is a function of its module, taken away wherever it
is called, and noticed where it says something else than there would be without it."""

from __future__ import annotations

from importlib import import_module

import pytest

from benchmarks.ablation.constants import MOVES, OFF
from benchmarks.ablation.every import CONSTANTS
from benchmarks.ablation.patching import patched
from benchmarks.ablation.rules import RULES
from benchmarks.ablation.watching import noticed
from estimation.discrepancy.findings import refusal, validation
from estimation.discrepancy.findings.reported_mass import reported_mass
from estimation.weak_form.band import Band

BY_NAME = {rule.full_name: rule for rule in RULES}


def test_rules_are_not_constants_and_have_one_name_each():
    assert len(BY_NAME) == len(RULES)
    assert not set(BY_NAME) & {one.full_name for one in CONSTANTS}


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.full_name)
def test_a_rule_is_taken_away_and_put_back(rule):
    before = rule.value
    assert callable(before)
    with patched(rule, rule.moved(OFF)):
        assert rule.value is rule.off
    assert rule.value is before
    assert [move for move in MOVES if rule.moved(move) is not None] == [OFF]


def test_a_rule_is_taken_away_where_it_was_imported():
    with patched(BY_NAME["refusal.is_beyond"], BY_NAME["refusal.is_beyond"].off):
        assert validation.is_beyond(None, 0.1) is True
    assert validation.is_beyond is refusal.is_beyond


def test_a_rule_is_noticed_where_it_says_something_else():
    """Without bands a mass is told as it is fitted; between bands that leave 10 % open it is not."""
    rule = BY_NAME["reported_mass.reported_mass"]
    band = Band(row_step=0.3, mass=30.0, std=0.3, bracket=3.0)
    for bands, is_noticed in (([], False), ([band], True)):
        said, found = noticed(lambda bands=bands: _now()(3.4, 0.1, bands), [rule], MOVES)
        assert said == reported_mass(3.4, 0.1, bands)
        assert found == ({(rule.full_name, OFF)} if is_noticed else set())


def _now():
    return import_module("estimation.discrepancy.findings.reported_mass").reported_mass
