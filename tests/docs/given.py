"""What a page's reader has: files in a folder, and names."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np

import cartgrasp as cg
from planning.references import PathReference, pause, speed_change

from ..cli.commands import ROOT
from ..cli.pushed_cart import HANDS, HEADER, as_csv, pushed_cart
from ..logs import bag_files

GUESS = """\
name: cart
mass: 15.0
com: [0.2, 0.0]
inertia: 1.5
constraints: [{no_lateral_slip: {x: 0.0}}]
effects: {viscous_drag: {linear: 3.0, angular: 1.2}}
"""
LATE = 0.004
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
PLANAR = {"fx": "Fx [N]", "fy": "Fy [N]", "tz": "Mz [Nm]"}
OFFSETS = (0.1, 0.2, 0.5, 0.2, 0.3, 0.1)
"""m, along the z of the link before."""


def put_files(folder: Path) -> None:
    """examples/, the log of a push, the same as a bag and as a stranger's table, and a first guess of the cart."""
    shutil.copytree(ROOT / "examples", folder / "examples")
    table = pushed_cart()
    (folder / "run.csv").write_text(as_csv(table))
    (folder / "mine.csv").write_text(of_a_stranger(table), encoding="utf-8")
    (folder / "simulated.csv").write_text(as_csv(table[:100]))
    (folder / "cart.yaml").write_text(GUESS)
    (folder / "problem.yaml").write_text((ROOT / "examples" / "problem.yaml").read_text(encoding="utf-8"))
    messages = recording(table[:1000])
    bag_files.write_ros1(folder / "run.bag", messages)
    bag_files.write_mcap(folder / "robot.mcap", localised(messages[:600]))


def of_a_stranger(table: np.ndarray) -> str:
    """The same with other columns: ms, mm, wrapped degrees, planar sensors, semicolons and decimal commas."""
    columns = dict(zip(HEADER, table.T, strict=True))
    degrees = (np.degrees(columns["theta"]) + 180) % 360 - 180
    kept = {"time [ms]": 1e3 * columns["t"], "X": 1e3 * columns["x"], "Y": 1e3 * columns["y"], "yaw [°]": degrees}
    for hand in HANDS:
        kept |= {f"{hand} {name}": columns[f"{hand}.{part}"] for part, name in PLANAR.items()}
    rows = (";".join(f"{value:.3f}".replace(".", ",") for value in row) for row in zip(*kept.values(), strict=True))
    return "\n".join([";".join(kept), *rows]) + "\n"


def recording(table: np.ndarray) -> list[tuple]:
    """Sensors that are turned by a quarter about z, feel the cart push back, have an offset and stamp late."""
    messages = []
    for row in table:
        values = dict(zip(HEADER, row, strict=True))
        ns = bag_files.stamp(values["t"])
        pose, rate = (np.array([values[k] for k in names]) for names in (("x", "y", "theta"), ("vx", "vy", "omega")))
        odometry = bag_files.odometry(ns, pose, bag_files.in_body(rate, pose[2]))
        messages.append(("/odom", bag_files.ODOMETRY, ns, odometry))
        for hand in HANDS:
            fx, fy, fz, tx, ty, tz = (values[f"{hand}.{k}"] for k in ("fx", "fy", "fz", "tx", "ty", "tz"))
            reading = np.array([-fy, fx, 7.8 - fz, 0.3 - ty, tx, -tz])
            late = ns + round(LATE * bag_files.NANO)
            messages.append((f"/{hand}/ft", bag_files.WRENCH, late, bag_files.wrench(late, reading)))
    return messages


def localised(messages: list[tuple]) -> list[tuple]:
    """Odometry as TF, in a map in which localisation says five times a second where it began."""
    found = [m for m in messages if m[1] == bag_files.WRENCH]
    odometry = [m for m in messages if m[1] == bag_files.ODOMETRY]
    for i, (_, _, ns, value) in enumerate(odometry):
        pose = value["pose"]["pose"]
        x, y, z, w = pose["position"]["x"], pose["position"]["y"], pose["orientation"]["z"], pose["orientation"]["w"]
        parts = [("odom", "base_footprint", (x, y, 2 * math.atan2(z, w)))]
        if i % 20 == 0 or i == len(odometry) - 1:
            parts.append(("map", "odom", (4.0 + 0.02 * (i // 100), 1.0, 0.5)))
        found.append(("/tf", bag_files.TF, ns, bag_files.transforms(ns, *parts)))
    static = bag_files.transforms(0, ("base_footprint", "base_link", (0.0, 0.0, 0.0)))
    found.append(("/tf_static", bag_files.TF, odometry[0][2], static))
    return sorted(found, key=lambda m: m[2])


def cart(folder: Path) -> cg.CartModel:
    return cg.load_cart(folder / "examples" / "cart.yaml")


def arms(folder: Path) -> list[cg.Arm]:
    limits = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
    return [cg.Arm(name, [(-0.25, y, 1.0)], **limits) for name, y in (("left", 0.2), ("right", -0.2))]


def wrench(folder: Path) -> tuple[float, float, float]:
    return (40.0, 0.0, 3.0)


def log(folder: Path) -> cg.RunLog:
    return cg.read_log(folder / "run.csv")


def reference(folder: Path) -> PathReference:
    return PathReference((*speed_change(0.6), *pause(2.0), *speed_change(-0.6)))


def information(folder: Path) -> np.ndarray:
    """Of phi and both drags."""
    return np.diag(1.0 / np.array([8.0, 4.0, 4.0, 3.0, 1e-3, 1e-3]) ** 2)


def a_robot(folder: Path) -> Path:
    """A URDF with six revolute joints, `arm.urdf`."""
    links, parent = ['<robot name="six"><link name="base"/>'], "base"
    for i, (axis, offset) in enumerate(zip(AXES, OFFSETS, strict=True)):
        links.append(
            f'<joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/><axis xyz="{axis}"/>'
            f'<origin xyz="0 0 {offset}"/><limit lower="-3" upper="3" effort="100" velocity="1"/></joint>'
            f'<link name="l{i}"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>'
            '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
        parent = f"l{i}"
    links.append(f'<joint name="tool" type="fixed"><parent link="{parent}"/><child link="tool0"/></joint>')
    path = folder / "arm.urdf"
    path.write_text("".join([*links, '<link name="tool0"/></robot>']))
    return path
