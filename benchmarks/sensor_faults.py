"""`python -m benchmarks.sensor_faults DIR`: what is told of sensors on the logs of DIR (`benchmarks.sealed generate`),
as they are and with a fault put into each.

A fault counts as told where a suspicion of its kind is. Any suspicion of a log as it is, or of another kind than the
fault's, is an alarm. With `--mass` the whole workflow runs on logs whose velocities are late
or too large, and the mass is held against the truth: the cases must be `nothing`, for no other has the one mass. With
`--sure` all that `identify` tells as taught is held against the truth, on such logs whose sensors break for a while,
drift, or are late.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cartgrasp.cart_file import load_cart
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog, read_log
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.sensor_check import Suspicion, check_sensors
from estimation.whole_log.identification import identify

from . import broken_sensors


@dataclass(frozen=True)
class Fault:
    """A change of the log, and the kinds of suspicion that are right about it."""

    change: Callable[[RunLog], RunLog]
    kinds: frozenset[str]
    needs_velocity: bool = False


def late(lag: float, gain: float = 1.0) -> Fault:
    """Velocities that come `lag` s late and `gain` times too large."""

    def change(log: RunLog) -> RunLog:
        if log.velocity is None:
            return log
        moved = [np.interp(log.time - lag, log.time, column) for column in log.velocity.T]
        return replace(log, velocity=gain * np.column_stack(moved))

    return Fault(change, frozenset({"lag"} if lag else set()) | ({"scale"} if gain != 1 else set()), True)


def wrenches(*kinds: str, factors: tuple[float, ...] = (1.0,) * 6, order: tuple[int, ...] = tuple(range(6))) -> Fault:
    """Wrenches of all arms in another order and times factors."""

    def change(log: RunLog) -> RunLog:
        return broken_sensors.with_wrenches(log, lambda wrench: wrench[:, list(order)] * np.array(factors))

    return Fault(change, frozenset(kinds))


def poses(kind: str, change: Callable[[Array], Array]) -> Fault:
    return Fault(lambda log: replace(log, pose=change(log.pose)), frozenset({kind}))


def in_the_carts_frame(log: RunLog) -> RunLog:
    if log.velocity is None:
        return log
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])
    vx, vy, omega = log.velocity.T
    return replace(log, velocity=np.column_stack([c * vx + s * vy, c * vy - s * vx, omega]))


def held(log: RunLog, size: int = 3) -> RunLog:
    """Poses that are fresh every few rows only."""
    return replace(log, pose=log.pose[np.arange(len(log)) // size * size])


def between(log: RunLog, size: int = 5) -> RunLog:
    """Poses on straight lines between every few rows."""
    knots, heading = np.arange(0, len(log), size), np.unwrap(log.pose[:, 2])
    columns = (log.pose[:, 0], log.pose[:, 1], heading)
    return replace(log, pose=np.column_stack([np.interp(log.time, log.time[knots], one[knots]) for one in columns]))


VELOCITIES = {
    "velocities 10 ms late": late(0.01),
    "velocities 20 ms late": late(0.02),
    "velocities 50 ms late": late(0.05),
    "velocities 3 % large": late(0.0, 1.03),
    "velocities 5 % large": late(0.0, 1.05),
    "velocities 50 ms late and 5 % large": late(0.05, 1.05),
}
OTHERS = {
    "wrenches reversed": wrenches("sign", factors=(-1.0,) * 6),
    "fx reversed": wrenches("sign", factors=(-1.0, 1, 1, 1, 1, 1)),
    "fx and fy swapped": wrenches("axes", order=(1, 0, 2, 3, 4, 5)),
    "z ahead": wrenches("axes", order=(1, 2, 0, 4, 5, 3)),
    "kN, kN·m": wrenches("unit", factors=(1e-3,) * 6),
    "kgf, kgf·m": wrenches("unit", factors=(1 / 9.80665,) * 6),
    "lbf, lbf·ft": wrenches("unit", factors=(1 / 4.4482216,) * 3 + (1 / 1.3558179,) * 3),
    "lbf, N·m": wrenches("unit", factors=(1 / 4.4482216,) * 3 + (1.0,) * 3),
    "N, N·cm": wrenches("unit", factors=(1.0,) * 3 + (100.0,) * 3),
    "theta in degrees": poses("unit", lambda pose: pose * [1, 1, 180 / np.pi]),
    "theta reversed": poses("sign", lambda pose: pose * [1, 1, -1]),
    "x and y swapped": poses("axes", lambda pose: pose[:, [1, 0, 2]]),
    "x and y in 1 cm steps": poses("quantised", lambda pose: np.round(pose / [0.01, 0.01, 1e-9]) * [0.01, 0.01, 1e-9]),
    "velocities of {b}": Fault(in_the_carts_frame, frozenset({"frame"}), True),
    "poses held for 3 rows": Fault(held, frozenset({"repeated"})),
    "poses interpolated 5 times": Fault(between, frozenset({"repeated"})),
    "wrenches frozen 3 times for 0.6 s": Fault(broken_sensors.frozen(0.6, 3), frozenset({"repeated"})),
    "wrenches frozen for 6 s": Fault(broken_sensors.frozen(6.0, 1), frozenset({"repeated"})),
    "fx clipped in a tenth of the rows": Fault(broken_sensors.clipped(0.1), frozenset({"scale"})),
    "poses jump 4 times by 3 cm": Fault(broken_sensors.found_elsewhere(0.03, 4), frozenset({"jumps"})),
    "theta drifts by 0.003 rad/s": Fault(broken_sensors.drifting(0.003), frozenset({"offset"})),
    "x and y in mm": Fault(broken_sensors.in_millimetres, frozenset({"unit"})),
    "somebody else gives 15 N for 2 s": Fault(broken_sensors.helped(15.0, 2.0), frozenset()),
    "somebody else gives 60 N for 9 s": Fault(broken_sensors.helped(60.0, 9.0), frozenset()),
    "stands in noise": Fault(broken_sensors.standing, frozenset()),
}
BROKEN = {
    "as they are": late(0.0),
    "frozen 3 times for 0.6 s": OTHERS["wrenches frozen 3 times for 0.6 s"],
    "frozen for 6 s": OTHERS["wrenches frozen for 6 s"],
    "clipped in a tenth of the rows": OTHERS["fx clipped in a tenth of the rows"],
    "poses jump 4 times by 3 cm": OTHERS["poses jump 4 times by 3 cm"],
    "theta drifts by 0.003 rad/s": OTHERS["theta drifts by 0.003 rad/s"],
    "wrenches 50 ms late": Fault(broken_sensors.late(0.05), frozenset()),
    "wrenches 50 ms early": Fault(broken_sensors.late(-0.05), frozenset()),
    "wrenches through 25 ms": Fault(broken_sensors.smoothed(0.025), frozenset()),
}
FAR = 4.0
"""Deviations."""


@dataclass(frozen=True)
class Sealed:
    """A log with its cart; true values by name."""

    log: RunLog
    cart: CartModel
    truth: dict[str, float]

    @property
    def mass(self) -> float:
        """kg."""
        return self.truth["mass"]


def read(folder: Path) -> list[Sealed]:
    found = []
    for path in sorted(folder.glob("logs/*/run.csv")):
        truth = json.loads((folder / "truth" / f"{path.parent.name}.json").read_text(encoding="utf-8"))
        found.append(Sealed(read_log(path), load_cart(path.parent / "cart.yaml"), _flat(truth["cart"])))
    return found


def _flat(cart: dict[str, Any]) -> dict[str, float]:
    """True values as `identify` names them."""
    drags = {f"viscous_drag.{name}": value for name, value in cart["viscous_drag"].items()}
    return {name: value for name, value in cart.items() if isinstance(value, float)} | drags


def told(suspicions: tuple[Suspicion, ...]) -> set[str]:
    return {one.kind for one in suspicions}


def detection(logs: list[Sealed]) -> None:
    """A line for logs as they are, and for each fault."""
    start, seconds = time.process_time(), []
    alarms = []
    for one in logs:
        start = time.process_time()
        found = check_sensors(one.log, one.cart)
        seconds.append(time.process_time() - start)
        alarms += [f"  {one.log.name}: {each.probability:.2f} {each.words}" for each in found]
    print(
        f"as they are: {len(alarms)} suspicions on {len(logs)} logs, {max(seconds):.2f} s of a core at most",
        *alarms,
        sep="\n",
    )
    for name, fault in (VELOCITIES | OTHERS).items():
        fitting = [one for one in logs if one.log.velocity is not None or not fault.needs_velocity]
        kinds = [told(check_sensors(fault.change(one.log), one.cart)) for one in fitting]
        right, other = sum(fault.kinds <= each for each in kinds), sum(bool(each - fault.kinds) for each in kinds)
        print(f"{name:36} told {right:3} of {len(fitting)}, something else besides {other}")


def masses(logs: list[Sealed]) -> None:
    """By how much the mass is off, of logs as they are and with faults of velocities."""
    for name, fault in ({"as they are": late(0.0)} | VELOCITIES).items():
        fitting = [one for one in logs if one.log.velocity is not None]
        off = []
        for one in fitting:
            found = diagnose(fault.change(one.log), one.cart)
            off.append(found.parameter_mismatch["mass"]["refitted"] / one.mass - 1)
        worst = ", ".join(f"{100 * each:+.1f}" for each in off)
        print(
            f"{name:36} within 3 %: {sum(abs(each) < 0.03 for each in off)} of {len(off)}; % off: {worst}", flush=True
        )


def sureness(logs: list[Sealed]) -> None:
    """How often what `identify` tells as taught is far from the truth, and by how much at most."""
    print(f"| fault | told as taught | beyond {FAR:g} deviations | the worst | mass within, % |")
    print("| --- " * 5 + "|")
    for name, fault in BROKEN.items():
        off, masses_off = list[tuple[float, str]](), []
        for one in logs:
            found = identify([fault.change(one.log)], one.cart).parameters
            told = {key: each for key, each in found.items() if each.identifiable and key in one.truth}
            off += [((each.value - one.truth[key]) / each.std, key) for key, each in told.items()]
            masses_off += [abs(found["mass"].value / one.mass - 1.0)] if "mass" in told else []
        far = [each for each in off if abs(each[0]) > FAR]
        worst, key = max(off, key=lambda each: abs(each[0]), default=(0.0, ""))
        cells = name, len(off), len(far), f"{worst:+.1f}, {key}", f"{100.0 * max(masses_off, default=0.0):.1f}"
        print(f"| {' | '.join(map(str, cells))} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.sensor_faults", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--mass", action="store_true", help="run the whole workflow on faults of velocities")
    parser.add_argument("--sure", action="store_true", help="what identify is sure of, where sensors break")
    options = parser.parse_args()
    logs = read(options.folder)
    (masses if options.mass else sureness if options.sure else detection)(logs)


if __name__ == "__main__":
    main()
