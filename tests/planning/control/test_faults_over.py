"""After a fault of the senses, of an arm or of what is asked the cart is at rest, or on its path again, within 2 s."""

from __future__ import annotations

import os

import numpy as np
import pytest

from benchmarks.faults import KINDS, Fault, quietly
from cartgrasp.studies.parallel import run_all

FIRST = {Fault.drawn(np.random.default_rng([seed, 33])).kind: seed for seed in reversed(range(100))}
"""The first seed of each kind."""


@pytest.mark.long
@pytest.mark.some(3)
@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_is_over_within_two_seconds(kind):
    outcome = quietly(FIRST[kind])
    assert outcome.kind == kind
    assert outcome.is_safe


@pytest.mark.long
def test_a_clock_that_was_late_leaves_no_push_behind():
    """Poses of 0.2 s ago, then of now: 280 N were told of nothing, for two seconds and on."""
    outcome = quietly(36)
    assert outcome.kind == "late"
    assert outcome.is_safe


@pytest.mark.prove
def test_ten_thousand_faults_are():
    assert all(outcome.is_safe for outcome in run_all(quietly, range(10_000), os.cpu_count() or 1))
