"""Force sensors: their components and units, and whether their numbers are what the arm does to the cart."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....frames import Array
from ...run_log import WRENCH_COLUMNS
from ..table_map import DIMENSIONS
from ..units import UNITS
from .columns import Column, FileColumns
from .evidence import MassRegression, Motion, mass_regression
from .motion_units import Clock, Entry, one_of_several
from .proposed_value import ProposedValue

PLAUSIBLE_MASSES = (0.3, 3000.0)
"""kg, of what is pushed."""
PLANAR_COMPONENTS = frozenset(("fx", "fy", "tz"))
MAX_CLOCK_LAG = 3.0
"""s: how far apart two clocks that each begin at zero are looked for."""
FILE_WORDS = frozenset(["ft", "force", "wrench", "sensor", "log", "run", "data", "loadcell", "kraft"])

UNKNOWN_FORCE_CONVENTION = ProposedValue(
    None, False, "on_cart: what the arm does to the cart; on_sensor: what the sensor feels"
)
PROPOSED_ZERO = ProposedValue(0.0)


@dataclass(frozen=True, eq=False)
class Arm:
    """One sensor: its file with its clock, its columns by component, and what is said of them."""

    name: str
    file: FileColumns
    clock: Clock
    columns: Mapping[str, Column]
    force: ProposedValue = UNKNOWN_FORCE_CONVENTION
    yaw: ProposedValue = PROPOSED_ZERO
    latency: ProposedValue = PROPOSED_ZERO
    likely: str = "N"
    """The unit assumed for forces without a label: one with which the mass is plausible."""
    length: str = "m"

    @property
    def measures(self) -> list[str]:
        return [name for name in WRENCH_COLUMNS if name in self.columns]

    @property
    def contact(self) -> dict[str, Column]:
        return {name: self.columns[name] for name in ("px", "py", "pz") if name in self.columns}

    def unit(self, component: str) -> ProposedValue:
        """The unit that a component's label states, else a usual one that is to be confirmed."""
        column, dimension = self.columns[component], DIMENSIONS[component]
        if column.odd:
            return ProposedValue(None, False, f"its label says {column.odd}")
        if column.unit is not None:
            return ProposedValue(column.unit)
        default = {"force": self.likely, "moment": "N·m", "length": self.length}[dimension]
        return ProposedValue(default, False, "no unit is in its name")

    def entry(self, component: str) -> Entry:
        column = self.columns[component]
        return Entry(one_of_several(column, self.file.is_only(column)), self.unit(component))

    @property
    def unmeasured(self) -> ProposedValue | None:
        """Nothing is asked where only what presses down is not measured."""
        rest = [name for name in WRENCH_COLUMNS if name not in self.columns]
        if not rest:
            return None
        if set(self.columns) >= PLANAR_COMPONENTS:
            return ProposedValue("zero", True, f"{', '.join(rest)} only move load between the wheels")
        return ProposedValue(None, False, f"zero if {', '.join(rest)} are known to be nothing, else missing")

    def si(self, component: str) -> Array:
        """(n,), as far as its unit is told; zero if it isn't measured."""
        if component not in self.columns:
            return np.zeros(len(self.clock.time))
        unit = self.unit(component).value
        size = UNITS[DIMENSIONS[component]][str(unit)] if unit is not None else 1.0
        return self.columns[component].said * size


def arms_of(files: Sequence[FileColumns]) -> list[Arm]:
    """The arms in all files, with names that differ."""
    found: list[Arm] = []
    for file in files:
        words = [] if file is files[0] else re.split(r"[^a-z]+", file.path.stem.lower())
        telling, clock = [word for word in words if word and word not in FILE_WORDS], Clock.of(file)
        for group, columns in file.arms.items():
            name = f"arm{group}" if group.isdigit() else group or (telling[-1] if telling else "arm")
            taken = {one.name for one in found} | {"pose"}
            free = next(n for n in (name, *(f"{name}_{k}" for k in range(2, 99))) if n not in taken)
            found.append(Arm(free, file, clock, columns))
    return found


