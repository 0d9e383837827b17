"""`python -m benchmarks.long_logs`: seconds and memory that whole logs take, by their length, each in its own process.

A cart that weaves, with rolling resistance that its file does not have, at 100 Hz. Motion is a sum of sines, wrenches
are what it takes: what is measured here is cost.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time

import numpy as np

from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.frames import Array
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel

RATE = 100.0
CONTACT = (-0.4, 0.0, 1.0)
FORWARD = ((0.5, 11.9), (0.25, 5.3), (0.1, 2.1))
TURNING = ((0.3, 9.1), (0.2, 3.7))
"""Sizes (m/s, rad/s) and periods (s)."""
NOISE = (0.0005, 0.005, 2.0)
"""m or rad, m/s or rad/s, N."""


def cart(mass: float = 24.0) -> CartModel:
    return CartModel(Inertia(mass, (0.28, 0.06), 2.2 * mass / 24.0), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def made(minutes: float) -> RunLog:
    """A log of the cart and rolling resistance."""
    true, random = cart().with_effect(RollingResistance(0.03)), np.random.default_rng(0)
    seconds = np.arange(0.0, 60 * minutes, 1 / RATE)
    n = len(seconds)
    (u, u_rate), (r, r_rate) = _sines(FORWARD, seconds), _sines(TURNING, seconds)
    heading = np.cumsum(r) / RATE
    world = np.column_stack([u * np.cos(heading), u * np.sin(heading), r])
    state = np.column_stack([np.cumsum(world, axis=0) / RATE, u, r])
    state[:, 2] = heading
    forward, moment = true.required_wrench(state, np.column_stack([u_rate, r_rate])).T
    wrench = NOISE[2] * random.standard_normal((n, 6)) * ([1.0] * 3 + [0.05] * 3)
    wrench[:, 0] += forward
    wrench[:, 5] += moment
    pose = state[:, :3] + NOISE[0] * random.standard_normal((n, 3))
    velocity = world + NOISE[1] * random.standard_normal((n, 3))
    return RunLog(seconds, pose, velocity, {"hand": ArmLog(np.tile(CONTACT, (n, 1)), wrench)}, name=f"{minutes:g} min")


def _sines(parts: tuple[tuple[float, float], ...], seconds: Array) -> tuple[Array, Array]:
    """A signal and its rate."""
    signal, rate = np.zeros((2, len(seconds)))
    for size, period in parts:
        turn = 2 * np.pi / period
        signal += size * np.sin(turn * seconds)
        rate += size * turn * np.cos(turn * seconds)
    return signal, rate


def told(command: str, minutes: float) -> dict[str, object]:
    """What one command says of one log, its seconds of a core, and the most memory (GB) that the process had."""
    from estimation import diagnose, identify

    log, first_guess = made(minutes), cart(20.0)
    began = time.process_time()
    if command == "identify":
        mass, words = identify([log], first_guess).parameters["mass"], ""
    else:
        found = diagnose(log, first_guess)
        mass, words = found.certainty.parameters["mass"], ", ".join(effect.name for effect in found.effects)
    seconds = time.process_time() - began
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    return {"seconds": seconds, "memory": memory, "mass": f"{mass.value:.2f} ± {mass.std:.2g} kg", "names": words}


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.long_logs", description="What long logs cost.")
    parser.add_argument("--minutes", type=float, nargs="+", default=[1.0, 10.0, 60.0])
    parser.add_argument("--one", choices=("identify", "discrepancy"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(told(options.one, options.minutes[0])))
        return
    print(
        "| command | log | seconds | seconds a minute | peak memory, GB | says |\n| --- | --- | --- | --- | --- | --- |"
    )
    for command in ("identify", "discrepancy"):
        for minutes in options.minutes:
            call = [sys.executable, "-m", "benchmarks.long_logs", "--one", command, "--minutes", str(minutes)]
            one = json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)
            says = ", ".join(filter(None, [one["names"], one["mass"]]))
            print(
                f"| {command} | {minutes:g} min | {one['seconds']:.1f} | {one['seconds'] / minutes:.1f} | "
                f"{one['memory']:.2f} | {says} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
