"""Table I of the paper: eleven runs with estimation, without it, and with the paper's literal filter.

What the paper does not give is chosen here and written into the report: inertia 2 kg m², viscous drag 3 N·s/m and
1.2 N·m·s (known to all, as in the paper's sigma), 100 Hz, one hand on a handle at x = -0.25 m, noise of the same number
on position (m), heading (rad) and their rates, exact wrenches. Trajectory 2 slows from 0.9 to 0.5 m/s for its curves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from estimation import FilterNoise
from planning import Choosing
from planning.contact_sources.strategies import FIXED, PERIODIC
from planning.references import Stretch, chain, pause, speed_change, straight, turn

from ..arms import Arm
from ..constraints import RollingConstraints
from ..effects import PayloadChange, ViscousDrag
from ..inertia import Inertia
from ..model import CartModel
from ..simulation.record import RunRecord
from ..simulation.sensors import SensorNoise
from .parallel import Progress, run_all
from .scenario import FIRST_GUESS, LEARNING, PAPER, Scenario, scaled, total_duration

TEST_DURATION = 30.0
TRUE_MASS, TRUE_INERTIA = 20.0, 2.0
ESTIMATION_MODES = (LEARNING, FIRST_GUESS, PAPER)
MASS_STEPS = ((9.0, 5.0, 0.4, 0.1), (19.0, -8.0, 0.3, 0.0))
"""Test 11: (time s, mass kg, x m, y m)."""


@dataclass(frozen=True)
class Row:
    """A line of Table I."""

    test: int
    trajectory: int
    first_mass: float
    com: tuple[float, float]
    noise: float
    varies: bool
    mass_steps: bool = False


ROWS = (
    Row(1, 1, 16, (0.3, 0.0), 0.005, False),
    Row(2, 1, 24, (0.3, 0.0), 0.005, False),
    Row(3, 1, 16, (0.3, 0.15), 0.005, True),
    Row(4, 2, 16, (0.3, 0.0), 0.005, False),
    Row(5, 2, 16, (0.3, 0.15), 0.005, False),
    Row(6, 2, 16, (0.3, -0.15), 0.005, True),
    Row(7, 2, 16, (0.1, 0.0), 0.005, True),
    Row(8, 2, 10, (0.3, 0.15), 0.005, False),
    Row(9, 2, 16, (0.3, 0.15), 0.05, True),
    Row(10, 2, 16, (0.3, 0.15), 0.2, True),
    Row(11, 2, 16, (0.3, 0.0), 0.005, True, mass_steps=True),
)


def trajectory(number: int) -> tuple[Stretch, ...]:
    """1: a straight line at 0.8 m/s; 2: curves that begin at 7, 16 and 25 s. Steps of acceleration start and stop."""
    if number == 1:
        return chain(straight(0.8 * (TEST_DURATION - 1.6 - 1.0), 0.8), pause(1.0))
    quarter, eighth = turn(np.pi / 2, 0.4), turn(np.pi / 4, 0.4)
    slow_down, speed_up = speed_change(-0.4, 0.25), speed_change(0.4, 0.25)
    cruise = 9.0 - total_duration(quarter) - 2 * total_duration(slow_down)
    return chain(
        speed_change(0.9),
        pause(7.0 - 1.8 - total_duration(slow_down)),
        *(slow_down, quarter, speed_up, pause(cruise)),
        *(slow_down, turn(-np.pi / 2, 0.4), speed_up, pause(cruise)),
        *(slow_down, eighth, speed_change(-0.5)),
    )


def scenario(row: Row, estimation: str = LEARNING, seed: int = 0) -> Scenario:
    """The run of a row."""
    drag = ViscousDrag(linear=3.0, angular=1.2)
    steps = [
        PayloadChange(time=time, mass=mass, x=x, y=y, label=f"step{i}")
        for i, (time, mass, x, y) in enumerate(MASS_STEPS if row.mass_steps else (), 1)
    ]
    sigma = row.noise
    return Scenario(
        truth=CartModel(Inertia(TRUE_MASS, row.com, TRUE_INERTIA), RollingConstraints(), (drag, *steps)),
        guess=CartModel(Inertia(row.first_mass, (0.3, 0.0), TRUE_INERTIA), RollingConstraints(), (drag,)),
        arms=(HAND,),
        stretches=trajectory(row.trajectory),
        sensors=SensorNoise(sigma, sigma, sigma, sigma, 0.0, 0.0),
        noise=FilterNoise(sigma, sigma, sigma, sigma, 0.0, 0.0, disturbance=0.02, slip=0.0001),
        known=frozenset({"viscous_drag"}),
        estimation=estimation,
        contacts=PERIODIC if row.varies else FIXED,
        choosing=Choosing(every=3.0),
        plant_timestep=0.01,
        seed=seed,
        duration=TEST_DURATION,
    )


HAND = Arm(
    "hand",
    contacts=[(-0.25, 0.0, 1.0), (-0.25, 0.2, 1.0), (-0.25, -0.2, 1.0)],
    force_limit=(120, 120, 60),
    moment_limit=(40, 40, 40),
)


@dataclass(frozen=True)
class RowResult:
    """A row's three runs."""

    row: Row
    runs: dict[str, RunRecord]


def run_rows(
    rows: tuple[Row, ...] = ROWS, seed: int = 0, workers: int = 1, progress: Progress = None
) -> list[RowResult]:
    """Every row in every mode, over `workers` processes."""
    jobs = [scenario(row, mode, seed + row.test) for row in rows for mode in ESTIMATION_MODES]
    records = iter(run_all(Scenario.run, jobs, workers, progress))
    return [RowResult(row, {mode: next(records) for mode in ESTIMATION_MODES}) for row in rows]


def gain_curve(scales: tuple[float, ...], seed: int = 0) -> list[tuple[float, float]]:
    """Largest tracking error (m) of test 1 without estimation, against the scale of all gains."""
    curve = []
    for scale in scales:
        base = scenario(ROWS[0], FIRST_GUESS, seed)
        gains = scaled(base.gains, scale)
        curve.append((scale, float(replace(base, gains=gains, duration=12.0).run().tracking_error.max())))
    return curve
