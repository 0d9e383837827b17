"""`python -m benchmarks.filter_faults [--seeds 0:100] [--only faults|noise|memory|late|demo|reversals|turned]`: what
the online filter says of sensors that are not as told, and whether its deviations hold.

`faults`: carts of 10 to 100 kg with drag and rolling resistance, a load put on in one run of three, first guesses from
a third to three times the mass, driven along straight and curved paths from any heading. Each log goes through the
filter as it is and with a fault in it. A fault is told where health is not `ok` and a suspicion of its kind and place
stands beside it; on a sound log any suspicion is an alarm.

`noise`: velocities 0.3 to 3 times as noisy as declared. `memory`: noise of wrenches that is as large as declared from
sample to sample, and remembers for up to 0.06 s. `late`: wrenches whose stamps are late, or early. `demo`: errors of
the demo's runs over their deviations. `reversals`: the demo's cart straight forth and back, which leaves casters
poised. `turned`: signs of wrenches that turn at 6 s.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import PayloadChange, RollingResistance, ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.frames import Array, body_to_world, wrap_angle
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate
from cartgrasp.studies import shopping_cart
from cartgrasp.studies.consistency import PRIOR, drawn_cart, exact_noise
from cartgrasp.studies.estimators import HANDS, PATHS, SENSOR_SETS, Drive, Job, drive_cart, guess
from cartgrasp.studies.scenario import filter_noise
from estimation import CartFilter, FilterNoise
from estimation.gaussian import normalised_square
from estimation.log_noise.log_noise import noise_of_log
from estimation.whole_log.replay import replay
from planning.references import chain, straight

from . import broken_sensors
from .sealed.sensors import noise as drawn_noise
from .sensor_faults import FAR, Fault, poses, wrenches

IN_TIME = 5.0
"""s of motion, in which a fault has to be told."""
TURNED_AT = 6.0
"""s."""
LASTING = 12.0
SAID_SPREAD = 0.15
"""Of a mass, where the cart's file says how sure it is."""
SOUND = "as they are"


def of_arms(kind: str, change: Callable[[ArmLog], ArmLog], arms: Sequence[str] = tuple(HANDS)) -> Fault:
    """Of some arms; without a kind the log is as good as a sound one."""

    def changed(log: RunLog) -> RunLog:
        return replace(log, arms={name: change(arm) if name in arms else arm for name, arm in log.arms.items()})

    return Fault(changed, frozenset({kind} if kind else ()))


def reversed_arm(arm: ArmLog) -> ArmLog:
    return ArmLog(arm.contact, -arm.wrench)


def spiked(arm: ArmLog) -> ArmLog:
    """One sample, at 3 s, is off by 1 kN."""
    wrench = arm.wrench.copy()
    wrench[300, 0] += 1000.0
    return ArmLog(arm.contact, wrench)


FAULTS = {
    "wrenches reversed": wrenches("sign", factors=(-1.0,) * 6),
    "kN, kN·m": wrenches("unit", factors=(1e-3,) * 6),
    "lbf, lbf·ft": wrenches("unit", factors=(1 / 4.4482216,) * 3 + (1 / 1.3558179,) * 3),
    "theta in degrees": poses("unit", lambda pose: pose * [1, 1, 180 / np.pi]),
    "theta begins three turns up": Fault(
        lambda log: replace(log, pose=np.add(log.pose, [0, 0, 6 * np.pi])), frozenset()
    ),
    "x and y in mm": poses("unit", lambda pose: pose * [1000, 1000, 1]),
    "times in ms": Fault(lambda log: replace(log, time=1000 * log.time), frozenset({"unit"})),
    "one wrench of 1 kN": of_arms("", spiked, ["left"]),
    "the left arm reversed": of_arms("sign", reversed_arm, ["left"]),
    "the right arm reversed": of_arms("sign", reversed_arm, ["right"]),
    "contacts mirrored": of_arms("frame", lambda arm: ArmLog(arm.contact * [1, -1, 1], arm.wrench)),
    "contacts 0.2 m to the left": of_arms("frame", lambda arm: ArmLog(np.add(arm.contact, [0, 0.2, 0]), arm.wrench)),
    "fz is NaN": of_arms("", lambda arm: ArmLog(arm.contact, arm.wrench * [1, 1, np.nan, 1, 1, 1])),
}
QUIET = "quiet"
"""Sensors of forces with which a run tells the mass to much less than 3 %."""
LEAST_NOISE, MOST_NOISE = 0.3, 3.0
LONGEST_MEMORY, FORCE, MOMENT = 0.06, 3.0, 0.2
"""s; N and N·m of autocorrelated noise."""
NEES, MASS, UNSOUND = 2.0, 0.03, 0.9
LATENESSES = (0.0, 0.01, 0.025, 0.05, -0.02)
"""s."""
SURE = 0.05
"""Standard deviation of a mass that is sure, as a share of it."""


