"""Bags whose messages are whole, but can't be one run: refused with their place, or left out and told."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.writer import Writer as McapWriter

from cartgrasp.errors import FileError, LogError
from cartgrasp.logs import read_log
from cartgrasp.logs.bags.messages import ODOMETRY_TYPE, TF_TYPE, WRENCH_TYPE, Sample, encode, encode_transforms
from cartgrasp.logs.bags.opening import open_bag, read_bag

from . import bag_files as files
from .bag_files import MAP, push, stamp

FROM_TF = """\
pose: {topic: /tf, frame: map, child: base_link}
arms: {left: {topic: /left/wrench, contact: {topic: /tf_static, frame: base_link, child: hand}, force: on_cart}}
"""


def mapped(path, text=MAP):
    path.with_name(f"{path.name}.topics.yaml").write_text(text, encoding="utf-8")
    return path


def changed(every, change):
    """A push in which `change` was done to each `every`-th odometry message, from the second on."""
    messages, seen = push(), 0
    for _, kind, _, value in messages:
        if kind == files.ODOMETRY:
            change(value) if seen % every == 1 else None
            seen += 1
    return messages


def others_left_out(path, why):
    """Refused as it is; the salvaged reading, whose rows are those of a bag that never had the odd messages."""
    with pytest.raises(LogError, match=rf"/odom: message 2: {why}.*--salvage"):
        read_log(path)
    reading = read_bag(path, salvage=True)
    kept = [m for i, m in enumerate(push()) if i % 2 or (i // 2) % 3 != 1]
    plain = read_log(mapped(files.write_mcap(path.with_name("plain.mcap"), kept)))
    assert np.array_equal(reading.log.table, plain.table, equal_nan=True)
    return reading.lost


def test_poses_in_two_frames(tmp_path):
    def change(value):
        value["header"]["frame_id"] = "map"

    path = mapped(files.write_mcap(tmp_path / "run.mcap", changed(3, change)))
    lost = others_left_out(path, r"is in the frames 'map' → 'base_link', most others in 'odom' → 'base_link'")
    assert lost == ("/odom: 33 samples are in other frames than 'odom' → 'base_link'",)


def test_two_sensors_on_one_topic(tmp_path):
    messages = push()
    for i, (_, kind, _, value) in enumerate(messages):
        if kind == files.WRENCH:
            value["header"]["frame_id"] = "left" if i % 4 == 1 else "right"
    with pytest.raises(LogError, match=r"/left/wrench: message \d+: is in the frames '(left|right)', most others in"):
        read_log(mapped(files.write_mcap(tmp_path / "run.mcap", messages)))


@pytest.mark.parametrize("second", [0, 5, 1_900_000_000])
def test_stamps_of_another_year(tmp_path, second):
    def change(value):
        value["header"]["stamp"]["sec"] = second

    path = mapped(files.write_mcap(tmp_path / "run.mcap", changed(3, change)))
    days = round((second - files.START) / 86_400)
    lost = others_left_out(
        path, rf"its header's stamp is \{days:+d} days from those of most others \(`stamps: receive`"
    )
    assert lost == ("/odom: 33 samples are stamped days from the others",)
    text = MAP + "stamps: receive\n"
    path.with_name(f"{path.name}.topics.yaml").write_text(text, encoding="utf-8")
    assert len(read_log(path)) == 100


def of_bytes(path, entries, profile="ros2"):
    """An MCAP of (topic, type, bytes, ns), whatever they are."""
    with open(path, "wb") as stream:
        writer, schemas, channels = McapWriter(stream), {}, {}
        writer.start(profile=profile)
        for topic, kind, raw, ns in entries:
            if kind not in schemas:
                schemas[kind] = writer.register_schema(kind, "ros2msg", b"")
            if (topic, kind) not in channels:
                channels[topic, kind] = writer.register_channel(topic, "cdr", schemas[kind])
            writer.add_message(channels[topic, kind], ns, raw, ns)
        writer.finish()
    return path


def rows(*makers, n=50):
    return [make(stamp(0.02 * i)) for i in range(n) for make in makers]


def odom(ns):
    numbers = (0.0,) * 6 + (1.0,) + (0.0,) * 6
    return "/odom", ODOMETRY_TYPE, encode(Sample(ns, "odom", "base_link", numbers), ODOMETRY_TYPE), ns


def wrench(ns, topic="/left/wrench"):
    return topic, WRENCH_TYPE, encode(Sample(ns, "sensor", "", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)), WRENCH_TYPE), ns


def transform(frame, child, topic="/tf", x=0.0):
    def make(ns):
        sample = Sample(ns, frame, child, (x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
        return topic, TF_TYPE, encode_transforms([sample]), ns

    return make


def test_a_second_type_on_a_topic_is_told(tmp_path):
    path = mapped(of_bytes(tmp_path / "run.mcap", rows(odom, wrench, lambda ns: ("/left/wrench", *odom(ns)[1:]))))
    with pytest.raises(LogError, match=r"/left/wrench: has messages of two types, .*--salvage"):
        read_log(path)
    reading = read_bag(path, salvage=True)
    assert reading.lost == ("/left/wrench: 50 messages of another type, nav_msgs/msg/Odometry",)
    assert len(reading.log) == 50
    bag = open_bag(path, salvage=True)
    assert len(list(bag.messages({"/odom"}))) == 50
    assert bag.lost == []


def test_another_profile(tmp_path):
    path = mapped(of_bytes(tmp_path / "run.mcap", rows(odom, wrench), profile=""))
    with pytest.raises(LogError, match=r"has the profile '', not 'ros2'.*--salvage"):
        read_log(path)
    assert len(read_bag(path, salvage=True).log) == 50


def test_a_static_transform_holds_for_the_whole_run(tmp_path):
    """Whenever it was sent and stamped: a latched one is stamped when its sender began, days ago or never."""
    entries = rows(transform("map", "base_link"), wrench)
    for sent in (0, stamp(-1e6), stamp(0.7)):
        static = ("/tf_static", *transform("base_link", "hand", x=-0.25)(sent)[1:3], stamp(0.5))
        path = mapped(of_bytes(tmp_path / "run.mcap", [*entries, static]), FROM_TF)
        reading = read_bag(path)
        assert np.array_equal(reading.log.arms["left"].contact, np.tile([-0.25, 0.0, 0.0], (50, 1)))
        assert any(step.what == "contact point from a static transform" for step in reading.steps)


def test_a_static_transform_that_changes(tmp_path):
    entries = rows(transform("map", "base_link"), wrench)
    sent = [transform("base_link", "hand", "/tf_static", x)(stamp(t)) for x, t in ((0.1, 0), (0.2, 0.1), (0.2, 0.2))]
    path = mapped(of_bytes(tmp_path / "run.mcap", [*entries, *sent]), FROM_TF)
    with pytest.raises(
        LogError, match=r"/tf_static: message 1: holds another transform than was sent later.*--salvage"
    ):
        read_log(path)
    reading = read_bag(path, salvage=True)
    assert reading.log.arms["left"].contact[0, 0] == 0.2
    assert reading.lost == ("/tf_static: 1 samples are not the static transform that was sent last",)


def test_a_transform_that_is_not_there_is_told_with_those_that_are(tmp_path):
    entries = rows(transform("map", "odom"), transform("odom", "base"), wrench)
    path = mapped(of_bytes(tmp_path / "run.mcap", [*entries, transform("a", "b", "/tf_static")(0)]), FROM_TF)
    with pytest.raises(FileError, match=r"run\.mcap has no frame base_link, but base, b, a, map, odom"):
        read_log(path)


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("velocity: twist", "velocity: twist, body: [1.0e+300, 0, 0]", r"pose\.body\.0: 1e\+300 is not <= "),
        ("on_cart", "on_cart, sensor: {position: [0, -1.0e+300, 0]}", r"position\.1: -1e\+300 is not >= "),
        ("on_cart", "on_cart, tool: {mass: 1.0e+300, com: [0, 0, 0]}", r"tool\.mass: 1e\+300 is not <= "),
        ("twist", "spline, noise: {position: 1.0e+300, heading: 1}", r"noise\.position: 1e\+300 is not <= "),
        ("clock: pose", "clock: 100000", r"clock: 100000 is not <= 10000"),
        ("[-0.25, 0.2, 1.0]", "{topic: /tf, frame: base_link}", r"contact\.child: is missing"),
    ],
)
def test_numbers_beyond_reason(tmp_path, old, new, place):
    assert old in MAP
    with pytest.raises(FileError, match=place):
        read_log(mapped(files.write_mcap(tmp_path / "run.mcap", push(0.5)), MAP.replace(old, new)))


@pytest.mark.parametrize("name", ["run.mcap", "run.db3", "run.bag"])
def test_where_nothing_can_be_read_the_map_is_not_to_blame(tmp_path, name):
    path = mapped(tmp_path / name)
    path.write_bytes(b"")
    with pytest.raises(LogError, match="has no topic that can be read"):
        read_bag(path, salvage=True)
