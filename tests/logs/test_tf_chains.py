"""Poses along chains of TF in bags of other libraries: map → odom → base_link as robots send it; what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cartgrasp.errors import FileError, LogError
from cartgrasp.logs.bags.opening import read_bag

from . import bag_files as files
from .bag_files import TF, WRENCH, force_of, path_of, stamp

MAP = """\
pose: {topic: /tf, frame: map, child: base_link}
arms: {left: {topic: /left/wrench, contact: [-0.25, 0.2, 1.0], force: on_cart}}
max_gap: 0.25
"""
FOOTPRINT = (0.3, -0.1, 0.4)
"""Planar pose of base_link in base_footprint."""
JUMP = 1.0


def matrix(pose):
    """Of a planar pose, by hand."""
    x, y, yaw = pose
    return np.array([[math.cos(yaw), -math.sin(yaw), x], [math.sin(yaw), math.cos(yaw), y], [0, 0, 1]])


def planar(m):
    return [m[0, 2], m[1, 2], math.atan2(m[1, 0], m[0, 0])]


def drift(t):
    """Pose of odom in map: localisation finds the robot elsewhere at JUMP."""
    return (0.4, -0.3, 0.2) if t < JUMP else (0.9, 0.1, -0.3)


def wrenches(duration=2.0):
    return [
        ("/left/wrench", WRENCH, stamp(t), files.wrench(stamp(t), force_of(t))) for t in np.arange(0, duration, 0.02)
    ]


def robot(topic="/tf", slow=0.2, slash="", duration=2.0):
    """map → odom now and then, odom → base_footprint at 50 Hz, base_link fixed in it; base_link goes along path_of."""
    messages = wrenches(duration)
    for t in np.arange(0, duration, 0.02):
        base = matrix(path_of(t)[0]) @ np.linalg.inv(matrix(FOOTPRINT))
        in_odom = planar(np.linalg.inv(matrix(drift(t))) @ base)
        sent = files.transforms(stamp(t), (f"{slash}odom", f"{slash}base_footprint", in_odom))
        messages.append((topic, TF, stamp(t), sent))
    for t in np.arange(0, duration + slow / 2, slow):
        messages.append((topic, TF, stamp(t), files.transforms(stamp(t), (f"{slash}map", f"{slash}odom", drift(t)))))
    fixed = files.transforms(0, (f"{slash}base_footprint", f"{slash}base_link", FOOTPRINT))
    messages.append((f"{topic}_static", TF, stamp(0.5), fixed))
    return sorted(messages, key=lambda m: m[2])


def direct(duration=2.0):
    sent = [(t, files.transforms(stamp(t), ("map", "base_link", path_of(t)[0]))) for t in np.arange(0, duration, 0.02)]
    return sorted([*wrenches(duration), *(("/tf", TF, stamp(t), m) for t, m in sent)], key=lambda m: m[2])


def read(tmp_path, messages, text=MAP, write=files.write_mcap, name="run.mcap", **options):
    bag = write(tmp_path / name, messages)
    bag.with_name(f"{name}.topics.yaml").write_text(text, encoding="utf-8")
    return read_bag(bag, **options)


def same(log, other, rows=slice(None)):
    assert log.time == pytest.approx(other.time, abs=2e-9)
    assert log.pose[rows, :2] == pytest.approx(other.pose[rows, :2], abs=1e-12)
    turned = (log.pose - other.pose)[rows, 2]
    assert np.exp(1j * turned) == pytest.approx(np.ones(len(turned)), abs=1e-12)
    assert np.array_equal(log.arms["left"].wrench, other.arms["left"].wrench)


def test_a_chain_is_the_direct_transform(tmp_path):
    """But between the two transforms around the jump, where the pose is on its way from one to the other."""
    reading, other = read(tmp_path, robot()), read(tmp_path, direct(), name="direct.mcap")
    t = np.arange(0, 2, 0.02)
    around = (t > JUMP - 0.2 + 1e-9) & (t < JUMP - 1e-9)
    same(reading.log, other.log, ~around)
    share = (t[around] - (JUMP - 0.2)) / 0.2
    for row, ti, s in zip(reading.log.pose[around], t[around], share, strict=True):
        between = (1 - s) * np.array(drift(0)) + s * np.array(drift(2))
        expected = matrix(between) @ np.linalg.inv(matrix(drift(ti))) @ matrix(path_of(ti)[0])
        assert matrix(row) == pytest.approx(expected, abs=1e-9)
    said = [str(step) for step in reading.steps]
    for part in (
        "/tf map → odom: tf2_msgs/msg/TFMessage (role pose, samples 11,",
        "/tf odom → base_footprint: tf2_msgs/msg/TFMessage (role pose, samples 100,",
        "/tf_static base_footprint → base_link: tf2_msgs/msg/TFMessage (role pose, samples 1,",
        "/tf map → odom: at the stamps of /tf odom → base_footprint (taken 10, interpolated 90, masked 0)",
        "pose: map → odom → base_footprint → base_link composed (links 3, samples 100, left out 0, missing 0)",
    ):
        assert sum(step.startswith(part) for step in said) == 1, (part, said)


@pytest.mark.parametrize("kind", ["ROS 1, with slashes", "SQLite", "a namespace"])
def test_of_other_bags(tmp_path, kind):
    other = read(tmp_path, direct(0.8), name="direct.mcap").log
    if kind == "a namespace":
        text = MAP.replace("/tf", "/robot/tf")
        log = read(tmp_path, robot("/robot/tf", duration=0.8), text).log
    elif kind == "SQLite":
        log = read(tmp_path, robot(duration=0.8), write=files.write_folder, name="run").log
    else:
        log = read(tmp_path, robot(slash="/", duration=0.8), write=files.write_ros1, name="run.bag").log
    same(log, other)


def inverse(pose):
    return planar(np.linalg.inv(matrix(pose)))


def test_links_in_the_other_direction(tmp_path):
    """A filter that sends base_link → odom, and a map asked for in the cart."""
    messages = wrenches()
    for t in np.arange(0, 2, 0.02):
        sent = ("base_link", "odom", inverse(path_of(t)[0]))
        messages.append(("/tf", TF, stamp(t), files.transforms(stamp(t), sent)))
    log = read(tmp_path, messages, MAP.replace("map", "odom")).log
    same(log, read(tmp_path, direct(), name="direct.mcap").log)
    turned = read(tmp_path, direct(), MAP.replace("map, child: base_link", "base_link, child: map")).log
    assert turned.pose[:, :2] == pytest.approx(np.array([inverse(p)[:2] for p in path_of(turned.time)[0]]), abs=1e-8)


def test_a_gap_in_one_link_is_a_gap(tmp_path):
    """map → odom falls silent for 0.6 s: no row in between, whatever odom says."""
    silent = [m for m in robot() if not (is_link(m, "map", "odom") and stamp(0.5) < m[2] < stamp(0.9))]
    reading = read(tmp_path, silent)
    t = reading.log.time
    assert np.array_equal(np.isnan(reading.log.pose).all(axis=1), (t > 0.401) & (t < 0.999))
    step = next(s for s in reading.steps if "at the stamps" in s.what and s.of == "/tf map → odom")
    assert step.figures == {"taken": 8, "interpolated": 63, "masked": 29}


def is_link(message, frame, child):
    (part,) = message[3]["transforms"] if message[1] == TF else (None,)
    return part is not None and (part["header"]["frame_id"], part["child_frame_id"]) == (frame, child)


def test_rows_are_where_all_links_are(tmp_path):
    late = [m for m in robot() if not (is_link(m, "map", "odom") and m[2] < stamp(0.3))]
    reading = read(tmp_path, late)
    assert len(reading.log) == 80
    composed = next(s for s in reading.steps if "composed" in s.what)
    assert composed.figures == {"links": 3, "samples": 80, "left out": 20, "missing": 0}
    early = [m for m in robot() if not is_link(m, "map", "odom") or m[2] < stamp(0.5)]
    early = [m for m in early if not is_link(m, "odom", "base_footprint") or m[2] > stamp(0.6)]
    why = r"run\.mcap: the transforms of pose have no time in common: /tf map → odom from -0\.\d+ to "
    with pytest.raises(LogError, match=why):
        read(tmp_path, early)


def test_latency_and_receipt(tmp_path):
    """Both count for each link."""
    text = MAP.replace("child: base_link", "child: base_link, latency: 0.1")
    log = read(tmp_path, robot(), text + f"epoch: {stamp(0)}\n").log
    assert log.pose == pytest.approx(read(tmp_path, robot()).log.pose[5:], abs=1e-12)
    assert log.time[0] == pytest.approx(0.0, abs=1e-9)
    unstamped = [m for m in robot() if m[1] == WRENCH]
    for topic, kind, ns, value in robot():
        if kind == TF:
            part = value["transforms"][0]
            head = part["header"] | {"stamp": {"sec": 0, "nanosec": 0}}
            unstamped.append((topic, kind, ns, {"transforms": [part | {"header": head}]}))
    with pytest.raises(FileError, match="stamps: the headers of /tf have no stamps; use receive"):
        read(tmp_path, unstamped)
    same(read(tmp_path, unstamped, MAP + "stamps: receive\n").log, read(tmp_path, robot()).log)


@pytest.mark.parametrize("moves", [True, False])
def test_a_contact_along_a_chain(tmp_path, moves):
    """base_link → arm → hand; the arm's base is fixed, the hand is, or is not."""
    messages = robot()
    for t in np.arange(0, 2, 0.02):
        hand = files.transforms(stamp(t), ("arm", "hand", (0.5, 0.1 * t * moves, math.pi)))
        messages.append(("/tf" if moves else "/tf_static", TF, stamp(t), hand))
    messages.append(
        ("/tf_static", TF, stamp(1), files.transforms(stamp(1), ("base_link", "arm", (-0.2, 0, math.pi / 2))))
    )
    text = MAP.replace("[-0.25, 0.2, 1.0]", "{topic: /tf, frame: base_link, child: hand}")
    reading = read(tmp_path, messages, text)
    t = reading.log.time
    expected = np.column_stack([-0.2 - 0.1 * t * moves, 0 * t + 0.5, 0 * t])
    assert reading.log.arms["left"].contact == pytest.approx(expected, abs=1e-9)
    assert any("base_link → arm → hand composed" in str(step) for step in reading.steps)
    assert any("from a static transform" in step.what for step in reading.steps) != moves


