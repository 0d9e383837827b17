"""Logs in which nobody pushes: without arms, or said to coast; and that zeros alone say nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.errors import DataError, UsageError
from cartgrasp.logs import ArmLog, RunLog, coasts, read_log, said_to_coast, write_log
from cartgrasp.logs.coasting import check_pushed, check_said, is_silent, with_zero_wrench
from cartgrasp.motion import Measurement

from . import bag_files as files

BARE = "t,x,y,theta\n0,0.1,0,0\n0.01,0.2,0,0\n0.02,0.3,0,0\n"


def rolling(n=7, step=0.001, **arms):
    """Poses that differ in every row, and arms with these wrenches in all of theirs."""
    pose = np.arange(3.0 * n).reshape(n, 3)
    held = {name: ArmLog(np.ones((n, 3)), np.full((n, 6), value)) for name, value in arms.items()}
    return RunLog(step * np.arange(n), pose, None, held)


def test_poses_alone_are_a_log(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(BARE)
    log = read_log(path)
    assert log.arms == {}
    assert log.columns == ("t", "x", "y", "theta")
    assert log.table.shape == (3, 4)
    assert coasts(log)
    check_said(log)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mcap"])
def test_a_log_without_arms_comes_back(tmp_path, suffix):
    if suffix == "parquet":
        pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
    log = rolling()
    back = read_log(write_log(log, tmp_path / f"run.{suffix}"))
    assert back.columns == log.columns
    assert back.pose[:, :2].tolist() == log.pose[:, :2].tolist()


def test_a_log_without_arms_is_thinned():
    log = rolling()
    assert log.thinned(500.0).pose.tolist() == log.pose[:6:2].tolist()
    assert all(m.wrenches == m.contacts == {} for m in log.measurements())


def test_measurements_without_arms_are_a_log():
    log = RunLog.from_measurements([Measurement(0.01 * i, np.full(3, float(i))) for i in range(3)], [])
    assert coasts(log)
    assert log.pose[:, 0].tolist() == [0.0, 1.0, 2.0]


def test_zeros_alone_say_nothing():
    log = rolling(left=0.0, right=0.0)
    assert is_silent(log)
    assert not coasts(log)
    with pytest.raises(DataError, match=r"all its wrenches are zero: .*--coasting.*sensor's connection"):
        check_said(log)
    told = said_to_coast(log)
    assert coasts(told)
    check_said(told)
    for part in (told.thinned(500.0), replace(told, name="cut")):
        assert coasts(part)


@pytest.mark.parametrize("pushed", [1e-9, -40.0])
def test_who_pushes_does_not_coast(pushed):
    log = rolling(left=0.0, right=pushed)
    assert not is_silent(log)
    check_pushed(log, "never said")
    with pytest.raises(DataError, match="said to coast, but the wrench of arm right is not zero"):
        said_to_coast(log)
    with pytest.raises(UsageError, match="somebody pushes"):
        with_zero_wrench(log)


def test_a_wrench_that_is_missing_throughout_is_not_zero():
    log = rolling(left=np.nan)
    assert not is_silent(log)
    check_said(log)
    assert coasts(said_to_coast(log))


def test_what_needs_a_wrench_refuses_to_coast():
    with pytest.raises(DataError, match=r"run: nobody pushes in it, and so on$"):
        check_pushed(rolling(), "and so on")
    with pytest.raises(DataError, match="--coasting"):
        check_pushed(rolling(left=0.0), "and so on")


@pytest.mark.parametrize("log", [rolling(), said_to_coast(rolling(left=np.nan)), said_to_coast(rolling(left=0.0))])
def test_a_wrench_that_is_known_to_be_zero(log):
    told = with_zero_wrench(log)
    assert coasts(told)
    for measurement in told.measurements():
        assert [w.tolist() for w in measurement.wrenches.values()] == [[0.0] * 6]
        assert [c.tolist() for c in measurement.contacts.values()] == [[0.0] * 3]


def test_a_bag_without_wrenches(tmp_path):
    """Its map says that there are no arms; a map that does not speak of arms is refused."""
    from cartgrasp.logs.bags.contents import contents_of, proposed_map
    from cartgrasp.logs.bags.opening import open_bag
    from cartgrasp.logs.bags.topic_map import load_topic_map

    bag = files.write_folder(tmp_path / "bag", [m for m in files.push() if m[0] == "/odom"])
    proposal = proposed_map(contents_of(open_bag(bag)), "bag")
    path = tmp_path / "topics.yaml"
    path.write_text(proposal)
    assert load_topic_map(path).map.arms == {}
    log = read_log(bag, path)
    assert coasts(log)
    rows, rate = files.path_of(np.arange(0, 2, 0.02))
    assert log.pose == pytest.approx(rows, abs=1e-12)
    assert log.velocity == pytest.approx(rate, abs=1e-12)
    path.write_text("pose: {topic: /odom}\n")
    with pytest.raises(UsageError, match="arms"):
        read_log(bag, path)
