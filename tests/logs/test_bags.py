"""Bags of other libraries become the log that was recorded; what a map says of stamps, frames and signs is done."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode

from cartgrasp.errors import CartgraspError, FileError, LogError, UsageError
from cartgrasp.logs import read_log, write_log
from cartgrasp.logs.bags.opening import read_bag

from . import bag_files as files
from .bag_files import MAP, force_of, path_of, push, stamp


def mapped(path, text=MAP):
    path.with_name(f"{path.name}.topics.yaml").write_text(text, encoding="utf-8")
    return path


def compressed(path, messages, mode):
    return files.write_folder(path, messages, compression=(mode, CompressionFormat.ZSTD))


WRITERS = {
    "mcap-ros2-support, zstd": ("run.mcap", files.write_mcap),
    "mcap-ros2-support, lz4": ("run.mcap", lambda p, m: files.write_mcap(p, m, "lz4")),
    "mcap-ros2-support, none": ("run.mcap", lambda p, m: files.write_mcap(p, m, "none")),
    "rosbags, SQLite": ("run", files.write_folder),
    "rosbags, MCAP": ("run", lambda p, m: files.write_folder(p, m, "mcap")),
    "rosbags, messages compressed": ("run", lambda p, m: compressed(p, m, CompressionMode.MESSAGE)),
    "rosbags, file compressed": ("run", lambda p, m: compressed(p, m, CompressionMode.FILE)),
    "an old SQLite file": ("run.db3", files.write_old_sqlite),
    "ROS 1": ("run.bag", files.write_ros1),
    "ROS 1, bz2": ("run.bag", lambda p, m: files.write_ros1(p, m, Ros1Writer.CompressionFormat.BZ2)),
    "ROS 1, lz4": ("run.bag", lambda p, m: files.write_ros1(p, m, Ros1Writer.CompressionFormat.LZ4)),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_a_bag_of_another_library(tmp_path, kind):
    name, write = WRITERS[kind]
    log = read_log(mapped(write(tmp_path / name, push())))
    t = np.arange(0, 2, 0.02)
    rows, rate = path_of(t)
    assert log.time == pytest.approx(t, abs=2e-9)
    assert log.pose == pytest.approx(rows, abs=1e-12)
    assert log.velocity == pytest.approx(rate, abs=1e-12)
    assert np.array_equal(log.arms["left"].wrench, force_of(t))
    assert np.array_equal(log.arms["left"].contact, np.tile([-0.25, 0.2, 1.0], (len(t), 1)))
    assert any("samples 100" in step for step in log.notes.values())


def test_a_folder_without_metadata_and_in_two_files(tmp_path):
    messages = push()
    first = files.write_folder(tmp_path / "run", messages[:120])
    second = files.write_folder(tmp_path / "rest", messages[120:])
    shutil.move(second / "rest.db3", first / "run_1.db3")
    (first / "metadata.yaml").unlink()
    (first / "topics.yaml").write_text(MAP)
    log = read_log(first)
    assert np.array_equal(log.arms["left"].wrench, force_of(np.arange(0, 2, 0.02)))


def test_which_map_is_taken(tmp_path):
    bag = files.write_mcap(tmp_path / "run.mcap", push())
    with pytest.raises(LogError, match=r"run\.mcap: no topic map .*`cartgrasp topics .*run\.mcap --out "):
        read_log(bag)
    named = {"folder": tmp_path / "topics.yaml", "own": tmp_path / "run.mcap.topics.yaml", "given": tmp_path / "a.yaml"}
    for arm, path in named.items():
        path.write_text(MAP.replace("left:", f"{arm}:"))
        given = {"topics": path} if arm == "given" else {}
        assert list(read_log(bag, **given).arms) == [arm]
    with pytest.raises(UsageError, match="no bag"):
        read_log(write_log(read_log(bag), tmp_path / "run.csv"), topics=named["given"])
    log = read_log(write_log(read_log(bag), tmp_path / "own.mcap"))  # the map in it counts for more than the folder's
    assert list(log.arms) == ["own"]


# --- what a map says ------------------------------------------------------------------------------------------


def read(tmp_path, messages, text, **options):
    bag = mapped(files.write_mcap(tmp_path / "run.mcap", messages), text)
    return read_bag(bag, **options)


def rotation(rpy):
    """By axis and angle, one after another about fixed axes (Rodrigues)."""
    total = np.eye(3)
    for axis, angle in zip(np.eye(3), rpy, strict=True):
        k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        total = (np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k) @ total
    return total


@pytest.mark.parametrize("seed", range(4))
def test_sensor_frame_sign_tool_and_tare(tmp_path, seed):
    """A sensor that feels the push back and the tool's weight, and has an offset: what is on the cart comes out."""
    rng = np.random.default_rng(seed)
    position, rpy, com = rng.uniform(-0.3, 0.3, 3), rng.uniform(-1.5, 1.5, 3), rng.uniform(-0.1, 0.1, 3)
    offset, mass = rng.normal(size=6), 0.8
    R = rotation(rpy)  # of the sensor's frame in {a}
    t = np.arange(0, 3, 0.01)
    moving = np.maximum(t - 1, 0)
    wrench_a = force_of(t) * (t[:, None] > 1)
    messages = []
    for i, ti in enumerate(t):
        force, moment = wrench_a[i, :3], wrench_a[i, 3:]
        weight = mass * 9.81 * np.array([0, 0, -1.0])
        given = force - weight  # the hand holds the tool up and pushes the cart
        about_sensor = moment - np.cross(position, force) - np.cross(R @ com, weight)
        reading = -np.concatenate([R.T @ given, R.T @ about_sensor]) + offset
        pose = path_of(moving[i])[0]
        messages.append(("/pose", files.POSE, stamp(ti), files.pose(stamp(ti), pose)))
        messages.append(("/wrench", files.WRENCH, stamp(ti), files.wrench(stamp(ti), reading)))
    text = f"""\
pose: {{topic: /pose}}
arms:
  hand:
    topic: /wrench
    contact: [0, 0, 1]
    force: on_sensor
    sensor: {{position: {position.tolist()}, rpy: {rpy.tolist()}}}
    tool: {{mass: {mass}, com: {com.tolist()}}}
    tare: [0.0, 0.95]
"""
    reading = read(tmp_path, messages, text)
    assert reading.log.arms["hand"].wrench == pytest.approx(wrench_a, abs=1e-12)
    done = [step.what for step in reading.steps if step.of == "hand"]
    assert [what.split()[0] for what in done] == ["signs", "weight", "tare", "from", "wrenches"]
    without = text.replace("    tare: [0.0, 0.95]\n", "")
    found = read(tmp_path, messages, without).log.arms["hand"].wrench - wrench_a
    assert np.ptp(found, axis=0) == pytest.approx(np.zeros(6), abs=1e-12)
    assert found[0, :3] == pytest.approx(R @ -offset[:3], abs=1e-12)