# --- what is refused -------------------------------------------------------------------------------------------


def also(topic, *parts):
    return [(topic, TF, stamp(0.5), files.transforms(stamp(0.5), part)) for part in parts]


def refused(tmp_path, messages, error, why, text=MAP):
    with pytest.raises(error, match=why) as caught:
        read(tmp_path, messages, text)
    assert len(str(caught.value).splitlines()) == 1
    assert "run.mcap" in str(caught.value)


def test_two_parents_are_refused_and_salvage_takes_the_usual_one(tmp_path):
    messages = robot() + also("/tf", ("map", "base_footprint", FOOTPRINT))
    why = r"run\.mcap: /tf: the frame base_footprint has two parents, map in /tf and odom in /tf; .*--salvage"
    refused(tmp_path, messages, LogError, why)
    reading = read(tmp_path, messages, salvage=True)
    same(reading.log, read(tmp_path, robot(), name="plain.mcap").log)
    assert reading.lost == ("/tf map → base_footprint: 1 transforms; most others are /tf odom → base_footprint",)


def test_a_loop_is_refused(tmp_path):
    messages = robot() + also("/tf", ("base_footprint", "odom", FOOTPRINT))
    messages = [m for m in messages if not is_link(m, "map", "odom")]
    text = MAP.replace("map", "odom").replace("odom, child", "map, child")
    messages += also("/tf", ("map", "elsewhere", FOOTPRINT))
    refused(tmp_path, messages, LogError, r"/tf: the frames base_footprint → odom → base_footprint are a loop", text)


