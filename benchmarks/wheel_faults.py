"""Cart files that are wrong of a cart's wheels: how often `check` tells it, and what its constants are worth.

    python -m benchmarks.wheel_faults DIR         logs of `python -m benchmarks.sealed generate`, with their cart files

Each log is looked at with its file as it is, without `constraints`, and with the axle 0.15 m off. Bodies on casters
alone are looked at with a file without constraints, which is right. All again with each constant a third smaller and
larger.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np

from cartgrasp.cart_file import load_cart
from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog, read_log
from cartgrasp.model import CartModel
from estimation.sensor_check import axle, fixed_wheels
from estimation.sensor_check.check import corrected_log
from estimation.sensor_check.fixed_wheels import wheel_suspicions
from estimation.weak_form.balances import Balances

MASS, INERTIA, STEP = 24.0, 2.4, 0.01
OFF = 0.15
"""How far (m) an axle is moved."""
CONSTANTS: tuple[tuple[ModuleType, str, int | None], ...] = (
    (axle, "SOUND_AXLE_STD", None),
    (axle, "WRONG_AXLE_STD", None),
    (axle, "WRONG_AXLE_ODDS", None),
    (fixed_wheels, "MAX_SIDESLIP_RATIO", None),
    (fixed_wheels, "FIXED_WHEELS_ODDS", None),
    (fixed_wheels, "FREE_CART_LOG_RATIO", 1),
    (fixed_wheels, "FIXED_WHEELS_LOG_RATIO", 0),
    (fixed_wheels, "FIXED_WHEELS_LOG_RATIO", 1),
)
"""Module, name, and which number of several."""
KINDS = ("sound", "no constraints", "axle off", "casters alone")


@dataclass(frozen=True)
class Look:
    """A log with a cart file, and what is true of that: one of KINDS."""

    kind: str
    balances: Balances
    cart: CartModel

    @property
    def told(self) -> bool:
        return bool(wheel_suspicions(self.balances, self.cart))


def on_casters(seed: int, follows_heading: bool, noise: float = 3.0, duration: float = 40.0) -> RunLog:
    """A log of a body that goes any way, with drag, pushed by one hand at its CoM with a sensor's noise (N): where it
    heads, as a robot may that tracks a path of wheels, or anywhere."""
    random = np.random.default_rng(seed)
    phases, rates = random.uniform(0, 6, 4), random.uniform(0.4, 1.2, 4)
    n = round(duration / STEP)
    pose, twist, rows = np.zeros(3), np.zeros(3), []
    for k in range(n):
        time = k * STEP
        c, s = np.cos(pose[2]), np.sin(pose[2])
        u, w = c * twist[0] + s * twist[1], c * twist[1] - s * twist[0]
        ahead = 0.4 + 0.3 * np.sin(rates[0] * time + phases[0])
        aside = 0.0 if follows_heading else 0.3 * np.sin(rates[1] * time + phases[1])
        turn = 0.5 * np.sin(rates[2] * time + phases[2])
        force = np.array([80.0 * (ahead - u), 200.0 * (aside - w) + MASS * u * twist[2], 10.0 * (turn - twist[2])])
        rows.append([time, *pose, *twist, *force])
        world = np.array([c * force[0] - s * force[1], s * force[0] + c * force[1], force[2]])
        twist = twist + STEP * (world - [3.0, 3.0, 1.0] * twist) / [MASS, MASS, INERTIA]
        pose = pose + STEP * twist
    table = np.array(rows)
    wrench = np.zeros((n, 6))
    wrench[:, [0, 1, 5]] = table[:, 7:]
    wrench += np.array([noise] * 3 + [noise / 20] * 3) * random.standard_normal((n, 6))
    sensed = table[:, 1:7] + np.repeat([5e-4, 5e-3], 3) * random.standard_normal((n, 6))
    return RunLog(table[:, 0], sensed[:, :3], sensed[:, 3:], {"hand": ArmLog(np.zeros((n, 3)), wrench)})


def looks(folder: Path) -> Iterator[Look]:
    for there in sorted((folder / "logs").iterdir()):
        log, cart = read_log(there / "run.csv"), load_cart(there / "cart.yaml")
        free = replace(cart, constraints=RollingConstraints(axle_x=None))
        moved = replace(cart, constraints=replace(cart.constraints, axle_x=float(cart.constraints.axle_x or 0.0) + OFF))
        for kind, told in zip(KINDS, (cart, free, moved), strict=False):
            yield Look(kind, Balances.of(corrected_log(log, told).log, told), told)
    free = CartModel(Inertia(MASS, (0.3, 0.05), 2.0), RollingConstraints(axle_x=None))
    for seed in range(10):
        for follows in (True, False):
            log = on_casters(seed, follows)
            yield Look(KINDS[3], Balances.of(corrected_log(log, free).log, free), free)


def counts(every: list[Look]) -> list[str]:
    by = {kind: [one.told for one in every if one.kind == kind] for kind in KINDS}
    return [f"{sum(told)} of {len(told)}" for told in by.values()]


def moved_by(every: list[Look], module: ModuleType, name: str, part: int | None, factor: float) -> list[str]:
    """The counts with a constant times a factor."""
    whole = getattr(module, name)
    parts = whole if isinstance(whole, tuple) else (whole,)
    moved = tuple(factor * one if i == (part or 0) else one for i, one in enumerate(parts))
    setattr(module, name, moved if isinstance(whole, tuple) else moved[0])
    try:
        return counts(every)
    finally:
        setattr(module, name, whole)


def table(every: list[Look], row: Callable[[str, list[str]], str]) -> Iterator[str]:
    yield row("as they are", counts(every))
    for module, name, part in CONSTANTS:
        for factor in (0.7, 1.3):
            which = "" if part is None else f"[{part}]"
            yield row(f"`{name}{which}` × {factor}", moved_by(every, module, name, part, factor))


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.wheel_faults", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    every = list(looks(parser.parse_args().folder))
    print(f"| told | {' | '.join(KINDS)} |\n| --- |{' --- |' * len(KINDS)}")
    for line in table(every, lambda name, cells: f"| {name} | {' | '.join(cells)} |"):
        print(line, flush=True)


if __name__ == "__main__":
    main()
