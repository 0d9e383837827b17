"""A push as ROS messages, written by other libraries: mcap-ros2-support, rosbags (ROS 1 and SQLite), bare sqlite3."""

from __future__ import annotations

import math
import sqlite3

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

WRENCH = "geometry_msgs/msg/WrenchStamped"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
TF = "tf2_msgs/msg/TFMessage"
ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_FOXY)
ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
START = 1_700_000_000
NANO = 10**9


def stamp(t):
    """Time t, in s from the recording's start, in ns."""
    return START * NANO + round(t * NANO)


def header(ns, frame):
    return {"stamp": {"sec": ns // NANO, "nanosec": ns % NANO}, "frame_id": frame}


def xyz(values):
    return dict(zip("xyz", map(float, values), strict=True))


def quaternion(yaw):
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


def wrench(ns, values, frame="sensor"):
    return {"header": header(ns, frame), "wrench": {"force": xyz(values[:3]), "torque": xyz(values[3:])}}


def pose(ns, values, frame="map"):
    return {"header": header(ns, frame), "pose": planar_pose(values)}


def planar_pose(values):
    return {"position": xyz([*values[:2], 0.0]), "orientation": quaternion(values[2])}


def odometry(ns, values, twist):
    """`twist` is vx, vy, yaw rate in the child's frame."""
    return {
        "header": header(ns, "odom"),
        "child_frame_id": "base_link",
        "pose": {"pose": planar_pose(values), "covariance": [0.0] * 36},
        "twist": {
            "twist": {"linear": xyz([*twist[:2], 0.0]), "angular": xyz([0.0, 0.0, twist[2]])},
            "covariance": [0.0] * 36,
        },
    }


def transforms(ns, *parts):
    """`parts` are (frame, child, planar pose), or with position and quaternion in its place."""
    return {
        "transforms": [
            {
                "header": header(ns, frame),
                "child_frame_id": child,
                "transform": transform(values),
            }
            for frame, child, values in parts
        ]
    }


def transform(values):
    if len(values) == 3:
        return {"translation": xyz([*values[:2], 0.0]), "rotation": quaternion(values[2])}
    return {"translation": xyz(values[:3]), "rotation": dict(zip("xyzw", map(float, values[3:]), strict=True))}


def typed(store, kind, value):
    """The nested mapping as a message of a rosbags typestore."""
    fields = {}
    for name, (_, about) in store.get_msgdef(kind).fields:
        if name == "seq":
            fields[name] = 0
            continue
        part = value[name]
        if isinstance(part, dict):
            of = about if isinstance(about, str) else about[0]
            fields[name] = typed(store, of, part)
        elif isinstance(part, list):
            is_plain = not part or isinstance(part[0], float)
            fields[name] = np.array(part) if is_plain else [typed(store, about[0][1], p) for p in part]
        else:
            fields[name] = part
    return store.types[kind](**fields)


def write_mcap(path, messages, compression="zstd", chunk_size=4096):
    """`messages` are (topic, kind, time of receipt in ns, nested mapping)."""
    with (
        open(path, "wb") as stream,
        McapWriter(stream, compression=CompressionType[compression.upper()], chunk_size=chunk_size) as writer,
    ):
        schemas = {}
        for topic, kind, received, value in messages:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, ROS2.generate_msgdef(kind, ros_version=2)[0])
            writer.write_message(topic, schemas[kind], value, log_time=received, publish_time=received)
    return path


def written(path, writer, messages, types, serialize):
    with writer:
        connections = {}
        for topic, kind, received, value in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=types)
            writer.write(connections[topic], received, serialize(typed(types, kind, value), kind))
    return path


def write_ros1(path, messages, compression=None):
    writer = Ros1Writer(path)
    if compression is not None:
        writer.set_compression(compression)
    return written(path, writer, messages, ROS1, ROS1.serialize_ros1)


def write_folder(path, messages, storage="sqlite3", compression=None):
    """As `ros2 bag record` leaves it: storage files beside metadata.yaml."""
    writer = Ros2Writer(path, version=8, storage_plugin=StoragePlugin[storage.upper()])
    if compression is not None:
        writer.set_compression(*compression)
    return written(path, writer, messages, ROS2, ROS2.serialize_cdr)


def write_old_sqlite(path, messages):
    """One file with the tables of the first recorders (schema 1), and no metadata.yaml."""
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
    database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    topics = {}
    for topic, kind, received, value in messages:
        if topic not in topics:
            topics[topic] = len(topics) + 1
            database.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr')", (topics[topic], topic, kind))
        raw = bytes(ROS2.serialize_cdr(typed(ROS2, kind, value), kind))
        row = (topics[topic], received, raw)
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", row)
    database.commit()
    database.close()
    return path


# --- one push ------------------------------------------------------------------------------------------------

MAP = """\
pose: {topic: /odom, velocity: twist}
arms:
  left: {topic: /left/wrench, contact: [-0.25, 0.2, 1.0], force: on_cart}
clock: pose
max_gap: 0.1
"""


def path_of(t):
    """Pose and its rate at times t: a curve that turns by more than a turn."""
    t = np.asarray(t, dtype=float)
    rows = np.stack([0.5 * t + 0.2 * np.sin(t), 0.3 * np.cos(0.7 * t), 0.9 * t + 0.2 * np.sin(2 * t)], -1)
    rate = np.stack([0.5 + 0.2 * np.cos(t), -0.21 * np.sin(0.7 * t), 0.9 + 0.4 * np.cos(2 * t)], -1)
    return rows, rate


def force_of(t):
    t = np.asarray(t, dtype=float)
    return np.stack([20 + 5 * np.sin(t), 3 * np.cos(t), 0.1 * t, 0.2 * np.sin(t), 0.1 + 0 * t, 0.5 * np.cos(2 * t)], -1)


def in_body(rate, theta):
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c * rate[..., 0] + s * rate[..., 1], -s * rate[..., 0] + c * rate[..., 1], rate[..., 2]], -1)


def push(duration=2.0, step=0.02, late=0.003):
    """Odometry and one wrench at the same stamps, received `late`."""
    messages = []
    for t in np.arange(0, duration, step):
        rows, rate = path_of(t)
        ns = stamp(t)
        received = ns + round(late * NANO)
        messages.append(("/odom", ODOMETRY, received, odometry(ns, rows, in_body(rate, rows[2]))))
        messages.append(("/left/wrench", WRENCH, received, wrench(ns, force_of(t))))
    return messages
