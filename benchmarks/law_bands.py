"""Whether the band of a law, as a page draws it, holds the force that was hidden, along the whole log.

    python -m benchmarks.law_bands DIR         logs of `python -m benchmarks.sealed generate --out DIR --cases laws`

What other effects give as well is taken out of both.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from cartgrasp.cart_file import load_cart
from cartgrasp.effects import Effect, InertiaEffect, SensorEffect
from cartgrasp.logs import read_log
from estimation import diagnose
from estimation.discrepancy.search.laws import constant

from .sealed.calibration import INTERVAL
from .sealed.foreign import foreign_wrench
from .sealed.world import THETA, WAY, R, U, World, X, Y

MOVES = 0.05
"""Speed (m/s) from which on a drag has a direction."""
EVERY = 5
"""Points of the motion's grid from one that is asked to the next."""
STATES = 16


@dataclass(frozen=True)
class Band:
    """Of one log: its case, the hidden force's root mean square (N, N·m), the share of points at which the band holds
    it, and the root mean squares of errors and of what the band says."""

    case: str
    size: float
    held: float
    error: float
    said: float


def bands(folder: Path, processes: int) -> Iterator[Band]:
    """Of all logs in which a law was hidden and laws were told."""
    truths = sorted((folder / "truth").glob("*.json"))
    truths = [path for path in truths if json.loads(path.read_text())["world"]["law"]]
    found = Parallel(processes, return_as="generator")(delayed(band)(folder, path) for path in truths)
    return (one for one in found if one is not None)


def band(folder: Path, truth: Path) -> Band | None:
    own, told = folder / "logs" / truth.stem, json.loads(truth.read_text())
    with np.errstate(all="ignore"):
        said = diagnose(read_log(own / "run.csv"), load_cart(own / "cart.yaml"))
    laws = [law for _, law in said.certainty.laws]
    if not laws or len(said.final.logs) > 1:  # it was cut where the cart was hit, or not seen
        return None
    balances = said.final.logs[0]
    moving = np.flatnonzero(np.abs(balances.motion.velocity[:, 0]) > MOVES)[::EVERY]
    true = hidden(balances.motion, World(**told["world"]))[moving]
    axis = int(np.argmax((true**2).sum(axis=0)))

    def acting(effect: Effect) -> np.ndarray:
        """What an effect gives (n,) at the points that are asked."""
        cart = replace(said.final.cart, effects=(effect,))
        state = balances.state(cart)[moving]
        return np.asarray(cart.effect_wrench(state, time=balances.motion.time[moving])[:, 2 * axis])

    force, variance = np.zeros(len(moving)), np.zeros(len(moving))
    beside = [acting(e) for e in said.final.cart.effects if not isinstance(e, SensorEffect | InertiaEffect)]
    for law in laws:
        shares = np.column_stack([acting(law.effect.with_values(one)) for one in np.eye(len(law.effect.values))])
        force += shares @ law.effect.values
        variance += (law.curve(law.seen[moving])[1] * acting(constant(law.effect))) ** 2
        left = np.column_stack([alone(one, beside) for one in shares.T])
        variance += np.einsum("na,ab,nb->n", left, law.covariance, left)
        variance -= np.einsum("na,ab,nb->n", shares, law.covariance, shares)
    off, std = alone(force - true[:, axis], beside), np.sqrt(np.maximum(variance, 0.0))
    held = float((np.abs(off) <= INTERVAL * std).mean())
    return Band(told["case"], rms(true[:, axis]), held, rms(off), rms(std))


def alone(error: np.ndarray, beside: list[np.ndarray]) -> np.ndarray:
    """Errors less what effects beside a law give as well: which of both it is, is a matter of words."""
    columns = np.array([one for one in beside if one.any()]).T
    if not columns.size:
        return error
    return error - columns @ np.linalg.lstsq(columns, error, rcond=None)[0]


def hidden(motion: Any, world: World) -> np.ndarray:
    """Forward force and yaw moment (n, 2) of what was hidden."""
    states = np.zeros((len(motion.time), STATES))
    states[:, [X, Y, THETA]], states[:, U], states[:, R] = motion.pose, motion.velocity[:, 0], motion.velocity[:, -1]
    states[:, WAY] = np.cumsum(states[:, U] - world.half_track * states[:, R]) * motion.step
    return np.array([foreign_wrench(t, one, world) for t, one in zip(motion.time, states, strict=True)])[:, [0, 2]]


def table(found: list[Band]) -> str:
    """By case, and of all: how often bands hold."""
    groups = defaultdict[str, list[Band]](list)
    for one in found:
        groups[one.case.split("+", maxsplit=1)[0]].append(one)
    head = f"{'law':<14} {'logs':>4} {'95 % bands hold':>16} {'rms of law':>11} {'of error':>9} {'of the band':>12}"
    rows = [(name, groups[name]) for name in sorted(groups)]
    return "\n".join([head, *(_row(name, own) for name, own in [*rows, ("all", found)])])


def _row(name: str, own: list[Band]) -> str:
    size, held, error, said = (float(np.mean([getattr(b, k) for b in own])) for k in ("size", "held", "error", "said"))
    return f"{name:<14} {len(own):>4} {100 * held:>14.1f} % {size:>11.2f} {error:>9.2f} {said:>12.2f}"


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    parser = argparse.ArgumentParser(
        "python -m benchmarks.law_bands", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    options, found = parser.parse_args(), list[Band]()
    for one in bands(options.folder, options.processes):
        found.append(one)
        print(f"[{len(found)}] {one.case}: {100 * one.held:.0f} % within the band", file=sys.stderr, flush=True)
    print(table(found) if found else "no laws are told of logs in which one is hidden")


if __name__ == "__main__":
    main()