@dataclass(frozen=True)
class Drawn:
    """A log, what is believed of its cart at first, and its mass (kg) at the end."""

    log: RunLog
    believed: CartModel
    mass: float


def between(random: np.random.Generator, low: float, high: float) -> float:
    """By a logarithm that is uniform."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def drawn(seed: int, is_said: bool = False) -> Drawn:
    """With a first guess anywhere from a third to three times the mass; or one whose file says how sure it is."""
    random = np.random.default_rng([seed, 7])
    mass, share = between(random, 10.0, 100.0), between(random, 1 / 3, 3.0)
    com = float(random.uniform(0.15, 0.4)), float(random.uniform(-0.08, 0.08))
    drags = between(random, 1.0, 8.0), between(random, 0.4, 3.0), between(random, 0.005, 0.03)
    load, at = float(random.uniform(0.1, 0.4)) * mass * (seed % 3 == 0), float(random.uniform(3.0, 8.0))
    off, turned = random.uniform(0.5, 2.0, 3), float(random.uniform(-np.pi, np.pi))
    if is_said:
        share = max(1.0 + SAID_SPREAD * float(random.standard_normal()), 0.5)
    body = Inertia(mass, com, 0.09 * mass)
    first = Inertia(share * mass, (0.3, 0.0), 0.09 * share * mass)
    truth = CartModel(body, RollingConstraints(), (*resistances(*drags), PayloadChange(at, load, 0.2, 0.1)))
    said = FirstGuess((("mass", SAID_SPREAD * share * mass),)) if is_said else FirstGuess()
    believed = CartModel(first, RollingConstraints(), resistances(*(drags * off)), first_guess=said)
    path = list(PATHS)[seed % len(PATHS)]
    log = drive_cart(truth, Job(path, "usual", seed), LASTING).log
    return Drawn(_turned(log, turned), believed, mass + load * (at < log.time[-1]))


def resistances(linear: float, angular: float, rolling: float) -> tuple[ViscousDrag, RollingResistance]:
    return ViscousDrag(linear, angular), RollingResistance(rolling)


def _turned(log: RunLog, angle: float) -> RunLog:
    """The same in a world that is turned."""
    turn = np.asarray(body_to_world(angle))
    pose = log.pose @ turn.T + [0.0, 0.0, angle]
    pose[:, 2] = wrap_angle(pose[:, 2])
    return replace(log, pose=pose, velocity=None if log.velocity is None else log.velocity @ turn.T)


@dataclass(frozen=True)
class Told:
    """Of a run: when a suspicion of the right kind first stood beside a health that is not `ok` (s since the cart
    moved, NaN for never), other suspicions; the mass's last error by its value and by its deviation, and whether it was
    said to be identifiable under a health of `ok`."""

    after: float
    others: tuple[str, ...]
    off: float
    deviations: float
    is_sure: bool
    unsound: float


def suspicions(estimate: Estimate) -> tuple[Any, ...]:
    return getattr(estimate, "suspicions", ())


def told(run: Drawn, fault: Fault | None) -> Told:
    log = fault.change(run.log) if fault else run.log
    kinds = fault.kinds if fault else frozenset()
    filtered = CartFilter(run.believed, list(HANDS), noise=filter_noise(SENSOR_SETS["usual"]))
    with np.errstate(all="ignore"):  # numbers may be beyond reason
        found = [filtered.update(measurement) for measurement in log.measurements()]
    begun, times = _begins(run.log), run.log.time  # whatever the fault's stamps say
    named = [
        time - begun
        for time, one in zip(times, found, strict=True)
        if one.health != "ok" and kinds & {s.kind for s in suspicions(one)}
    ]
    others = {str(s.kind) + " of " + s.where for one in found for s in suspicions(one) if s.kind not in kinds}
    mass = found[-1].parameters["mass"]
    off = mass.value - run.mass
    settled = [one.health != "ok" for time, one in zip(times, found, strict=True) if time >= begun + IN_TIME]
    is_sure = bool(mass.identifiable and found[-1].health == "ok")
    return Told(
        named[0] if named else np.nan,
        tuple(sorted(others)),
        off / run.mass,
        off / mass.std if mass.std > 0 else np.inf,
        is_sure,
        float(np.mean(settled)),
    )


def _begins(log: RunLog) -> float:
    """When the cart has gone 1 cm."""
    gone = np.hypot(*(log.pose[:, :2] - log.pose[0, :2]).T) > 0.01
    return float(log.time[int(np.argmax(gone))])


def faults(seeds: Sequence[int]) -> list[str]:
    """A line for sound logs, and for each fault."""
    lines = [
        "| | told in 5 s | later | never | something else | health not `ok` after 5 s, share of ticks | "
        "mass said identifiable and `ok`, off by more than 5 deviations |",
        "| --- " * 7 + "|",
    ]
    sound: dict[str, Fault | None] = {SOUND: None}
    cases = [(name, fault, False) for name, fault in (sound | FAULTS).items()]
    cases += [
        (f"{name}; the file says 15 %", (sound | FAULTS)[name], True) for name in (SOUND, "kN, kN·m", "lbf, lbf·ft")
    ]
    runs = {said: [drawn(seed, said) for seed in seeds] for said in (False, True)}
    for name, fault, said in cases:
        found = [told(run, fault) for run in runs[said]]
        after = np.array([one.after for one in found])
        soon, later = int((after <= IN_TIME).sum()), int((after > IN_TIME).sum())
        others = sum(bool(one.others) for one in found)
        wrong = sum(one.is_sure and abs(one.deviations) > 5 for one in found)
        which = sorted({other for one in found for other in one.others})
        is_sound = fault is None or not fault.kinds
        cells = [name, *(("", "", "") if is_sound else (soon, later, len(found) - soon - later))]
        cells += [f"{others}{': ' + ', '.join(which) if which else ''}"]
        cells += [f"{np.mean([one.unsound for one in found]):.2f}", wrong]
        lines.append(f"| {' | '.join(map(str, cells))} |")
        print(lines[-1], flush=True)
    return lines


def turned(seeds: Sequence[int]) -> list[str]:
    """A line for each kind of signs that turn on the way, and for sound logs: when they are told."""
    lines = ["| | runs | told in 5 s | later | never | s, median | told before |", "| --- " * 7 + "|"]
    runs = [drawn(seed) for seed in seeds]
    for arms in ((), tuple(HANDS), *((name,) for name in HANDS)):
        expected = "wrench" if len(arms) > 1 else "".join(arms)
        after, before = [], 0
        for run in runs:
            sign = np.where(run.log.time < TURNED_AT, 1.0, -1.0)[:, None]
            held = {name: ArmLog(arm.contact, sign * arm.wrench) for name, arm in run.log.arms.items() if name in arms}
            filtered = CartFilter(run.believed, list(HANDS), noise=filter_noise(SENSOR_SETS["usual"]))
            found = replay(replace(run.log, arms=run.log.arms | held), filtered).estimates
            named = {one.time: {s.where for s in suspicions(one) if s.kind == "sign"} for one in found}
            before += any(where for time, where in named.items() if time < TURNED_AT or not arms)
            after.append(next((time - TURNED_AT for time, where in named.items() if expected in where), np.inf))
        times = np.array(after)
        soon, never = int((times <= IN_TIME).sum()), int(np.isinf(times).sum())
        cells = [" and ".join(arms) or SOUND, len(times)]
        cells += [soon, len(times) - soon - never, never, f"{np.median(times):.1f}"] if arms else [""] * 4
        lines.append(f"| {' | '.join(map(str, [*cells, before]))} |")
        print(lines[-1], flush=True)
    return lines


def noise(seeds: Sequence[int]) -> list[str]:
    """By the size of the noise: how many runs are consistent or say that they are not."""
    factors = [between(np.random.default_rng([seed, 8]), LEAST_NOISE, MOST_NOISE) for seed in seeds]
    edges = (LEAST_NOISE, 0.6, 1.0, 1.5, 2.0, MOST_NOISE)
    return _consistent("noise over declared", edges, seeds, factors, _louder)


def memory(seeds: Sequence[int]) -> list[str]:
    """By how long noise of wrenches remembers (s): how many runs are consistent or say that they are not."""
    times = [float(np.random.default_rng([seed, 9]).uniform(0.0, LONGEST_MEMORY)) for seed in seeds]
    return _consistent("memory, s", (0.0, 0.01, 0.02, 0.04, LONGEST_MEMORY), seeds, times, _remembering)


def _consistent(
    head: str,
    edges: Sequence[float],
    seeds: Sequence[int],
    sizes: Sequence[float],
    of: Callable[[Drive, float, int], tuple[RunLog, FilterNoise]],
) -> list[str]:
    """A table by a size in bins: `of` a drive is the log with noise of that size, and what is declared."""
    rows: list[tuple[float, float, float, float]] = []
    for seed, size in zip(seeds, sizes, strict=True):
        driven = drive_cart(drawn_cart(seed), Job("curves", QUIET, seed))
        rows.append((size, *_noisy(seed, driven, *of(driven, size, seed))))
        print(seed, *(f"{value:.3f}" for value in rows[-1]), flush=True)
    lines = [
        f"| {head} | runs | NEES a degree of freedom | mass off, rms | within both | not `ok` | met |",
        "| --- " * 7 + "|",
    ]
    found = np.array(rows)
    for low, high in [*pairwise(edges), (edges[0], edges[-1])]:
        part = found[(found[:, 0] >= low) & (found[:, 0] <= high)]
        if not len(part):
            continue
        fits = (part[:, 1] < NEES) & (np.abs(part[:, 2]) < MASS)
        says = part[:, 3] >= UNSOUND
        cells = [f"{low} to {high}", len(part), f"{part[:, 1].mean():.2f}"]
        cells += [f"{100 * np.sqrt((part[:, 2] ** 2).mean()):.1f} %", fits.sum(), says.sum(), (fits | says).sum()]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return lines


def late(seeds: Sequence[int]) -> list[str]:
    """By sensors and by how late wrenches are: what is told after IN_TIME where it is sure."""
    lines = [
        "| sensors | wrenches late, ms | mass off, rms | worst rms of errors over deviations | "
        f"beyond {FAR:g} deviations where sure | not `ok` |",
        "| --- " * 6 + "|",
    ]
    for sensors in (QUIET, "usual"):
        driven = [drive_cart(drawn_cart(seed), Job(list(PATHS)[seed % len(PATHS)], sensors, seed)) for seed in seeds]
        for by in LATENESSES:
            found = [_late(drawn_cart(seed), one.log, by, sensors) for seed, one in zip(seeds, driven, strict=True)]
            ends, off, ok = zip(*found, strict=True)
            mass = np.sqrt(np.mean(np.square([end[0][0] for end in ends])))
            rms = np.sqrt(np.nanmean(np.square([end[1] for end in ends]), axis=0))
            beyond = np.concatenate(off) > FAR
            cells = [sensors, f"{1000 * by:.0f}", f"{100 * mass:.1f} %", f"{rms.max():.1f}"]
            cells += [f"{100 * beyond.mean():.1f} %", f"{100 * (1.0 - np.mean(ok)):.0f} %"]
            lines.append(f"| {' | '.join(cells)} |")
            print(lines[-1], flush=True)
    return lines


def _late(cart: CartModel, log: RunLog, by: float, sensors: str) -> tuple[Array, Array, float]:
    """The last errors of parameters by their values and by their deviations (2, p); all such numbers, by deviations,
    that are told as sure from IN_TIME on (n,); and the share of `ok`."""
    noise = exact_noise(sensors)
    filtered = CartFilter(guess(), list(HANDS), noise=noise, prior=PRIOR)
    knows = CartFilter(cart, list(HANDS), noise=noise)
    true = {name: told.value for name, told in knows.update(next(iter(log.measurements()))).parameters.items()}
    sure, healths = [], []
    for measurement in broken_sensors.late(by)(log).measurements():
        found = filtered.update(measurement)
        if found.time < IN_TIME:
            continue
        healths.append(found.health == "ok")
        if healths[-1]:
            told = found.parameters.items()
            sure += [abs(one.value - true[name]) / one.std for name, one in told if one.identifiable]
    errors = [(one.value - true[name], abs(true[name]), one.std) for name, one in found.parameters.items()]
    off, size, std = np.array(errors).T
    return np.array([off / size, off / std]), np.array(sure), float(np.mean(healths))


def _louder(driven: Drive, factor: float, seed: int) -> tuple[RunLog, FilterNoise]:
    """Velocities are so many times as noisy as declared."""
    log = driven.log
    clean = np.column_stack([np.zeros((len(log), 2)), driven.motion[:, 4]])
    clean[:, 0], clean[:, 1] = np.cos(driven.motion[:, 2]), np.sin(driven.motion[:, 2])
    clean[:, :2] *= driven.motion[:, 3:4]
    return replace(log, velocity=clean + factor * (log.velocity - clean)), exact_noise(QUIET)


def _remembering(driven: Drive, memory: float, seed: int) -> tuple[RunLog, FilterNoise]:
    """First-order autoregressive noise beside what wrenches have."""
    log, random, size = driven.log, np.random.default_rng([seed, 10]), np.repeat([FORCE, MOMENT], 3)
    arms = {
        name: ArmLog(arm.contact, arm.wrench + size * drawn_noise(arm.wrench.shape, log.time, memory, random))
        for name, arm in log.arms.items()
    }
    declared = exact_noise(QUIET)
    return replace(log, arms=arms), replace(
        declared, force=float(np.hypot(declared.force, FORCE)), moment=float(np.hypot(declared.moment, MOMENT))
    )


def _noisy(seed: int, driven: Drive, log: RunLog, declared: FilterNoise) -> tuple[float, float, float]:
    """NEES a degree of freedom of motion and parameters, mean after IN_TIME; the last mass's error by its value; and
    the share of ticks after IN_TIME at which health is not `ok`."""
    cart = drawn_cart(seed)
    filtered = CartFilter(guess(), list(HANDS), noise=declared, prior=PRIOR)
    squares, unsound, dof = [], [], 0
    for i, measurement in enumerate(log.measurements()):
        found = filtered.update(measurement)
        if found.time < IN_TIME:
            continue
        belief = filtered.belief
        off = belief.mean - driven.motion[i]
        off[2] = wrap_angle(off[2])
        wrong = found.model_parameters - cart.parameters
        squares.append(_nees(off, belief.covariance) + _nees(wrong, found.covariance))
        dof = len(off) + len(wrong)
        unsound.append(found.health != "ok")
    mass = found.parameters["mass"].value / cart.inertia.mass - 1.0
    return float(np.mean(squares)) / dof, mass, float(np.mean(unsound))


def _nees(off: Array, covariance: Array) -> float:
    return float(normalised_square(off, covariance))


def demo(seeds: Sequence[int]) -> list[str]:
    """Rms over seeds of each parameter's last error over its deviation: in the loop, and as `cartgrasp estimate` reads
    the noise off the log."""
    errors: dict[str, list[tuple[float, float]]] = {}
    for seed in seeds:
        record, again = shopping_cart.scenario(seed=seed).run(), shopping_cart.first_guess()
        learner = CartFilter(again, noise=noise_of_log(record.log, again))
        for measured in record.log.measurements():
            told = learner.update(measured)
        for name, series in record.parameters.items():
            if series.truth is not None and series.std[-1] > 0:
                off, read = series.value[-1] - series.truth[-1], told.parameters[name]
                both = float(off / series.std[-1]), (read.value - float(series.truth[-1])) / read.std
                errors.setdefault(name, []).append(both)
        print(seed, {name: np.round(values[-1], 2).tolist() for name, values in errors.items()}, flush=True)
    lines = ["| parameter | rms | mean | of its log: rms | mean |", "| --- | --- | --- | --- | --- |"]
    for name, values in errors.items():
        rms, mean = np.sqrt(np.mean(np.square(values), axis=0)), np.mean(values, axis=0)
        lines.append(f"| {name} | {rms[0]:.2f} | {mean[0]:+.2f} | {rms[1]:.2f} | {mean[1]:+.2f} |")
    return lines


def reversals(seeds: Sequence[int]) -> list[str]:
    """Of ticks after 5 s: shares by what health is told, and of those that are sure of a mass that is three deviations
    off or more."""
    stretches = chain(*(straight(1.5 * way, 0.5) for way in 5 * (1.0, -1.0)))
    lines = [
        "| seed | ok | load_changed | inconsistent | else | sure and off | mass at the end, kg |",
        "|" + " --- |" * 7,
    ]
    for seed in seeds:
        record = replace(shopping_cart.scenario(seed=seed), stretches=stretches, duration=None).run()
        later, mass = record.log.time > 5.0, record.parameters["mass"]
        assert mass.truth is not None
        healths = np.array([str(health) for health in record.healths])[later]
        off, sure = np.abs(mass.value - mass.truth), mass.std < SURE * mass.value
        shares = [np.mean(healths == name) for name in ("ok", "load_changed", "inconsistent")]
        wrong = np.mean((sure & (off > 3.0 * mass.std))[later])
        cells = [f"{100 * share:.0f} %" for share in (*shares, 1.0 - sum(shares), wrong)]
        lines.append(f"| {seed} | {' | '.join(cells)} | {mass.value[-1]:.2f} ± {mass.std[-1]:.2f} |")
        print(lines[-1], flush=True)
    return lines


PARTS = {
    "faults": (faults, 100),
    "noise": (noise, 100),
    "memory": (memory, 100),
    "late": (late, 20),
    "demo": (demo, 30),
    "reversals": (reversals, 10),
    "turned": (turned, 12),
}


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.filter_faults", description=__doc__)
    parser.add_argument("--seeds", default=None, metavar="A:B", help="from 0 on; without, as many as the part needs")
    parser.add_argument("--only", choices=PARTS, help="one part alone")
    options = parser.parse_args()
    for name, (part, usual) in PARTS.items():
        if options.only in (None, name):
            begin, end = map(int, (options.seeds or f"0:{usual}").split(":"))
            print(f"\n## {name}\n", *part(range(begin, end)), sep="\n", flush=True)


if __name__ == "__main__":
    main()