def judged(arms: Sequence[Arm], motion: Motion | None, time: Array, heading: Array | None) -> list[Arm]:
    """What forces along the cart, all arms' together, say of signs and axes; nothing where there is no heading."""
    if motion is None or heading is None or not arms:
        return list(arms)
    along = motion.on(time, heading)
    arms = [replace(arm, latency=_latency(arm, motion, along, time)) for arm in arms]
    pushes = {name: mass_regression(motion, along, _total(arms, motion, name)) for name in ("fx", "fy")}
    if pushes["fx"] is not None and pushes["fx"].is_sure and abs(pushes["fx"].mass) < PLAUSIBLE_MASSES[0]:
        arms = [replace(arm, likely="kN") for arm in arms]
        pushes["fx"] = mass_regression(motion, along, _total(arms, motion, "fx"))
    return [_told(arm, pushes["fx"], pushes["fy"]) for arm in arms]


def _total(arms: Sequence[Arm], motion: Motion, component: str, lag: float = 0.0) -> Array:
    parts = [motion.smoothed(arm.clock.time - lag, arm.si(component)) for arm in arms]
    return np.asarray(np.sum(parts, axis=0))


def _told(arm: Arm, fx: MassRegression | None, fy: MassRegression | None) -> Arm:
    if fx is not None and fx.is_sure:
        return replace(arm, force=_sign(fx))
    if fy is not None and fy.is_sure and (fx is None or fy.explained > fx.explained + 0.3):
        where = "the sensor's y points along the cart, forwards or backwards"
        why = f"fy, not fx, goes with how the cart speeds up: {where}"
        quarter = round(float(-np.pi / 2 if fy.mass > 0 else np.pi / 2), 4)
        return replace(arm, yaw=ProposedValue(quarter, False, why), force=ProposedValue("on_cart", False, why))
    return arm


def _sign(fx: MassRegression) -> ProposedValue:
    """A pushed cart speeds up by the force on it, and costs work."""
    mass, side = f"{abs(fx.mass):.3g} kg", "on_cart" if fx.mass > 0 else "on_sensor"
    if not PLAUSIBLE_MASSES[0] <= abs(fx.mass) <= PLAUSIBLE_MASSES[1]:
        return ProposedValue(side, False, f"it tells {mass}: look at units")
    if fx.mass > 0 and fx.power > 0:
        return ProposedValue(side, True, f"the cart speeds up with fx ({mass})")
    if fx.mass < 0 and fx.power < 0:
        why = f"the cart slows down with fx ({mass}): felt by the sensor, or its x points backwards"
        return ProposedValue(side, False, why)
    return ProposedValue(side, False, f"it tells {mass}, but takes work out of it: look at signs")


def _latency(arm: Arm, motion: Motion, along: Array, time: Array) -> ProposedValue:
    """The latency (s) of an arm with a clock of its own that begins at zero as the other does. It is sure to be 0 where
    forces fit the motion best without a lag."""
    own, begins = arm.clock.time, min(float(np.nanmin(arm.clock.time)), float(np.nanmin(time)))
    if arm.clock.column is None or np.array_equal(own, time, equal_nan=True) or begins > 1000:
        return ProposedValue(0.0)
    lags = np.arange(-MAX_CLOCK_LAG, MAX_CLOCK_LAG + 0.05, 0.1)
    fits = [mass_regression(motion, along, _total([arm], motion, "fx", float(lag))) for lag in lags]
    explained = np.array([0.0 if one is None else one.explained for one in fits])
    at_best = int(np.argmax(explained))
    is_peak = 0 < at_best < len(lags) - 1 and explained[at_best] > 0.5
    at_zero = float(explained[int(np.argmin(np.abs(lags)))])
    if at_zero > 0.5 and explained.max() - at_zero < 0.05:
        return ProposedValue(0.0, True, "forces fit the motion best without a lag")
    guess = round(float(lags[at_best]), 1) if is_peak else 0.0
    return ProposedValue(guess, False, "did both clocks begin at the same moment?")
