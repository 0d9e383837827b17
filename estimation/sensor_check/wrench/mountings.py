"""Ways to read a force sensor: turned, mirrored, of the other side's force, of the world's axes, in another unit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np

from cartgrasp.frames import Array

from ..prior import MOUNTINGS
from .balance import FORWARD, TURNING

COMPONENTS = ("x", "y", "z")
MINUS = "−"


@dataclass(frozen=True)
class Mounting:
    """What of the recorded force is along {b}'s x and y, rows (2, 3), and of the moment along z, (3,); `of_world` where
    forces are of {s}. The kind of the fault ("" for none), its probability before a log is seen, and words."""

    force: Array
    moment: Array
    of_world: bool
    kind: str
    prior: float
    words: str

    def forward(self, force_unit: float) -> Array:
        """Coefficients (4,) of `FORWARD`."""
        found = np.zeros(len(FORWARD))
        if self.of_world:
            found[3] = force_unit
        else:
            found[:3] = force_unit * self.force[0]
        return found

    def sideways(self, force_unit: float) -> Array:
        """Coefficients (4,) of `FORWARD`, for y."""
        found = np.zeros(len(FORWARD))
        if self.of_world:
            found[3] = force_unit
        else:
            found[:3] = force_unit * self.force[1]
        return found

    def turning(self, force_unit: float, moment_unit: float) -> Array:
        """Coefficients (10,) of `TURNING`."""
        found = np.zeros(len(TURNING))
        found[6:9] = moment_unit * self.moment
        if self.of_world:
            found[9] = force_unit
        else:
            found[:3], found[3:6] = force_unit * self.force[1], -force_unit * self.force[0]
        return found


@cache
def mountings() -> tuple[Mounting, ...]:
    """The sound one first."""
    named = _named()
    shares: dict[str, int] = {}
    for name, _, _ in named:
        shares[name] = shares.get(name, 0) + 1
    found = [_mounting(force, moment, MOUNTINGS[name] / shares[name]) for name, force, moment in named]
    words = "forces are along the world's axes; turn them by −theta into the contact's"
    world = Mounting(np.eye(3)[:2], np.eye(3)[2], True, "frame", MOUNTINGS["world"], words)
    sound = Mounting(np.eye(3)[:2], np.eye(3)[2], False, "", 1 - sum(MOUNTINGS.values()), "")
    return (sound, *found, world)


def _named() -> list[tuple[str, Array, Array]]:
    """Names in `MOUNTINGS` with the matrices that take recorded forces and moments to the true ones, (3, 3)."""
    one = np.eye(3)
    known = {
        "z down": np.diag([1.0, -1.0, -1.0]),
        "half turn about z": np.diag([-1.0, -1.0, 1.0]),
        "half turn about y": np.diag([-1.0, 1.0, -1.0]),
        "quarter turn about z": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        "swapped, z down": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
    }
    found = [("reaction", -one, -one)]
    for turn in _turns():
        alike = [name for name, known_turn in known.items() if _is_alike(turn, known_turn)]
        name = alike[0] if alike else "other turns"
        if not np.array_equal(turn, one):
            found += [(name, turn, turn), ("other turns, reaction", -turn, -turn)]
    found.append(("swapped", one[[1, 0, 2]], one))
    for axis, name in enumerate(("fx reversed", "fy reversed")):
        found.append((name, one - 2 * np.outer(one[axis], one[axis]), one))
    return [*found, ("tz reversed", one, np.diag([1.0, 1.0, -1.0]))]


def _is_alike(turn: Array, known: Array) -> bool:
    """The same, or, off the diagonal, the other way round."""
    return np.array_equal(turn, known) or (
        known[0, 0] == 0 and np.array_equal(turn[:2, :2], -known[:2, :2]) and bool(turn[2, 2] == known[2, 2])
    )


def _turns() -> list[Array]:
    """The 24 turns of a cube."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[np.arange(3), order] = signs
            if np.linalg.det(turn) > 0:
                found.append(turn)
    return found


def _mounting(force: Array, moment: Array, prior: float) -> Mounting:
    parts = [f"f{COMPONENTS[i]} is what is recorded as {_told('f', force[i])}" for i in (0, 1) if force[i, i] != 1]
    if moment[2, 2] != 1:
        parts.append(f"tz is what is recorded as {_told('t', moment[2])}")
    is_straight = force[0, 0] != 0 and force[1, 1] != 0 and moment[2, 2] != 0
    is_sign = is_straight and (force[0, 0] < 0 or (force[1, 1] < 0 and moment[2, 2] > 0))
    words = " and ".join(parts) if parts else "only fz, tx or ty differ"
    return Mounting(force[:2], moment[2], False, "sign" if is_sign else "axes", prior, words)


def _told(letter: str, row: Array) -> str:
    axis = int(np.abs(row).argmax())
    return f"{MINUS if row[axis] < 0 else ''}{letter}{COMPONENTS[axis]}"