def test_a_tare_while_the_cart_moves_is_refused(tmp_path):
    text = MAP.replace("force: on_cart", "force: on_cart, tare: [0.0, 1.0]")
    with pytest.raises(FileError, match=r"arms\.left\.tare: the cart moves \d+ mm"):
        read(tmp_path, push(), text)
    with pytest.raises(FileError, match=r"arms\.left\.tare: 0 readings in it"):
        read(tmp_path, push(), text.replace("[0.0, 1.0]", "[5.0, 6.0]"))


def test_latency_is_taken_off_and_receipt_can_count(tmp_path):
    messages = []
    for t in np.arange(0, 2, 0.01):
        messages.append(("/odom", files.ODOMETRY, stamp(t), files.odometry(stamp(t), path_of(t)[0], [0, 0, 0])))
        late = stamp(t + 0.04)
        messages.append(("/left/wrench", files.WRENCH, late, files.wrench(late, force_of(t))))
    messages.sort(key=lambda m: m[2])
    text = MAP.replace("force: on_cart", "force: on_cart, latency: 0.04").replace("twist", "none")
    reading = read(tmp_path, messages, text)
    assert len(reading.log) == 200
    assert reading.log.velocity is None
    assert reading.log.arms["left"].wrench == pytest.approx(force_of(reading.log.time), abs=1e-9)
    for kind in ("header", "receive"):
        log = read(tmp_path, push(late=0.5), MAP + f"stamps: {kind}\nepoch: {stamp(0)}\n").log
        assert log.time[0] == pytest.approx(0.5 if kind == "receive" else 0.0, abs=1e-9)
    unstamped = [(topic, kind, ns, unstamp(value)) for topic, kind, ns, value in push()]
    with pytest.raises(FileError, match="stamps: the headers of /odom have no stamps; use receive"):
        read(tmp_path, unstamped, MAP)
    assert len(read(tmp_path, unstamped, MAP + "stamps: receive\n").log) == 100


