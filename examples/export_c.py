"""The planner as C for a controller in hard real time, and that it agrees with the one in Python."""

import subprocess
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

import cartgrasp as cg
from planning import EmbeddedProblem, WrenchPlanner, export_c

cart = cg.load_cart(Path(__file__).parent / "cart.yaml")
holding = partial(cg.Arm, force_limit=(60.0, 60.0, 40.0), moment_limit=(8.0, 8.0, 6.0), friction=cg.Friction(mu=0.6))
left = holding("left", [(-0.25, 0.2, 1.0)])
right = holding("right", [(-0.25, -0.2, 1.0)])
contacts = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
wrenches = [(40.0, 0.0, 3.0), (100.0, 0.0, -6.0), (200.0, 0.0, 0.0)]

folder = Path(tempfile.mkdtemp()) / "planner"
export_c(EmbeddedProblem.of(cart, [left, right], contacts), folder, wrenches[0])
subprocess.run(["make", "--silent", "-C", str(folder)], check=True)
lines = "\n".join(" ".join(map(str, wrench)) for wrench in wrenches)
in_c = subprocess.run([str(folder / "plan")], input=lines, capture_output=True, text=True, check=True).stdout

planner = WrenchPlanner(cart, [left, right])
for wrench, line in zip(wrenches, in_c.splitlines(), strict=True):
    plan, (status, *numbers) = planner.plan(wrench), line.split()
    print(wrench, status, *numbers[:3])
    assert status == plan.status
    if status == "optimal":
        assert np.allclose(np.array(numbers[1:], dtype=float), [*plan.wrenches["left"], *plan.wrenches["right"]])
