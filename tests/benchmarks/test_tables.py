"""A small version of `python -m benchmarks.tables`."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tables.faults import FAULTS, SOUND, told
from benchmarks.tables.judging import judge
from benchmarks.tables.strangers import as_yaml, write
from cartgrasp.logs import read_log

SEEDS = range(7000, 7008)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_right_map_reads_what_was_true(tmp_path, seed):
    """So what proposals are judged by is right: poses and wrenches of the push, to noise and digits."""
    made = write(tmp_path / "run", seed)
    (tmp_path / "map.yaml").write_text(as_yaml(made.map), encoding="utf-8")
    log = read_log(made.path, tmp_path / "map.yaml")
    time = log.time - made.zero
    pose = made.push.at(time, made.push.pose)
    off = log.pose - pose
    off[:, 2] -= 2 * np.pi * np.round(off[:, 2] / (2 * np.pi))
    assert np.abs(off).max() < 0.005
    for name, arm in log.arms.items():
        hand, measured = made.push.hands[name], made.map["arms"][name]["measures"]
        kept = [k for k, part in enumerate(("fx", "fy", "fz", "tx", "ty", "tz")) if part in measured]
        assert np.abs(arm.wrench - made.push.at(time, hand.wrench))[:, kept].mean() < 0.4
        assert np.allclose(arm.contact, hand.contact, atol=1e-5)


@pytest.mark.some(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_proposals_are_right_and_never_wrong_in_silence(tmp_path, seed):
    judged = judge(write(tmp_path / "run", seed), tmp_path)
    assert judged.is_right, judged
    assert not judged.is_silently_wrong


def test_what_is_wrong_in_a_table_is_told(tmp_path):
    some = {name: FAULTS[name] for name in (SOUND, "x and y swapped", "wrench reversed", "forces in lbf")}
    found = told(tmp_path, 7000, some)
    assert [one.is_told for one in found] == [False, True, True, True]
