"""`python -m benchmarks.sensor_constants DIR`: what hangs on the constants by which sensors are told to freeze, clip,
jump, drift or stand (`estimation/sensor_check`).

Each is taken 30 % less and more, on the logs of DIR (`benchmarks.sealed generate`) as they are and with the fault that
it is about. Told are the logs in which something is found; of jumps, how many.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel
from estimation.sensor_check import heading, jumps, sizes, stuck_wrenches
from estimation.sensor_check.windows import Track

from .sensor_faults import OTHERS, read

SHARES = 0.7, 1.0, 1.3
Told = Callable[[RunLog, CartModel], int]


def frozen(log: RunLog, _: CartModel) -> int:
    return any(stuck_wrenches.frozen_wrench(arm.wrench) is not None for arm in log.arms.values())


def clipped(log: RunLog, _: CartModel) -> int:
    return any(list(stuck_wrenches.range_limits(arm.wrench)) for arm in log.arms.values())


def jumped(log: RunLog, _: CartModel) -> int:
    return len(jumps.jump_times(log))


def drifts(log: RunLog, cart: CartModel) -> int:
    return heading.heading_drift(log, cart) is not None


def in_another_unit(log: RunLog, _: CartModel) -> int:
    return bool(sizes.length_unit_suspicions(log))


def stands(log: RunLog, _: CartModel) -> int:
    return heading.displacements(Track.of(log)) is None


CASES: tuple[tuple[ModuleType, tuple[str, ...], Told, str], ...] = (
    (stuck_wrenches, ("MAX_CHANCE_RUNS", "MAX_FROZEN_FRACTION"), frozen, "wrenches frozen 3 times for 0.6 s"),
    (stuck_wrenches, ("MIN_CLIPPED_ROWS", "MIN_CLIPPED_COUNT_RATIO"), clipped, "fx clipped in a tenth of the rows"),
    (
        jumps,
        (
            "JUMP_LINE_INTERVAL",
            "MIN_JUMP_LINE_ROWS",
            "JUMP_MISS_RATIO",
            "JUMP_STEP_RATIOS",
            "HIT_SPEED_CHANGE",
            "MAX_EVEN_SPAN_RATIO",
        ),
        jumped,
        "poses jump 4 times by 3 cm",
    ),
    (heading, ("DRIFT_SIGMAS", "MIN_DRIFT_ANGLE", "MAX_DRIFT_FITS"), drifts, "theta drifts by 0.003 rad/s"),
    (sizes, ("USUAL_CART_SPEED", "SPEED_INTERVAL"), in_another_unit, "x and y in mm"),
    (heading, ("MIN_MOTION_NOISE_RATIO",), stands, "stands in noise"),
)


def variants(value: Any) -> list[tuple[str, list[Any]]]:
    """The constant at each share; of several numbers, each alone. A word tells them apart."""
    if isinstance(value, dict):
        return [("", [{key: share * each for key, each in value.items()} for share in SHARES])]
    if isinstance(value, tuple):
        return [
            (f"[{i}]", [(*value[:i], share * value[i], *value[i + 1 :]) for share in SHARES]) for i in range(len(value))
        ]
    return [("", [type(value)(share * value) for share in SHARES])]


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.sensor_constants", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR")
    logs = read(parser.parse_args().folder)
    print("| constant | sound logs told: 30 % less, as it is, more | with the fault |")
    print("| --- " * 3 + "|")
    for module, names, tells, fault in CASES:
        faulty = [OTHERS[fault].change(one.log) for one in logs]
        for name in names:
            value = getattr(module, name)
            for which, others in variants(value):
                found = []
                for other in others:
                    setattr(module, name, other)
                    sound = sum(tells(one.log, one.cart) for one in logs)
                    found.append((sound, sum(tells(log, one.cart) for log, one in zip(faulty, logs, strict=True))))
                setattr(module, name, value)
                place = f"{module.__name__.rpartition('.')[2]}.{name}{which}"
                print(
                    f"| {place} | {' | '.join(', '.join(map(str, each)) for each in zip(*found, strict=True))} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
