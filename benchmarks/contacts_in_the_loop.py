"""How soon the CoM is known, and at which effort, by the way in which contacts are chosen in the closed loop.

    python -m benchmarks.contacts_in_the_loop [--seeds 0:10] [--cases 0,1] [--out FILE]

A platform truck in MuJoCo: fixed wheels ahead, casters behind, the handle 0.9 m behind the axle. Mass 20 to 50 kg, CoM
0.25 to 0.5 m behind the axle and up to 0.1 m aside are drawn by seed; the first guess is 20 kg, 0.4 m, in the middle.
Two hands may hold the handle, the side rail's middle, or the rail beside the axle; they begin at the handle unless told
otherwise. Sensors have 3 N and 0.15 N·m of noise at 100 Hz. A regrasp takes 0.6 s and the way at 0.8 m/s; a hand leaves
when the other can do without it.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment, RollingResistance, ViscousDrag
from cartgrasp.frames import Array
from cartgrasp.inertia import Inertia
from cartgrasp.information import WrenchNoise
from cartgrasp.model import CartModel
from cartgrasp.simulation.closed_loop import run
from cartgrasp.simulation.record import RunRecord
from cartgrasp.simulation.sensors import SensorNoise
from cartgrasp.studies.run_figures import RunFigures
from cartgrasp.studies.scenario import MUJOCO_PLANT, Scenario, with_truth
from cartgrasp.studies.shopping_cart import FIRM_GAINS
from cartgrasp.wheels import CASTER, FIXED, Wheel
from estimation import FilterNoise
from planning import Choosing, RegraspTimes
from planning.references import chain, pause, speed_change, turn

WHEELS = (
    *(Wheel(FIXED, 0.0, y) for y in (0.27, -0.27)),
    *(Wheel(CASTER, -0.8, y, trail=0.045) for y in (0.25, -0.25)),
)
PLACES = ((-0.9, 0.2, 1.0), (-0.45, 0.3, 0.8), (0.0, 0.3, 0.8))
FORCE, MOMENT, WEIGHTS = 3.0, 0.15, np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
BEND = (*turn(np.pi / 2, 0.4), *pause(2.0), *turn(-np.pi / 2, 0.4), *pause(2.0))
STRAIGHT, CURVES = "straight, with a stop", "curves"
PATHS = {
    STRAIGHT: chain(
        speed_change(0.6), pause(6.0), speed_change(-0.6), speed_change(0.6), pause(6.0), speed_change(-0.6)
    ),
    CURVES: chain(speed_change(0.6), pause(2.0), BEND, BEND, speed_change(-0.6)),
}
ASKED = {STRAIGHT: {"com_y": 0.01}, CURVES: {"com_x": 0.02, "com_y": 0.02}}
DRAG = ViscousDrag(2.0, 0.4), RollingResistance(0.015)
GUESSED_DRAG = ViscousDrag(3.0, 1.0), RollingResistance(0.02)


@dataclass(frozen=True)
class Way:
    """A way to choose, by its name; the share of effort that it may spend on learning; whether the hands `begin` at
    their first place, the handle, and which place is the first one."""

    contacts: str
    extra_effort: float = 0.3
    begin: bool = True
    first: int = 0


WAYS = {
    "fixed: the handle": Way("fixed"),
    "fixed: beside the axle": Way("fixed", first=2),
    "periodic, every 3 s": Way("periodic"),
    "teach, 30 % more effort": Way("teach"),
    "teach, twice the effort": Way("teach", 1.0),
    "teach, 30 %, begins anywhere": Way("teach", begin=False),
}


@dataclass(frozen=True)
class Floor:
    """What the floor does: the casters' swivel torque (N·m), and whether drag and rolling resistance are known."""

    swivel_torque: float
    drag_known: bool

    @property
    def words(self) -> str:
        known = "drag known, as in the paper" if self.drag_known else "drag guessed, and learned"
        return f"{known}; swivels of {self.swivel_torque:g} N·m"


FLOORS = (Floor(0.0, True), Floor(0.0, False), Floor(0.12, True))


def scenario(path: str, way: Way, floor: Floor, seed: int) -> Scenario:
    random = np.random.default_rng([9, seed])
    mass, x, y, about = (random.uniform(*span) for span in ((20, 50), (-0.5, -0.25), (-0.1, 0.1), (2.5, 5.0)))
    casters = (CasterRealignment(swivel_torque=floor.swivel_torque),) if floor.swivel_torque else ()
    drag = DRAG if floor.drag_known else GUESSED_DRAG
    cart = CartModel(Inertia(mass, (x, y), about), RollingConstraints(), (*DRAG, *casters), WHEELS, com_height=0.45)
    noise = SensorNoise(0.0004, 0.0004, 0.005, 0.005, FORCE, MOMENT)
    return Scenario(
        truth=cart,
        guess=replace(cart, inertia=Inertia(20.0, (-0.4, 0.0), 3.0), effects=(*drag, *casters)),
        arms=arms(way.first),
        stretches=PATHS[path],
        sensors=noise,
        noise=FilterNoise(0.0004, 0.0004, 0.005, 0.005, FORCE, MOMENT, disturbance=0.1, slip=0.0005),
        known=frozenset({"viscous_drag", "rolling_resistance"}) if floor.drag_known else frozenset(),
        plant=MUJOCO_PLANT,
        contacts=way.contacts,
        choosing=Choosing(3.0, asked=ASKED[path], extra_effort=way.extra_effort, noise=WrenchNoise(FORCE, MOMENT)),
        regrasp=RegraspTimes(speed=0.8),
        gains=FIRM_GAINS,
        seed=seed,
    )