def test_a_broken_chain_is_refused(tmp_path):
    messages = [m for m in robot() if not is_link(m, "odom", "base_footprint")]
    why = (
        r"topics\.yaml:1:1: pose: /tf with /tf_static of .*run\.mcap holds no chain from map to base_link: neither map "
        r"nor base_footprint \(above base_link\) has a parent; its frames are base_footprint, base_link, map, odom$"
    )
    refused(tmp_path, messages, FileError, why)
    alone = [m for m in messages if m[0] != "/tf_static"] + also("/tf", ("base_link", "hand", FOOTPRINT))
    refused(tmp_path, alone, FileError, "neither map nor base_link has a parent")
    refused(tmp_path, robot(), FileError, "has no frame base, but base_link, ", MAP.replace("base_link", "base"))
    refused(tmp_path, robot(), FileError, "where map is in itself", MAP.replace("base_link", "map"))


def test_links_that_never_move_or_seldom(tmp_path):
    slow = MAP.replace("0.25", "0.15")
    refused(tmp_path, robot(), FileError, r"max_gap: /tf map → odom has a transform every 0\.2 s, .*a longer", slow)
    once = [m for m in robot() if not is_link(m, "map", "odom")] + also("/tf", ("map", "odom", FOOTPRINT))
    refused(tmp_path, once, LogError, r"/tf map → odom: was sent once; one that holds for ever is one of tf_static")
    fixed = MAP.replace("frame: map", "frame: base_footprint")
    for text in (fixed, fixed.replace("/tf", "/tf_static")):
        why = "nothing moves between base_footprint and base_link: /tf_static base_footprint → base_link is static"
        refused(tmp_path, robot(), FileError, why, text)
