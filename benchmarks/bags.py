"""From 100,000 messages to a run log: CPU time of whole reads, beside the library `rosbags` decoding them alone."""

from __future__ import annotations

import os
import struct
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

from cartgrasp.logs import ArmLog, RunLog, read_log, write_log
from cartgrasp.logs.bags.bag import Message
from cartgrasp.logs.bags.messages import COVARIANCE_SIZE, NS_PER_S, ODOMETRY_TYPE, decode
from cartgrasp.logs.bags.opening import open_bag

from .report import Result, Table, number

MESSAGES, FEW = 100_000, 4_000
MOST = 5
"""Rounds; with fewer, only to see that it runs, there are FEW messages."""
NOTE = """CPU time from a file to a `RunLog`, with all sums, frames and signs, its clock that of the
poses: Odometry and two WrenchStamped, in our MCAP a TFMessage too. Beside it `rosbags` reading and decoding alone."""
MAP = """\
pose: {topic: /cart/odometry, velocity: twist}
arms:
  left: {topic: /left/wrench, contact: [-0.25, 0.2, 1.0], force: on_cart}
  right: {topic: /right/wrench, contact: [-0.25, -0.2, 1.0], force: on_cart}
"""


def run(rounds: int) -> Result:
    load, count = os.getloadavg()[0], MESSAGES if rounds >= MOST else FEW
    with tempfile.TemporaryDirectory() as name:
        rows = [_row(kind, path, count, min(rounds, MOST)) for kind, path in _bags(Path(name), count).items()]
    columns = ("", "read_log, s", "rosbags alone, s", "µs a message")
    return Result(
        "Bags",
        NOTE,
        (Table(f"{count:,} messages", columns, tuple(rows), (load, os.getloadavg()[0]), min(rounds, MOST)),),
    )


def _row(kind: str, path: Path, count: int, rounds: int) -> tuple[str, ...]:
    ours = float(np.median([_cpu(read_log, path) for _ in range(rounds)]))
    theirs = float(np.median([_cpu(_decoded, path) for _ in range(rounds)]))
    return kind, number(ours), number(theirs), number(1e6 * ours / count)


def _cpu(call: Callable[[Path], object], path: Path) -> float:
    start = time.process_time()
    call(path)
    return time.process_time() - start


def _decoded(path: Path) -> int:
    with AnyReader([path]) as reader:
        return sum(reader.deserialize(raw, c.msgtype) is not None for c, _, raw in reader.messages())


def _bags(folder: Path, count: int) -> dict[str, Path]:
    """Ours, and others from what a longer one of ours holds beside TF."""
    (folder / "topics.yaml").write_text(MAP)
    own = write_log(_log(count // 4), folder / "own.mcap")
    longer = open_bag(write_log(_log(count // 3 + 1), folder / "longer.mcap"))
    topics = ("/cart/odometry", "/left/wrench", "/right/wrench")
    messages = list(longer.messages(topics))[:count]
    sqlite = _write(Ros2Writer(folder / "sqlite", version=8), messages, Stores.ROS2_HUMBLE, lambda m: m.raw)
    (sqlite / "topics.yaml").write_text(MAP)
    ros1 = _write(Ros1Writer(folder / "ros1.bag"), messages, Stores.ROS1_NOETIC, _as_ros1)
    return {"MCAP, zstd (ours)": own, "SQLite": sqlite, "ROS 1": ros1}


def _log(rows: int) -> RunLog:
    rng = np.random.default_rng(0)
    wrenches = {"left": rng.normal(size=(rows, 6)), "right": rng.normal(size=(rows, 6))}
    arms = {name: ArmLog(np.zeros((rows, 3)), wrench) for name, wrench in wrenches.items()}
    return RunLog(0.01 * np.arange(rows), rng.normal(size=(rows, 3)), rng.normal(size=(rows, 3)), arms)


def _write(
    writer: Ros1Writer | Ros2Writer, messages: Sequence[Message], store: Stores, coded: Callable[[Message], bytes]
) -> Path:
    connections: dict = {}
    with writer:
        for message in messages:
            if message.topic not in connections:
                types = get_typestore(store)
                connections[message.topic] = writer.add_connection(message.topic, message.kind, typestore=types)
            writer.write(connections[message.topic], message.received, coded(message))
    return writer.path


def _as_ros1(message: Message) -> bytes:
    (sample,) = decode(message.raw, message.kind, is_ros1=False)
    head = struct.pack("<III", 0, sample.stamp // NS_PER_S, sample.stamp % NS_PER_S) + _text(sample.frame)
    numbers = sample.numbers
    if message.kind == ODOMETRY_TYPE:
        head += _text(sample.child)
        nothing = (0.0,) * COVARIANCE_SIZE
        numbers = numbers[:7] + nothing + numbers[7:] + nothing
    return head + struct.pack(f"<{len(numbers)}d", *numbers)


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()