def unstamp(value):
    return value | {"header": value["header"] | {"stamp": {"sec": 0, "nanosec": 0}}}


def test_gaps_are_masked_never_bridged(tmp_path):
    """A wrench that falls silent for 0.4 s, and one message that says nan."""
    messages = [m for m in push() if not (m[0] == "/left/wrench" and stamp(0.51) < m[2] < stamp(0.91))]
    where = next(i for i, m in enumerate(messages) if m[0] == "/left/wrench" and m[2] > stamp(1.5))
    topic, kind, ns, _ = messages[where]
    messages[where] = (topic, kind, ns, files.wrench(ns - 3_000_000, [np.nan] * 6))
    log = read(tmp_path, messages, MAP).log
    silent = (log.time > 0.511) & (log.time < 0.909)
    silent |= np.abs(log.time - 1.5) < 0.001
    assert np.array_equal(np.isnan(log.arms["left"].wrench).all(axis=1), silent)
    assert np.array_equal(log.arms["left"].wrench[~silent], force_of(np.arange(0, 2, 0.02))[~silent])
    held = read(tmp_path, messages, MAP.replace("max_gap: 0.1", "max_gap: 0.5")).log  # bridged where that is asked for
    assert np.isnan(held.arms["left"].wrench).all(axis=1).sum() == 1


def test_a_faster_sensor_is_averaged_and_no_sample_counts_twice(tmp_path):
    rng = np.random.default_rng(2)
    noise = rng.normal(size=(2000, 6))
    messages = [m for m in push() if m[0] == "/odom"]
    for i in range(2000):
        t = 0.001 * i + 0.0003
        messages.append(("/left/wrench", files.WRENCH, stamp(t), files.wrench(stamp(t), noise[i])))
    log = read(tmp_path, sorted(messages, key=lambda m: m[2]), MAP).log
    rows = log.arms["left"].wrench[2:-2]
    assert rows.std() == pytest.approx(1 / 20**0.5, rel=0.15)
    assert abs(np.mean(rows[1:] * rows[:-1])) < 0.01
    for i in (10, 50):
        near = np.abs(0.001 * np.arange(2000) + 0.0003 - log.time[i] - read_epoch(log)) < 0.01
        assert log.arms["left"].wrench[i] == pytest.approx(noise[near].mean(axis=0), abs=1e-12)
    at_rate = read(tmp_path, sorted(messages, key=lambda m: m[2]), MAP.replace("clock: pose", "clock: 10.0")).log
    assert np.diff(at_rate.time) == pytest.approx(np.full(len(at_rate) - 1, 0.1), abs=1e-9)
    epoch = read_epoch(at_rate)
    assert at_rate.pose == pytest.approx(path_of(at_rate.time + epoch)[0], abs=2e-4)


def read_epoch(log):
    """The log's zero in s from the recording's start."""
    text = next(step for step in log.notes.values() if "epoch ns" in step)
    return (int(text.split("epoch ns ")[1].split(",")[0]) - stamp(0)) / 1e9


@pytest.mark.parametrize("source", ["pose", "tf"])
def test_velocity_by_spline_beats_differences_tenfold(tmp_path, source):
    rng = np.random.default_rng(4)
    t = np.sort(np.arange(0, 20, 0.01) + rng.uniform(-0.002, 0.002, 2000))
    rows, rate = path_of(t)
    noisy = rows + rng.normal(0, [0.001, 0.001, 0.002], (2000, 3))
    messages = []
    for i, ti in enumerate(t):
        ns = stamp(ti)
        if source == "pose":
            messages.append(("/pose", files.POSE, ns, files.pose(ns, noisy[i])))
        else:
            parts = [("map", "odom", [9.0, 9.0, 1.0]), ("odom", "base", noisy[i])]
            messages.append(("/pose", files.TF, ns, files.transforms(ns, *parts)))
        messages.append(("/left/wrench", files.WRENCH, ns, files.wrench(ns, force_of(ti))))
    frames = "" if source == "pose" else "frame: odom, child: base, "
    text = MAP.replace(
        "{topic: /odom, velocity: twist}",
        f"{{topic: /pose, {frames}velocity: spline, noise: {{position: 0.001, heading: 0.002}}}}",
    )
    log = read(tmp_path, messages, text).log
    assert log.pose == pytest.approx(noisy, abs=1e-12)  # through whole turns: yaw is unwrapped
    assert np.ptp(log.pose[:, 2]) > 6 * np.pi / 2
    spline = np.sqrt(np.mean((log.velocity - rate) ** 2, axis=0))
    plain = np.sqrt(np.mean((np.gradient(noisy, t, axis=0) - rate) ** 2, axis=0))
    assert (plain > 10 * spline).all()


