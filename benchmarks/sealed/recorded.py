"""A log as a practitioner without a model of its noise would read it: resampled evenly, smoothed by a polynomial that
slides, differentiated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from .world import GRAVITY

STEP, HALF_WIDTH, KEEP = 0.01, 15, 10
"""s; samples on each side; every so many is kept."""


@dataclass(frozen=True)
class Cart:
    """What `cart.yaml` believes; `drag` is None where it has none."""

    mass: float
    com: tuple[float, float]
    inertia: float
    drag: tuple[float, float] | None

    @property
    def body(self) -> np.ndarray:
        """(4,): m, m dx, m dy, moment of inertia about {b}."""
        dx, dy = self.com
        return np.array([self.mass, self.mass * dx, self.mass * dy, self.inertia + self.mass * (dx**2 + dy**2)])

    @property
    def weight(self) -> float:
        return self.mass * GRAVITY


@dataclass(frozen=True, eq=False)
class Recorded:
    """Each (n,): time, place, heading, speeds forward, sideways and in yaw, their rates; wrenches of arms (n, 6) and
    contacts (n, 3) by name; and the derivative of the planar sum (n, 2) of force forward and moment."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    heading: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    du: np.ndarray
    dr: np.ndarray
    wrenches: dict[str, np.ndarray]
    contacts: dict[str, np.ndarray]
    sum_rate: np.ndarray

    def planar(self, arm: str) -> np.ndarray:
        """(n, 2)."""
        (px, py, _), (fx, fy, _, _, _, tz) = self.contacts[arm].T, self.wrenches[arm].T
        return np.column_stack([fx, px * fy - py * fx + tz])

    @property
    def sum(self) -> np.ndarray:
        return np.sum([self.planar(arm) for arm in self.wrenches], axis=0)


def read_cart(path: Path) -> Cart:
    found = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    drag = (found.get("effects") or {}).get("viscous_drag")
    x, y = found["com"]
    return Cart(found["mass"], (x, y), found["inertia"], drag and (drag["linear"], drag["angular"]))


def has_arms(path: Path) -> bool:
    with path.open(encoding="utf-8") as stream:
        return "." in stream.readline()


def read_recorded(path: Path) -> Recorded:
    header, table = read_table(path)
    time = np.arange(table[0, 0], table[-1, 0], STEP)
    even = {name: np.interp(time, table[:, 0], column) for name, column in zip(header, table.T, strict=True)}
    even["theta"] = np.interp(time, table[:, 0], np.unwrap(table[:, header.index("theta")]))
    x, dx, ddx = slid(even["x"])
    y, dy, ddy = slid(even["y"])
    heading, r, dr = slid(even["theta"])
    c, s = np.cos(heading), np.sin(heading)
    u, v = c * dx + s * dy, -s * dx + c * dy
    arms = sorted({name.split(".")[0] for name in header if "." in name})
    raw = {
        arm: np.column_stack([even[f"{arm}.{part}"] for part in ("fx", "fy", "fz", "tx", "ty", "tz")]) for arm in arms
    }
    places = {arm: np.column_stack([even[f"{arm}.{part}"] for part in ("px", "py", "pz")]) for arm in arms}
    wrenches = {arm: np.column_stack([slid(column)[0] for column in w.T]) for arm, w in raw.items()}
    inside = slice(HALF_WIDTH, -HALF_WIDTH, KEEP)
    total = Recorded(time, x, y, heading, u, v, r, c * ddx + s * ddy + r * v, dr, wrenches, places, time).sum
    rate = np.column_stack([np.gradient(column, STEP) for column in total.T])

    def kept(column: np.ndarray) -> np.ndarray:
        return column[inside]

    return Recorded(
        *map(kept, (time, x, y, heading, u, v, r, c * ddx + s * ddy + r * v, dr)),
        wrenches={arm: kept(w) for arm, w in wrenches.items()},
        contacts={arm: kept(p) for arm, p in places.items()},
        sum_rate=kept(rate),
    )


def read_table(path: Path) -> tuple[list[str], np.ndarray]:
    """Names of columns, and rows (n, k)."""
    first, *lines = path.read_text(encoding="utf-8").splitlines()
    return first.split(","), np.loadtxt(lines, delimiter=",")


def read_course(path: Path) -> np.ndarray:
    """(n, 4): time, place and heading."""
    header, table = read_table(path)
    return table[:, [header.index(name) for name in ("t", "x", "y", "theta")]]


def slid(column: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value and two derivatives of a cubic fitted around each sample (Savitzky and Golay, 1964); wrong at the ends."""
    at = STEP * np.arange(-HALF_WIDTH, HALF_WIDTH + 1)
    value, slope, bend = np.linalg.pinv(np.vander(at, 4, increasing=True))[:3]
    first, second, third = (np.convolve(column, kernel[::-1], "same") for kernel in (value, slope, 2 * bend))
    return first, second, third
