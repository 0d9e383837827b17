"""A simulated second of each plant at 100 Hz control."""

from __future__ import annotations

import numpy as np

from cartgrasp import ContactWrenches
from cartgrasp.roles import Plant
from cartgrasp.simulation.mujoco_plant import MujocoPlant
from cartgrasp.simulation.plant import ModelPlant
from cartgrasp.studies.shopping_cart import loaded_cart

from .measuring import Competitor, interleave
from .report import Result, timed_table

PERIOD, STEPS = 0.01, 100
OURS = "ModelPlant"
NOTE = """The loaded shopping cart on two casters (viscous drag, rolling resistance, swivel friction), from rest, at the
plants' default time steps: 5 ms of Runge-Kutta 4, 1 ms of MuJoCo. Making the plant isn't counted; 1,000 ms is real
time."""


def run(rounds: int) -> Result:
    cart = loaded_cart()
    competitors = {
        OURS: _second([ModelPlant(cart) for _ in range(rounds)]),
        "MujocoPlant": _second([MujocoPlant(cart) for _ in range(rounds)]),
    }
    table = timed_table("A simulated second", interleave(competitors, rounds), OURS, "ms", {})
    return Result("Plants", NOTE, (table,))


def _second(plants: list[Plant]) -> Competitor:
    point = np.array([-0.25, 0.1, 1.0])

    def run(k: int) -> object:
        for step in range(STEPS):
            wrench = np.array([15.0, 0.0, 0.0, 0.0, 0.0, 1.5 + np.sin(0.1 * step)])
            plants[k].step(ContactWrenches({"hand": wrench}, {"hand": point}), PERIOD)
        return plants[k].motion

    return run