def test_a_spline_ends_at_a_gap(tmp_path):
    messages = [m for m in push(4.0) if not stamp(1.5) < m[2] < stamp(2.5)]
    noise = "velocity: spline, noise: {position: 0.0001, heading: 0.0001}"
    whole = read(tmp_path, push(4.0), MAP.replace("velocity: twist", noise)).log
    log = read(tmp_path, messages, MAP.replace("velocity: twist", noise)).log
    assert np.isfinite(log.velocity).all()
    assert log.velocity == pytest.approx(path_of(log.time)[1], abs=0.2)
    few = [m for m in push(4.0) if not stamp(1.5) < m[2] < stamp(2.5) or stamp(2.0) < m[2] < stamp(2.1)]
    log = read(tmp_path, few, MAP.replace("velocity: twist", noise)).log
    lonely = (log.time > 1.9) & (log.time < 2.2)
    assert 0 < lonely.sum() < 8
    assert np.array_equal(np.isnan(log.velocity).all(axis=1), lonely)
    assert len(whole) == 200


def test_the_body_in_the_tracked_frame(tmp_path):
    """A marker 0.4 m ahead, 0.1 m to the left and turned by 0.3 rad tells pose and velocity of {b} all the same."""
    marker = np.array([0.4, 0.1, 0.3])  # pose of the marker in {b}
    messages = []
    for t in np.arange(0, 2, 0.02):
        rows, rate = path_of(t)
        c, s = np.cos(rows[2]), np.sin(rows[2])
        arm = np.array([c * marker[0] - s * marker[1], s * marker[0] + c * marker[1]])
        tracked = np.array([*(rows[:2] + arm), rows[2] + marker[2]])
        moving = np.array([rate[0] - rate[2] * arm[1], rate[1] + rate[2] * arm[0], rate[2]])
        ns = stamp(t)
        messages.append(("/odom", files.ODOMETRY, ns, files.odometry(ns, tracked, files.in_body(moving, tracked[2]))))
        messages.append(("/left/wrench", files.WRENCH, ns, files.wrench(ns, force_of(t))))
    c, s = np.cos(marker[2]), np.sin(marker[2])
    body = [float(v) for v in (-c * marker[0] - s * marker[1], s * marker[0] - c * marker[1], -marker[2])]
    log = read(tmp_path, messages, MAP.replace("velocity: twist", f"velocity: twist, body: {body}")).log
    rows, rate = path_of(np.arange(0, 2, 0.02))
    assert log.pose == pytest.approx(rows, abs=1e-12)
    assert log.velocity == pytest.approx(rate, abs=1e-12)


def test_stamps_out_of_order_and_repeated(tmp_path):
    messages = push()
    messages[40:44] = messages[42:44] + messages[40:42]
    messages.insert(60, messages[58])
    shuffled = [(topic, kind, stamp(1e-3 * i), value) for i, (topic, kind, _, value) in enumerate(messages)]
    reading = read(tmp_path, shuffled, MAP)
    assert np.array_equal(reading.log.arms["left"].wrench, force_of(np.arange(0, 2, 0.02)))
    odom = next(step for step in reading.steps if step.of == "/odom")
    assert (odom.figures["out of order"], odom.figures["repeated stamps"]) == (1, 1)


