"""Logs as MCAP: read back the same, and read by other libraries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from cartgrasp.errors import DataError
from cartgrasp.logs import ArmLog, RunLog, read_log, write_log

from .tables import random_log

NUMBERS = st.one_of(st.floats(-1e6, 1e6), st.just(math.nan))


@st.composite
def logs(draw):
    n = draw(st.integers(1, 6))
    steps = draw(st.lists(st.integers(1, 10**10), min_size=n, max_size=n))
    arms = draw(st.lists(st.text(st.characters(codec="utf-8", exclude_characters="."), min_size=1), unique=True))

    def table(width, elements=NUMBERS):
        return draw(arrays(np.float64, (n, width), elements=elements))

    pose = table(3)
    pose[:, 2] = draw(arrays(np.float64, n, elements=st.floats(-3, 3)))
    return RunLog(
        draw(st.integers(-(10**6), 10**6)) + np.cumsum(steps) / 1e9,
        pose,
        table(3, st.floats(-1e3, 1e3)) if draw(st.booleans()) else None,
        {arm: ArmLog(table(3), table(6)) for arm in arms[:3]},
    )


@pytest.mark.long
@given(logs())
def test_a_log_comes_back(tmp_path_factory, log):
    """Times to 1 ns, headings and velocities to round-off, all else to the bit; what is missing stays missing."""
    back = read_log(write_log(log, tmp_path_factory.mktemp("mcap") / "run.mcap"))
    assert back.columns == log.columns
    assert back.time == pytest.approx(log.time, abs=1.1e-9)
    assert np.array_equal(back.pose[:, :2], log.pose[:, :2], equal_nan=True)
    assert np.unwrap(back.pose[:, 2]) == pytest.approx(np.unwrap(log.pose[:, 2]), abs=1e-14 * len(log))
    if log.velocity is not None:
        assert back.velocity == pytest.approx(log.velocity, abs=1e-14 * 1e3)
    for arm in log.arms:
        assert np.array_equal(back.arms[arm].wrench, log.arms[arm].wrench, equal_nan=True)
        assert np.array_equal(back.arms[arm].contact, log.arms[arm].contact, equal_nan=True)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    log = random_log(np.random.default_rng(8), n=2000, arms=("left arm", "right"))
    return log, write_log(log, tmp_path_factory.mktemp("written") / "run.mcap")


def test_another_mcap_library_reads_it(written):
    log, path = written
    with open(path, "rb") as stream:
        assert sum(1 for _ in StreamReader(stream, validate_crcs=True).records) > 10
        stream.seek(0)
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary.statistics.message_count == 4 * len(log)
        assert len(summary.chunk_indexes) > 1
        assert {c.topic for c in summary.channels.values()} == {
            *("/cart/odometry", "/tf", "/left_arm/wrench", "/right/wrench")
        }
        found = [m for _, c, _, m in reader.iter_decoded_messages(topics=["/right/wrench"])]
        forces = [[m.wrench.force.x, m.wrench.force.y, m.wrench.force.z] for m in found]
        assert np.array_equal(forces, log.arms["right"].wrench[:, :3])
        stream.seek(0)
        tf = next(m for _, _, _, m in reader.iter_decoded_messages(topics=["/tf"]))
        assert [(t.header.frame_id, t.child_frame_id) for t in tf.transforms] == [
            *(("world", "cart"), ("cart", "left_arm"), ("cart", "right"))
        ]


def test_rosbags_reads_it_by_the_types_in_it(written):
    log, path = written
    poses = []
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages([c for c in reader.connections if c.topic == "/cart/odometry"]):
            message = reader.deserialize(raw, connection.msgtype)
            point, turned = message.pose.pose.position, message.pose.pose.orientation
            poses.append([point.x, point.y, 2 * math.atan2(turned.z, turned.w)])
    poses = np.array(poses)
    assert np.array_equal(poses[:, :2], log.pose[:, :2])
    assert np.cos(poses[:, 2] - log.pose[:, 2]) == pytest.approx(np.ones(len(log)), abs=1e-12)


def test_what_ros_cannot_stamp(tmp_path):
    for times in ([0.0, 1e10], [0.0, 1e-11], [-1e12, 0.0]):
        log = RunLog(np.array(times), np.zeros((2, 3)), None, {"a": ArmLog(np.zeros((2, 3)), np.zeros((2, 6)))})
        with pytest.raises(DataError, match=r"^run: "):
            write_log(log, tmp_path / "run.mcap")
    assert not list(tmp_path.iterdir())
