"""docs/bags.md: its commands run one after another and print what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ..logs import bag_files as files
from .commands import run
from .pushed_cart import HANDS, HEADER, as_csv, pushed_cart

PAGE = (Path(__file__).parents[2] / "docs" / "bags.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
CART = """\
name: cart
mass: 15.0
com: [0.2, 0.0]
inertia: 1.5
constraints: [{no_lateral_slip: {x: 0.0}}]
effects: {viscous_drag: {linear: 3.0, angular: 1.2}}
"""
LATE = 0.004


def recording(table):
    """Sensors that are turned by a quarter about z, feel the cart push back, have an offset and stamp late."""
    messages = []
    for row in table:
        values = dict(zip(HEADER, row, strict=True))
        ns = files.stamp(values["t"])
        pose, rate = (np.array([values[k] for k in names]) for names in (("x", "y", "theta"), ("vx", "vy", "omega")))
        odometry = files.odometry(ns, pose, files.in_body(rate, pose[2]))
        messages.append(("/odom", files.ODOMETRY, ns, odometry))
        for hand in HANDS:
            fx, fy, fz, tx, ty, tz = (values[f"{hand}.{k}"] for k in ("fx", "fy", "fz", "tx", "ty", "tz"))
            reading = np.array([-fy, fx, 7.8 - fz, 0.3 - ty, tx, -tz])
            late = ns + round(LATE * files.NANO)
            messages.append((f"/{hand}/ft", files.WRENCH, late, files.wrench(late, reading)))
    return messages


@pytest.fixture
def place(tmp_path, monkeypatch):
    table = pushed_cart()[:1000]
    files.write_ros1(tmp_path / "run.bag", recording(table))
    (tmp_path / "simulated.csv").write_text(as_csv(table[:100]))
    (tmp_path / "cart.yaml").write_text(CART)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page(capsys, place):
    printed = ""
    for language, block in BLOCKS:
        if language == "sh":
            printed = ""
            for line in block.splitlines():
                program, *arguments = line.split("#")[0].split()
                assert program == "cartgrasp"
                answer = run(capsys, *arguments)
                assert answer.status == 0, answer.err
                printed += answer.out
        elif language == "text":
            assert [line.rstrip() for line in printed.splitlines()] == [line.rstrip() for line in block.splitlines()]
        elif language == "yaml":
            (place / "run.bag.topics.yaml").write_text(block)
        if "estimate" in block and language == "sh":
            mass, deviation = (float(word) for word in re.search(r"mass\W+([\d.]+)\W+([\d.]+)", printed).groups())
    assert abs(mass - 24.0) < 4 * deviation < 1.0