MISTAKES = {
    "unknown key": (MAP + "rates: 3\n", r":6:1: rates: unknown key; known are pose, arms"),
    "unknown key within": (MAP.replace("force:", "latncy: 1, force:"), r":3:.*arms\.left\.latncy: .*mean latency"),
    "no contact": (MAP.replace("contact: [-0.25, 0.2, 1.0]", "contact: "), r"arms\.left\.contact: is not stated"),
    "no sign": (MAP.replace("on_cart", ""), r"arms\.left\.force: is not stated"),
    "a wrong sign": (MAP.replace("on_cart", "on_kart"), r"arms\.left\.force: "),
    "no such topic": (MAP.replace("/left/wrench", "/left/wrnch"), r"arms\.left\.topic: .*did you mean /left/wrench"),
    "another type": (
        MAP.replace("/left/wrench", "/odom"),
        r"/odom holds nav_msgs/msg/Odometry; needed is geometry_msgs",
    ),
    "frames of no TF": (MAP.replace("/odom,", "/odom, frame: map,"), r"pose\.frame: is for TF topics"),
    "a clock of nobody": (MAP.replace("clock: pose", "clock: right"), r"clock: 'right' is neither"),
    "a gap shorter than a step": (
        MAP.replace("0.1", "0.01", 1).replace("max_gap: 0.1", "max_gap: 0.01"),
        "max_gap: pose has",
    ),
    "no noise for a spline": (MAP.replace("twist", "spline"), r"pose\.noise: is missing"),
    "infinite": (MAP.replace("max_gap: 0.1", "max_gap: .inf"), "max_gap: "),
    "negative": (MAP.replace("max_gap: 0.1", "max_gap: -1.0"), "max_gap: "),
    "an arm with a dot": (MAP.replace("left:", "le.ft:"), "an arm's name has no dot"),
    "a topic twice": (
        MAP.replace("clock", "  right: {topic: /left/wrench, contact: [0, 0, 1], force: on_cart}\nclock"),
        "is that of another arm too",
    ),
    "a tare that ends before it begins": (MAP.replace("on_cart", "on_cart, tare: [1, 0]"), "begins after it ends"),
    "a list": ("- a\n", "a mapping"),
    "no YAML": ("a: [", "not valid YAML"),
    "a tag": (MAP + "!!python/object:os.system x: 1\n", "topics.yaml"),
}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return files.write_mcap(tmp_path_factory.mktemp("bag") / "run.mcap", push())


@pytest.mark.parametrize("kind", MISTAKES)
def test_a_mistake_in_a_map_names_its_place(bag, kind):
    text, why = MISTAKES[kind]
    path = mapped(bag, text).with_name("run.mcap.topics.yaml")
    with pytest.raises(FileError, match=why) as caught:
        read_log(bag)
    assert str(caught.value).startswith(str(path))
    assert len(str(caught.value).splitlines()) == 1


def test_what_no_map_can_mend(tmp_path):
    for value, why in (
        (files.wrench(stamp(0.5), [1e12, 0, 0, 0, 0, 0]), r"/left/wrench: message 51: holds 1e\+12, which is no"),
        (files.wrench(stamp(0.5), [0, np.inf, 0, 0, 0, 0]), r"/left/wrench: message 51: holds inf"),
    ):
        with pytest.raises(LogError, match=why):
            read(tmp_path, [*push(1.0), ("/left/wrench", files.WRENCH, stamp(1), value)], MAP)
    tilted = files.odometry(stamp(1), [0, 0, 0], [0, 0, 0])
    tilted["pose"]["pose"]["orientation"] = {"x": 0.5, "y": 0.5, "z": 0.5, "w": 0.5}
    with pytest.raises(FileError, match="90° off the vertical"):
        read(tmp_path, [*push(1.0), ("/odom", files.ODOMETRY, stamp(1), tilted)], MAP)
    tilted["pose"]["pose"]["orientation"] = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}
    with pytest.raises(LogError, match=r"/odom: message 51: its quaternion has the norm 0"):
        read(tmp_path, [*push(1.0), ("/odom", files.ODOMETRY, stamp(1), tilted)], MAP)
    later = [(t, k, ns, v) for t, k, ns, v in push(3.0) if (t == "/odom") == (ns < stamp(1))]
    with pytest.raises(LogError, match="its parts have no time in common: pose from"):
        read(tmp_path, later, MAP)
    far = [*push(), *((t, k, ns + 10**16, v) for t, k, ns, v in push())]
    with pytest.raises(CartgraspError, match=r"clock: .*far more than there are samples"):
        read(tmp_path, far, MAP.replace("clock: pose", "clock: 100.0") + "stamps: receive\n")
