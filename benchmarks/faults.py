"""`python -m benchmarks.faults [--whole] [--seeds 0:10000] [--workers 2]`: faults in the controller's loop, drawn.

A cart of 24 kg that is guessed at 20 kg, two hands of 60 N and 8 N·m. In the first two seconds of a path one thing goes
wrong for 0.05 to 0.8 s: poses are gone, or all that is sensed; they are no numbers, jump by a metre, or come 0.2 s
late; the tracker has frozen, which repeats what it told last, has another origin, or headings that are turned; wrenches
are not told, or told as -9999; an arm gives nothing; or the path asks for more than the hands can give. At no tick may
a wrench be beyond a limit, or no number. 2 s after the fault the cart has to be at rest, or on its path. With `--whole`
hands regrasp all the time, their wrenches change by 600 N/s at most, and the cart must not skid or tip over with 99 %;
a wrench that changes faster, or of a hand on its way, is beyond a limit then.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.cli.output import progress
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.studies.parallel import run_all
from cartgrasp.studies.shopping_cart import WHEELS
from estimation import DisturbedFilter, FilterNoise
from planning import Choosing, Controller, PathReference, Skid, TipOver, chain, pause
from planning.references import speed_change, turn

from .sealed.__main__ import seeds

TRUTH = CartModel(Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2),), wheels=WHEELS, com_height=0.45)
GUESS = TRUTH.with_inertia(Inertia(20.0, (0.25, 0.0), 2.0))
SURE = FirstGuess((("mass", 4.0), ("com_x", 0.05), ("com_y", 0.05), ("inertia", 0.5)))
FORCE, MOMENT, RATE = 60.0, 8.0, 600.0
NEAR, SLOW, AFTER = 0.05, 0.02, 2.0
"""m from the path, m/s and rad/s at rest, s."""
ODD = (np.nan, np.inf, -np.inf, 1e300, -1e12)
FIRST_KINDS = ("no pose", "nothing", "odd", "jumps", "late", "no wrench", "lost arm", "too much asked")
LATER_KINDS = ("frozen", "origin", "turned", "no reading")
KINDS = (*FIRST_KINDS, *LATER_KINDS)


@dataclass(frozen=True)
class Fault:
    """What goes wrong, from when to when (s); and by how much a source of poses is off (3,), m and rad."""

    kind: str
    begin: float
    end: float
    off: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Fault:
        begin, kind = float(random.uniform(0.5, 1.5)), str(random.choice(FIRST_KINDS))
        end = begin + float(random.uniform(0.05, 0.8))
        if random.random() < len(LATER_KINDS) / len(KINDS):
            kind = str(random.choice(LATER_KINDS))
        x, y, heading = random.uniform(-1.0, 1.0, 3) * (5.0, 5.0, np.pi)
        return cls(kind, begin, end, (x, y, 0.0) if kind == "origin" else (0.0, 0.0, heading))

    def acts(self, time: float) -> bool:
        return self.begin <= time < self.end

    @property
    def path(self) -> PathReference:
        """A curve; where too much is asked, with 190 N in the middle of it."""
        if self.kind != "too much asked":
            return PathReference(chain(speed_change(0.4), turn(0.3, 0.3), pause(3.0), speed_change(-0.4)))
        jerk = 8.0 * min(self.end - self.begin, 0.1)
        first, faster = pause(self.begin), speed_change(jerk, 8.0)
        return PathReference(chain(speed_change(0.2, 1.0), first, faster, pause(3.0), speed_change(-0.2 - jerk)))


@dataclass(frozen=True)
class Outcome:
    """By how much a wrench was beyond its limit (N or N·m, infinite if it is no number), how far the cart was from its
    path at last (m), and how fast (m/s, rad/s)."""

    kind: str
    beyond: float
    off: float
    speed: float

    @property
    def is_safe(self) -> bool:
        return self.beyond <= 1e-6 and (self.off < NEAR or self.speed < SLOW)


def controller_of(path: PathReference, whole: bool) -> Controller:
    """One whose hands stay, at any rate; or, `whole`, one that does all it can."""
    limits = {"force_limit": (FORCE,) * 3, "moment_limit": (MOMENT,) * 3}
    sides = (("left", 0.2), ("right", -0.2))
    guess = replace(GUESS, first_guess=SURE) if whole else GUESS
    learner = DisturbedFilter(guess, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))
    if not whole:
        arms = [Arm(name, [(-0.25, y, 1.0)], **limits) for name, y in sides]
        return Controller(guess, arms, path, estimator=learner, regrasp=None)
    arms = [Arm(name, [(-0.25, y, 1.0), (-0.15, y, 0.9)], wrench_rate=(RATE,) * 6, **limits) for name, y in sides]
    kept = {"cart_limits": [Skid(0.5), TipOver(10.0)], "confidence": 0.99}
    return Controller(
        guess, arms, path, estimator=learner, contacts="periodic", choosing=Choosing(every=0.7), drift=10.0, **kept
    )


def run(seed: int, whole: bool = False) -> Outcome:
    random = np.random.default_rng([seed, 33])
    fault = Fault.drawn(random)
    controller = controller_of(fault.path, whole)
    controller.warm_up()
    last = {"left": np.zeros(6), "right": np.zeros(6)}
    plant, sensors = ModelPlant(TRUTH), Sensors(TRUTH, SensorNoise(force=1.0, moment=0.05), seed)
    beyond, off, held = 0.0, np.inf, Measurement(0.0)
    for k in range(round((fault.end + AFTER) / 0.01)):
        acts = fault.acts(0.01 * k)
        measured = sensors.motion(plant.time, plant.motion)
        held = held if acts else measured
        step = controller.step(_spoiled(fault, measured, held, random) if acts else measured)
        beyond = max(beyond, *(_beyond(wrench) for wrench in step.wrenches.values()))
        if whole:
            changes = [float(np.abs(step.wrenches[name] - last[name]).max()) - RATE * 0.01 for name in last]
            away = [float(np.abs(step.wrenches[name]).max()) for name in last if step.hands[name].is_away]
            beyond, last = max(beyond, *changes, *away), dict(step.wrenches)
        given = step.given
        felt = sensors.wrenches(plant.time, given)
        if acts and fault.kind == "lost arm":
            given = ContactWrenches({**given.wrenches, "left": np.zeros(6)}, given.contacts)
            felt = Measurement(felt.time, wrenches={**felt.wrenches, "left": np.zeros(6)}, contacts=felt.contacts)
        if acts and fault.kind == "no reading":
            felt = replace(felt, wrenches=dict.fromkeys(felt.wrenches, np.full(6, -9999.0)))
        controller.observe(Measurement(felt.time) if acts and fault.kind == "no wrench" else felt)
        off = float(np.hypot(*(plant.motion.pose_sb - step.reference.pose_sb)[:2]))
        plant.step(given, 0.01)
    return Outcome(fault.kind, beyond, off, float(np.abs(plant.motion.velocity).max()))


def _spoiled(fault: Fault, measured: Measurement, held: Measurement, random: np.random.Generator) -> Measurement:
    """One tick of a fault of the senses; `held` is what was told before it."""
    kind, time, pose, velocity = fault.kind, measured.time, measured.pose, measured.velocity
    if kind == "no pose":
        return Measurement(time, None, velocity)
    if kind == "nothing":
        return Measurement(time)
    if kind == "frozen":
        return Measurement(time, held.pose, held.velocity)
    if kind == "odd":
        return Measurement(time, np.full(3, random.choice(ODD)), np.full(3, random.choice(ODD)))
    if kind in ("origin", "turned"):
        return Measurement(time, pose + np.array(fault.off), velocity)
    if kind == "jumps":
        return Measurement(time, pose + random.normal(0.0, 1.0, 3) * (random.random() < 0.3), velocity)
    return Measurement(time - 0.2 * (kind == "late"), pose, velocity)


def _beyond(wrench: np.ndarray) -> float:
    """By how much (N or N·m) a wrench (6,) is beyond its limit."""
    if not np.isfinite(wrench).all():
        return np.inf
    return max(float((np.abs(wrench) - np.repeat([FORCE, MOMENT], 3)).max()), 0.0)


def quietly(seed: int, whole: bool = False) -> Outcome:
    """A run in which numbers that are none are met on purpose."""
    with np.errstate(invalid="ignore", over="ignore"):
        return run(seed, whole)


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.faults", description=__doc__)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--seeds", type=seeds, default=range(10_000), metavar="A:B")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    options = parser.parse_args()
    with progress("faults") as told:
        found = run_all(partial(quietly, whole=options.whole), options.seeds, options.workers, told)
    print("| fault | runs | safe | beyond a limit, N | m off the path at last: median | p99 | most | unsafe seeds |")
    print("| --- " * 8 + "|")
    for kind in KINDS:
        own = [(seed, one) for seed, one in zip(options.seeds, found, strict=True) if one.kind == kind]
        if own:
            off = np.array([one.off for _, one in own])
            cells = [kind, len(own), sum(one.is_safe for _, one in own), f"{max(one.beyond for _, one in own):.1e}"]
            cells += [f"{np.median(off):.3f}", f"{np.quantile(off, 0.99):.3f}", f"{off.max():.3f}"]
            cells.append(", ".join(str(seed) for seed, one in own if not one.is_safe))
            print(f"| {' | '.join(map(str, cells))} |", flush=True)


if __name__ == "__main__":
    main()
