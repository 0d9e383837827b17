"""A run log as MCAP, so that Foxglove, PlotJuggler and Rerun show it, and this package reads it back the same.

`/cart/odometry` (its twist in the cart's frame), `/ARM/wrench` with a sensor's frame that is {a}, and `/tf` from the
world to the cart and from the cart to each contact. What is missing is sent as nan.
"""

from __future__ import annotations

import io
import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from ...errors import DataError
from ...frames import PLANAR, body_to_world
from ...writing import write_atomically
from ..run_log import RunLog
from .mcap_file import McapFile
from .messages import NS_PER_S, ODOMETRY_TYPE, TF_TYPE, WRENCH_TYPE, Sample, encode, encode_transforms
from .opening import MAP_KEY, METADATA_NAME

MAX_STAMP_SECONDS = 2.0**31
WORLD_FRAME, CART_FRAME = "world", "cart"
ODOMETRY_TOPIC, TF_TOPIC = "/cart/odometry", "/tf"


def write_mcap(log: RunLog, path: str | Path) -> Path:
    """Times are kept to 1 ns; a velocity in a row without heading, or that is known in part only, is lost."""
    from .whole_bag import definition

    epoch, stamps = _stamps(log)
    names = _ros_names(list(log.arms))
    file = McapFile(METADATA_NAME, {MAP_KEY: _map(log, names, epoch)})
    odometry = file.channel(ODOMETRY_TOPIC, ODOMETRY_TYPE, definition(ODOMETRY_TYPE))
    tf = file.channel(TF_TOPIC, TF_TYPE, definition(TF_TYPE))
    wrenches = {arm: file.channel(f"/{names[arm]}/wrench", WRENCH_TYPE, definition(WRENCH_TYPE)) for arm in log.arms}
    poses, twists = _poses(log).tolist(), _twists(log).tolist()
    contacts = {arm: arm_log.contact.tolist() for arm, arm_log in log.arms.items()}
    readings = {arm: arm_log.wrench.tolist() for arm, arm_log in log.arms.items()}
    for i, stamp in enumerate(stamps):
        pose = tuple(poses[i])
        motion = Sample(stamp, WORLD_FRAME, CART_FRAME, pose + tuple(twists[i]))
        file.message(odometry, stamp, encode(motion, ODOMETRY_TYPE))
        sent = [Sample(stamp, WORLD_FRAME, CART_FRAME, pose)]
        for arm in log.arms:
            sent.append(Sample(stamp, CART_FRAME, names[arm], (*contacts[arm][i], 0.0, 0.0, 0.0, 1.0)))
            reading = Sample(stamp, names[arm], "", tuple(readings[arm][i]))
            file.message(wrenches[arm], stamp, encode(reading, WRENCH_TYPE))
        file.message(tf, stamp, encode_transforms(sent))
    return write_atomically(path, file.done())


def _stamps(log: RunLog) -> tuple[int, list[int]]:
    """ns that are added to the log's times so that none is negative, and the times with them."""
    epoch = max(0, math.ceil(-float(log.time[0]))) * NS_PER_S
    if log.time[-1] + epoch / NS_PER_S >= MAX_STAMP_SECONDS:
        why = f"its times reach beyond what ROS can stamp, {MAX_STAMP_SECONDS:.0f} s; begin them near 0"
        raise DataError(f"{log.name}: {why}")
    stamps = [round(t * NS_PER_S) + epoch for t in log.time.tolist()]
    if any(b <= a for a, b in pairwise(stamps)):
        raise DataError(f"{log.name}: rows less than 1 ns apart can't be written as MCAP")
    return epoch, stamps


def _poses(log: RunLog) -> np.ndarray:
    """Position and quaternion (n, 7)."""
    half = log.pose[:, 2] / 2
    flat = np.where(np.isnan(half), np.nan, 0.0)
    return np.column_stack([log.pose[:, :2], np.zeros(len(log)), flat, flat, np.sin(half), np.cos(half)])


def _twists(log: RunLog) -> np.ndarray:
    """Twist (n, 6) of the cart in itself; nan where there is none."""
    twist = np.full((len(log), 6), np.nan)
    if log.velocity is not None:
        in_cart = np.einsum("nji,nj->ni", body_to_world(log.pose[:, 2]), log.velocity)
        twist[:] = 0.0
        twist[:, [*PLANAR]] = in_cart
    return twist


def _ros_names(arms: list[str]) -> dict[str, str]:
    """Arms by names that ROS accepts and that differ from each other and from the frames here."""
    names: dict[str, str] = {}
    for arm in arms:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", arm)
        plain = plain if plain[:1].isalpha() else f"arm_{plain}"
        while plain in (WORLD_FRAME, CART_FRAME, *names.values()):
            plain += "_"
        names[arm] = plain
    return names


def _map(log: RunLog, names: dict[str, str], epoch: int) -> str:
    step = float(np.diff(log.time).max()) if len(log) > 1 else 1.0
    arms = {}
    for arm in log.arms:
        contact = {"topic": TF_TOPIC, "frame": CART_FRAME, "child": names[arm]}
        arms[arm] = {"topic": f"/{names[arm]}/wrench", "contact": contact, "force": "on_cart"}
    velocity = "none" if log.velocity is None else "twist"
    document = {
        "pose": {"topic": ODOMETRY_TOPIC, "velocity": velocity},
        "arms": arms,
        "clock": "pose",
        "max_gap": 1.01 * step,
        "epoch": epoch,
    }
    yaml = YAML(typ="rt")
    yaml.allow_unicode = False  # else a line break of another script in an arm's name would be one
    stream = io.StringIO()
    yaml.dump(document, stream)
    return stream.getvalue()