def arms(first: int) -> tuple[Arm, ...]:
    limits = {"force_limit": (80.0, 60.0, 40.0), "moment_limit": (12.0, 12.0, 15.0)}
    order = PLACES[first:] + PLACES[:first]
    sides = {"left": 1, "right": -1}
    return tuple(Arm(name, [(x, side * y, z) for x, y, z in order], **limits) for name, side in sides.items())


@dataclass(frozen=True)
class Found:
    """Of one run: when all that is asked was known for good (s, inf where never), effort until then and in all (N²·s),
    errors of com_x and com_y at the end with what the filter claims (m), and how often hands moved."""

    known: float
    effort: float
    errors: Array
    stds: Array
    regrasps: int
    largest_error: float

    @classmethod
    def of(cls, record: RunRecord, asked: dict[str, float]) -> Found:
        rates = np.sum([w**2 @ WEIGHTS for w in record.wrenches.values()], axis=0)
        told = [record.parameters[name] for name in ("com_x", "com_y")]
        truths = [0.0 if one.truth is None else one.truth[-1] for one in told]
        figures = RunFigures.of(record)
        return cls(
            known=known_from(record, asked),
            effort=float(rates.sum() * (record.time[1] - record.time[0])),
            errors=np.array([one.value[-1] - truth for one, truth in zip(told, truths, strict=True)]),
            stds=np.array([one.std[-1] for one in told]),
            regrasps=figures.regrasps,
            largest_error=figures.largest_error,
        )


def known_from(record: RunRecord, asked: dict[str, float]) -> float:
    """The time from which on every deviation stays as small as asked."""
    open_yet = np.any([record.parameters[name].std > std for name, std in asked.items()], axis=0)
    last = np.flatnonzero(open_yet)
    if not len(last):
        return 0.0
    return float(record.time[last[-1] + 1]) if last[-1] + 1 < len(open_yet) else np.inf


def drive(path: str, way: Way, floor: Floor, seed: int) -> Found:
    made = scenario(path, way, floor, seed)
    parts = {"held": {arm.name: arm.contacts.points[0] for arm in made.arms}} if way.begin else {}
    return Found.of(with_truth(run(made.build(**parts)), made.truth), ASKED[path])


COLUMNS = (
    *("way", "known after s", "of fixed", "never", "effort N²·s", "of fixed", "regrasps"),
    *("CoM x: sd, error mm", "CoM y: sd, error mm", "off path, most mm"),
)


def table(path: str, floor: Floor, seeds: range) -> str:
    asked = ", ".join(f"{name} to {100 * std:g} cm" for name, std in ASKED[path].items())
    lines = [f"### {path}: {asked}; {floor.words}", "", f"| {' | '.join(COLUMNS)} |", f"|{' --- |' * len(COLUMNS)}"]
    found = {}
    for name, way in WAYS.items():
        found[name] = [drive(path, way, floor, seed) for seed in seeds]
        lines.append(f"| {name} | {' | '.join(cells(found[name], found['fixed: the handle']))} |")
        print(path, floor.words, lines[-1], file=sys.stderr, flush=True)
    return "\n".join(lines)


def cells(runs: list[Found], fixed: list[Found]) -> list[str]:
    times, first = (np.median([one.known for one in group]) for group in (runs, fixed))
    effort, least = (np.mean([one.effort for one in group]) for group in (runs, fixed))
    sd, error = (1000 * np.sqrt(np.mean([getattr(one, n) ** 2 for one in runs], axis=0)) for n in ("stds", "errors"))
    return [
        f"{times:.2f}" if np.isfinite(times) else "-",
        f"{times / first:.2f}" if np.isfinite(times) and np.isfinite(first) and first > 0 else "-",
        str(sum(not np.isfinite(one.known) for one in runs)),
        f"{effort:.0f}",
        f"{effort / least:.2f}",
        f"{np.mean([one.regrasps for one in runs]):.1f}",
        *(f"{a:.1f}, {b:.1f}" for a, b in zip(sd, error, strict=True)),
        f"{1000 * max(one.largest_error for one in runs):.0f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.contacts_in_the_loop", description=__doc__)
    parser.add_argument("--seeds", default="0:10", help="FIRST:END")
    parser.add_argument("--cases", default="0,1,2,3,4,5", help="of floors, and on each the straight path and curves")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write markdown there instead of printing it")
    options = parser.parse_args()
    seeds = range(*map(int, options.seeds.split(":")))
    cases = [(path, floor) for floor in FLOORS for path in PATHS]
    asked = [cases[int(k)] for k in options.cases.split(",")]
    text = "\n\n".join(table(path, floor, seeds) for path, floor in asked) + "\n"
    if options.out is None:
        print(text)
    else:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
