"""`python -m benchmarks.sensor_faults DIR`: what is told of sensors on the logs of DIR (`benchmarks.sealed generate`),
as they are and with a fault put into each.

A fault counts as told where a suspicion of its kind is. Any suspicion of a log as it is, or of another kind than the
fault's, is an alarm. With `--mass` the whole workflow runs on logs whose velocities are late
or too large, and the mass is held against the truth: the cases must be `nothing`, for no other has the one mass.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cartgrasp.cart_file import load_cart
from cartgrasp.frames import Array
from cartgrasp.logs import ArmLog, RunLog, read_log
from cartgrasp.model import CartModel
from estimation.model_selection import diagnose
from estimation.sensor_check import Suspicion, check_sensors


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
        arms = {k: ArmLog(a.contact, a.wrench[:, list(order)] * np.array(factors)) for k, a in log.arms.items()}
        return replace(log, arms=arms)

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
}


@dataclass(frozen=True)
class Sealed:
    """A log with its cart; `mass` (kg) is the true one."""

    log: RunLog
    cart: CartModel
    mass: float


def read(folder: Path) -> list[Sealed]:
    found = []
    for path in sorted(folder.glob("logs/*/run.csv")):
        truth = json.loads((folder / "truth" / f"{path.parent.name}.json").read_text(encoding="utf-8"))
        found.append(Sealed(read_log(path), load_cart(path.parent / "cart.yaml"), truth["cart"]["mass"]))
    return found


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


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.sensor_faults", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--mass", action="store_true", help="run the whole workflow on faults of velocities")
    options = parser.parse_args()
    logs = read(options.folder)
    (masses if options.mass else detection)(logs)


if __name__ == "__main__":
    main()
