"""`cartgrasp warm-up`: all kernels, once; and after it nothing is left to do at a first call."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import time
from pathlib import Path

from cartgrasp import compile_notice
from cartgrasp.cli import output, warm_up
from cartgrasp.cli.output import KernelProgressLines

from .commands import run

ROOT = Path(__file__).parents[2]
LOOP = """
import numpy as np
from cartgrasp import Arm, CartModel, Inertia, Measurement, Wheel
from cartgrasp.compiling import ENTRY_KERNELS
from cartgrasp.effects import RollingResistance, ViscousDrag
from estimation import CartFilter
from planning import WrenchPlanner

wheels = Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.6, 0.0, 0.05)
effects = ViscousDrag(5.0, 2.0), RollingResistance(0.02)
cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), wheels=wheels, effects=effects)
planner = WrenchPlanner(cart, [Arm("hand", [(-0.25, 0.1, 1.0), (-0.25, 0.0, 1.0)])])
planner.warm_up()
online = CartFilter(cart)
online.warm_up()
before = {kernel.py_func.__name__: len(kernel.overloads) for kernel in ENTRY_KERNELS}
random = np.random.default_rng(0)
for i in range(500):
    time, noise = 0.01 * i, random.normal(size=12)
    load = 1.0 if i < 300 else 1.6
    speed = 0.5 + 0.3 * np.sin(2.0 * time)
    pose = [0.5 * time + 0.15 * (1.0 - np.cos(2.0 * time)), 0.0, 0.0]
    force = load * 24.0 * 0.6 * np.cos(2.0 * time) + 5.0 * speed
    felt = {"hand": np.array([force, 0, 0, 0, 0, 0]) + noise[:6]}
    seen = np.array(pose) + 0.0005 * noise[6:9], np.array([speed, 0, 0]) + 0.005 * noise[9:]
    estimate = online.update(Measurement(time, *seen, felt, {"hand": np.array([0.0, 0.0, 1.0])}))
    planner.plan_or_hold((force if i % 7 else 1e4, 0.0, 1.0), estimate=estimate)
after = {kernel.py_func.__name__: len(kernel.overloads) for kernel in ENTRY_KERNELS}
print({name for name in after if after[name] != before.get(name, 0)})
"""


def test_all_kernels_are_prepared_and_then_found(capsys):
    first, second = (run(capsys, "warm-up", "--json").json for _ in range(2))
    kernels = warm_up.asked_for()
    assert {kernel.py_func.__name__ for kernel in kernels if not kernel.overloads} == set()
    assert first["kernels"] == second["kernels"] == len(kernels)
    assert second["compiled"] == 0


def test_a_loop_after_warm_up_loads_and_compiles_nothing():
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", LOOP], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == "set()"


def test_it_is_told_line_by_line(capsys):
    with compile_notice.kernel_listener(KernelProgressLines(20)):
        for kernel in ("drive", "record"):
            compile_notice.compiling(kernel)
    assert capsys.readouterr().err.splitlines() == [
        "preparing kernels, once on this machine: 1 of 20 (drive)",
        "preparing kernels, once on this machine: 2 of 20 (record)",
    ]


def test_where_nobody_tells_the_log_does_once(caplog):
    with caplog.at_level(logging.WARNING), compile_notice.kernel_listener(compile_notice.CompileWarning()):
        compile_notice.compiling("drive")
        compile_notice.compiling("record")
    assert [record.getMessage() for record in caplog.records] == [compile_notice.ADVICE]


def test_two_at_once_compile_each_kernel_once(tmp_path):
    """Whoever comes second waits, and finds it."""
    script = (
        "import numpy as np\n"
        "from cartgrasp.compile_notice import kernel_listener\n"
        "from cartgrasp.kernels.wheel_loads import stacked_loads\n"
        "found = np.zeros((1, 4)), np.zeros((1, 4, 4)), np.zeros((1, 4))\n"
        "with kernel_listener(print):\n"
        "    stacked_loads(np.zeros((4, 2)), 9.81, np.ones((1, 4)), found)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    both = [
        subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=environment)
        for _ in range(2)
    ]
    told = [one.communicate()[0].split() for one in both]
    assert [one.returncode for one in both] == [0, 0]
    assert sorted(told, key=len) == [[], ["stacked_loads"]]


def test_what_takes_long_is_told_on(capsys, monkeypatch):
    monkeypatch.setattr(output, "MIN_PROGRESS_INTERVAL", 0.05)
    with output.told_on("preparing kernels"):
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 6
    assert set(lines) == {"preparing kernels: 0 s"}
    time.sleep(0.1)
    assert capsys.readouterr().err == ""
