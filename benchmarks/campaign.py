"""A campaign of drawn carts beside the same runs one after the other through the single-run loop."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

import numpy as np

from cartgrasp import Arm, CartModel, Inertia
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.simulation.sensors import SensorNoise
from cartgrasp.studies.campaigns.campaign import Results, run_campaign
from cartgrasp.studies.campaigns.closed_loop import ClosedLoopStudy
from cartgrasp.studies.campaigns.drawing import Drawn
from cartgrasp.studies.campaigns.workers import over_cores
from cartgrasp.studies.compiled_loop.loop import compiled_run, covers
from cartgrasp.studies.scenario import Scenario
from cartgrasp.studies.shopping_cart import FIRM_GAINS
from cartgrasp.studies.table1 import trajectory
from estimation import FilterNoise

from .measuring import interleave
from .report import Result, Table, number, timed_table

CORES = 2
SINGLE, COMPILED = "single-run loop", "compiled loop"
SHARES = (0.1, 0.3, 1.0)
SINGLES = 100
"""Runs of a campaign for each that the single-run loop does beside it."""
NOTE = f"""Runs of 30 s at 100 Hz, 3,000 control periods each: a cart of drawn mass, CoM and drag on Table I's curves,
two arms, noisy sensors, and the filter that learns all seven parameters from a wrong guess; the plant takes steps of
10 ms, as in Table I. `{SINGLE}` is `Scenario.run`, one after the other in one process. A campaign does each run, works
out its figures and keeps its file, with {CORES} processes that are warm."""
DRAWN = (
    Drawn("mass", "uniform", (15.0, 45.0)),
    Drawn("com_x", "normal", (0.3, 0.05)),
    Drawn("com_y", "normal", (0.0, 0.05)),
    Drawn("viscous_drag.linear", "uniform", (1.0, 4.0)),
)


def run(rounds: int) -> Result:
    jobs = study(max(rounds // SINGLES, 1), seed=1).jobs()
    scenarios = [job.scenario for job in jobs]
    assert all(covers(one) for one in scenarios)
    compiled_run(scenarios[0])
    competitors = {
        SINGLE: lambda k: scenarios[k % len(scenarios)].run(),
        COMPILED: lambda k: compiled_run(scenarios[k % len(scenarios)]),
    }
    alone = interleave(competitors, len(scenarios))
    each = timed_table("A run, in one process", alone, COMPILED, "ms", {})
    return Result("Campaign", NOTE, (each, _campaigns(rounds, alone.times[SINGLE].median)))


def study(runs: int, seed: int) -> ClosedLoopStudy:
    truth = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(2.0, 0.4), RollingResistance(0.015)))
    guess = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(3.0, 1.0), RollingResistance(0.02)))
    limits = {"force_limit": (150.0, 60.0, 60.0), "moment_limit": (40.0, 40.0, 40.0)}
    scenario = Scenario(
        truth=truth,
        guess=guess,
        arms=tuple(Arm(name, [(-0.25, y, 1.0)], **limits) for name, y in (("left", 0.2), ("right", -0.2))),
        stretches=trajectory(2),
        sensors=SensorNoise(),
        noise=FilterNoise(),
        gains=FIRM_GAINS,
        plant_timestep=0.01,
        duration=30.0,
    )
    return ClosedLoopStudy("benchmark", scenario, DRAWN, seed, runs, {"benchmark": "campaign"})


def _campaigns(rounds: int, single: float) -> Table:
    """Of several sizes, each with seeds of its own."""
    begin, rows, workers = os.getloadavg()[0], [], over_cores(CORES)
    with tempfile.TemporaryDirectory() as folder:
        results = Results.under(Path(folder))
        run_campaign(study(2 * CORES, seed=2), results, workers)  # processes begin, kernels are loaded
        for i, share in enumerate(SHARES):
            count = max(i + 1, round(share * rounds))
            start = time.perf_counter()
            found = run_campaign(study(count, seed=3 + i), results, workers)
            taken = time.perf_counter() - start
            assert all("failure" not in one for one in found)
            cells = number(taken), number(1e3 * taken / count), f"{single * count / taken:.1f}"
            rows.append((str(count), *cells))
    columns = ("runs", "s", "ms a run", f"times as fast as the {SINGLE}")
    slope = np.polyfit([float(row[0]) for row in rows], [float(row[1].replace(",", "")) for row in rows], 1)
    title = f"Campaigns on {CORES} cores: {1e3 * slope[0]:.0f} ms for each further run"
    return Table(title, columns, tuple(rows), (begin, os.getloadavg()[0]), 1)
