"""`python -m benchmarks.slopes [--seeds 0:20] [--constants] [--data DIR]`: carts on floors whose slope nobody told of.

Carts of 12 to 80 kg with drag and rolling resistance, first guesses off by a third, are driven by the controller: on a
curve and back, or straight to and fro. Floors slope along x and y by a normal deviation of 0, 0.01 or 0.02. The filter
takes them for level (`Prior(slope=0)`, as until 2026-11-30), or counts with a slope. Told are, at 2, 5 and 18 s, the
runs whose health is `ok`, and of those the rms of (error / deviation) of each parameter; the largest of one that is
said to be identifiable; and the median deviation of mass and CoM, and of the rolling resistance over its value.

With `--constants` the prior's slope is taken 30 % less and more, as are the bounds of a slope; with `--data` beside it
the share of time in which something may push a `DisturbedFilter`'s cart, and in the end taken to be no matter. With
`--data` measured logs (`benchmarks.measured`) are gone through in place of that, by both filters, from masses that are
0.6, 1 and 1.6 times the first guess: told are the mass at last, the last health, the share of samples at which it was
`ok`, and that at which the mass was said to be identifiable and is more than three deviations from what is known of
it.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.effects import FloorSlope, RollingResistance, UnknownSlope, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import read_log
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate
from cartgrasp.studies.shopping_cart import WHEELS
from estimation import FilterNoise, Prior
from estimation.log_noise.log_noise import noise_of_log
from estimation.online.disturbance import disturbed_learning
from estimation.whole_log.replay import replay
from planning import Controller, PathReference, chain, pause, straight
from planning.references import speed_change, turn

from .measured.carts import guessed
from .measured.logs import LOGS
from .measured.truths import Interval
from .wrong_motion import FILTERS, ticks

PATHS = {
    "curved": chain(speed_change(0.6), turn(0.8, 0.3), pause(3.0), turn(-0.8, 0.3), speed_change(-0.6)),
    "straight": chain(straight(2.0, 0.6), pause(1.0), straight(-2.0, 0.6), pause(1.0), straight(3.0, 0.5)),
}
TIMES = 2.0, 5.0, 18.0
"""s."""
HOLDS = (("left", 0.2), ("right", -0.2))
DEVIATIONS = 3.0
NAMES = "mass", "com_x", "com_y", "inertia", "rolling_resistance.coefficient"
HEADER = ("floor", "path", "filter", "prior's slope", "s", "`ok`", *NAMES, "largest", "mass ±", "CoM ±", "resistance ±")


@dataclass(frozen=True)
class Told:
    """Errors (k,) of `NAMES` over their deviations, these, which are said to be identifiable, and whether health is
    `ok`."""

    errors: np.ndarray
    deviations: np.ndarray
    taught: np.ndarray
    is_ok: bool

    @classmethod
    def of(cls, estimate: Estimate, truth: CartModel) -> Told:
        body, resistance = truth.inertia, truth.effects[-1]
        true = np.array([body.mass, *body.com, body.about_com, resistance.values[0]])
        found = [estimate.parameters[name] for name in NAMES]
        values, std = np.array([one.value for one in found]), np.array([one.std for one in found])
        return cls(
            (values - true) / std, std / true, np.array([p.identifiable for p in found]), estimate.health == "ok"
        )


def driven(seed: int, grade: float, path: str, kind: str, prior: Prior) -> list[Told]:
    """What is told at `TIMES`."""
    random = np.random.default_rng([seed, 17])
    mass, com = float(np.exp(random.uniform(np.log(12.0), np.log(80.0)))), random.uniform([0.1, -0.12], [0.5, 0.12])
    inertia, believed = mass * random.uniform(0.25, 0.4) ** 2, mass * float(np.exp(0.3 * random.normal()))
    resistance, off = float(random.uniform(0.006, 0.02)), random.normal(size=2) * [0.1, 0.05]
    truth = _cart(mass, com, inertia, 0.1 * mass * random.uniform(0.5, 1.5), resistance)
    guess = _cart(believed, com + off, 0.09 * believed, 0.1 * believed, 0.012)
    on_slope = truth.with_effect(FloorSlope(*(grade * random.normal(size=2))))
    hands = [Arm(name, [(-0.25, y, 1.0)], force_limit=(200.0,) * 3, moment_limit=(30.0,) * 3) for name, y in HOLDS]
    noise = FilterNoise(force=1.0, moment=0.05)
    learner = FILTERS[kind](guess, [name for name, _ in HOLDS], noise=noise, prior=prior)
    reference = PathReference(PATHS[path])
    controller = Controller(guess, hands, reference, estimator=learner, regrasp=None, caution=None)
    steps = [step for step, _ in ticks(controller, on_slope, TIMES[-1] + 0.005, seed=seed)]
    return [Told.of(steps[round(time / 0.01)].estimate, truth) for time in TIMES]


def rows(seeds: Sequence[int], priors: dict[str, Prior], kinds: Sequence[str]) -> Iterator[tuple[str, ...]]:
    for grade, path, kind, (name, prior) in product((0.0, 0.01, 0.02), PATHS, kinds, priors.items()):
        runs = [driven(seed, grade, path, kind, prior) for seed in seeds]
        for time, told in zip(TIMES, zip(*runs, strict=True), strict=True):
            sound = [one for one in told if one.is_ok]
            rms = np.sqrt(np.mean([one.errors**2 for one in sound], axis=0)) if sound else np.full(len(NAMES), np.nan)
            largest = max([float(np.abs(one.errors[one.taught]).max(initial=0.0)) for one in sound], default=np.nan)
            wide = np.median([np.abs(one.deviations) for one in told], axis=0)
            spread = f"{100 * wide[0]:.1f} %", f"{100 * wide[1]:.0f} %", f"{100 * wide[4]:.0f} %"
            cells = f"{len(sound)} of {len(told)}", *(f"{one:.2f}" for one in rms), f"{largest:.1f}", *spread
            yield f"{grade:g}", path, kind, name, f"{time:g}", *cells


def measured(data: Path, kinds: Iterable[str]) -> Iterator[tuple[str, ...]]:
    """What is learned from logs with forces, with a rolling resistance in the model and without."""
    settings = product(LOGS, kinds, (False, True), (0.0, Prior().slope))
    for one, kind, has_resistance, slope in settings:
        if one.truth.mass is None:
            continue
        log, found = read_log(data / one.path), []
        for share in (0.6, 1.0, 1.6):
            cart = guessed(one.cart, share * one.cart.inertia.mass)
            cart = cart.with_effect(RollingResistance(0.01)) if has_resistance else cart
            learner = FILTERS[kind](cart, list(log.arms), noise=noise_of_log(log, cart), prior=Prior(slope=slope))
            found.append(replay(log, learner).estimates)
        masses = [repr(told[-1].parameters["mass"]) for told in found]
        wrong = [np.mean([_is_wrong(estimate, one.truth.mass) for estimate in told]) for told in found]
        ok = [np.mean([estimate.health == "ok" for estimate in told]) for told in found]
        model = "drag, rolling resistance" if has_resistance else "drag"
        cells = (
            ", ".join(sorted({f"{told[-1].health}" for told in found})),
            f"{100 * min(ok):.0f} to {100 * max(ok):.0f} %",
            f"{100 * min(wrong):.0f} to {100 * max(wrong):.0f} %",
        )
        yield one.name, kind, model, f"{slope:g}", *masses, *cells


def _is_wrong(estimate: Estimate, known: Interval) -> bool:
    mass = estimate.parameters["mass"]
    return mass.identifiable and not known.holds(mass.value, mass.std, DEVIATIONS)


def _cart(mass: float, com: np.ndarray, inertia: float, drag: float, resistance: float) -> CartModel:
    effects = ViscousDrag(float(drag), 0.04 * mass), RollingResistance(resistance)
    return CartModel(Inertia(mass, tuple(com.tolist()), float(inertia)), effects=effects, wheels=WHEELS)


def _with_bounds(share: float) -> None:
    """Bounds of an unknown slope are so many times as wide."""
    UnknownSlope.parameters = tuple(
        replace(one, lower=share * one.lower, upper=share * one.upper) for one in UnknownSlope.parameters
    )


def _print(found: Iterator[tuple[str, ...]]) -> None:
    for row in found:
        print(f"| {' | '.join(row)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.slopes", description=__doc__)
    parser.add_argument("--seeds", default="0:20", metavar="A:B")
    parser.add_argument("--constants", action="store_true")
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    seeds, usual = range(*map(int, options.seeds.split(":"))), Prior().slope
    if options.data is not None:
        print("| log | filter | model | prior's slope | mass at last, kg: from 0.6 | from 1 | from 1.6 ", end="")
        print("| health | `ok` | sure and wrong |")
        print("|" + " --- |" * 10)
        if not options.constants:
            _print(measured(options.data, FILTERS))
            return
        usual_share = disturbed_learning.MAX_DISTURBED_SHARE
        for times in (0.7, 1.3, math.inf):
            print(f"{times:g} times the share of time")
            disturbed_learning.MAX_DISTURBED_SHARE = times * usual_share
            _print(measured(options.data, ["DisturbedFilter"]))
        return
    print(f"| {' | '.join(HEADER)} |\n|{' --- |' * len(HEADER)}")
    if not options.constants:
        _print(rows(seeds, {"0": Prior(slope=0.0), f"{usual:g}": Prior()}, list(FILTERS)))
        return
    shares = {f"{share * usual:.2g}": Prior(slope=share * usual) for share in (0.7, 1.3)}
    _print(rows(seeds, shares, ["CartFilter"]))
    for share in (0.7, 1.3 / 0.7):
        _with_bounds(share)
        _print(rows(seeds, {f"{usual:g}, bounds {UnknownSlope.parameters[0].upper:.2g}": Prior()}, ["CartFilter"]))


if __name__ == "__main__":
    main()
