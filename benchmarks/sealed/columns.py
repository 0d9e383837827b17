"""The library of terms that a user of NARMAX models would try on residuals: forward force, yaw moment, sideways speed.

Each candidate bears the name of the effect that it stands for, and of its parameters where coefficients are these.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from .recorded import Cart, Recorded

EDGE, SLOW, TRAIL = 0.01, 0.05, 0.1
"""m/s over which a sign changes, m/s over which stiction fades, m in which casters turn round."""
CELLS, LOADINGS, WINDOW = 4, 10, 1.0
SLOWLY = 11
"""Samples."""
SWINGS = (0.6, 0.8, 1.0, 1.2, 1.4)
"""Hz."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Columns (3 n, k): rows of force, then of moment, then of sideways speed. `settings`: when or where it acts."""

    name: str
    columns: np.ndarray
    parameters: tuple[str, ...] = ()
    label: str = ""
    base: float = 0.0  # what is added to a coefficient
    settings: Mapping[str, float] = field(default_factory=dict)


def body_columns(log: Recorded) -> np.ndarray:
    """(3 n, 4), by `Cart.body`."""
    u, r, du, dr, zero = log.u, log.r, log.du, log.dr, 0 * log.u
    return np.vstack(
        [
            np.column_stack([du, -(r**2), -dr, zero]),
            np.column_stack([zero, u * r, -du, dr]),
            np.zeros((len(u), 4)),
        ]
    )


def drag_columns(log: Recorded) -> np.ndarray:
    return np.hstack([stacked(log.u), stacked(moment=log.r)])


def candidates(log: Recorded, cart: Cart) -> list[Candidate]:
    return [*of_motion(log, cart), *of_sensors(log), *of_place(log, cart), *of_time(log, cart)]


def of_motion(log: Recorded, cart: Cart) -> Iterator[Candidate]:
    u, r = log.u, log.r
    rolling, turning = np.tanh(u / EDGE), np.tanh(r / EDGE)
    way = np.cumsum(np.abs(u) * np.gradient(log.time))
    yield Candidate("rolling_resistance", stacked(cart.weight * rolling), ("coefficient",))
    yield Candidate("rolling_resistance", stacked(moment=turning))
    yield Candidate("stribeck_friction", stacked(rolling * np.exp(-((u / SLOW) ** 2))), ("breakaway",))
    yield Candidate("quadratic_drag", stacked(u * np.abs(u)), ("coefficient",))
    yield Candidate("directional_drag", stacked(np.abs(u)))
    yield Candidate("caster_realignment", stacked(rolling - followed(rolling, way)))
    yield Candidate("caster_realignment", stacked(moment=rolling - followed(rolling, way)))
    yield Candidate("caster_realignment", stacked(moment=turning - followed(turning, way)))
    yield Candidate("wheel_drag_imbalance", stacked(moment=-rolling), ("moment",))
    yield Candidate("wheel_misalignment", stacked(side=u))
    side = cart.mass * (u * r + cart.com[0] * log.dr) - sum(w[:, 1] for w in log.wrenches.values())
    yield Candidate("lateral_slip", stacked(side=u * side))
    for frequency in SWINGS:
        yield Candidate("load_slosh", stacked(swung(log, frequency) - log.du))
    if cart.drag is None:
        yield Candidate("viscous_drag", drag_columns(log), ("linear", "angular"))


def of_sensors(log: Recorded) -> Iterator[Candidate]:
    one = np.ones(len(log.u))
    several = len(log.wrenches) > 1
    force, design = log.sum[:, 0], np.hstack([body_columns(log), drag_columns(log)])[: len(one)]
    total = design @ np.linalg.lstsq(design, force, rcond=1e-9)[0]
    for arm, wrench in log.wrenches.items():
        label = arm if several else ""
        px, py, _ = log.contacts[arm].T
        bias = np.hstack([stacked(one, -py), stacked(moment=px), stacked(moment=one)])
        yield Candidate("force_bias", bias, ("fx", "fy", "tz"), label)
        fx, fy, tz = shared(log, wrench, total)
        yield Candidate("force_misalignment", stacked(-fy, px * fx + py * fy), label=label)
        if several:
            yield Candidate("force_scale", stacked(fx, px * fy - py * fx + tz), ("gain",), label, base=1.0)
    yield Candidate("time_delay", stacked(*-log.sum_rate.T), ("delay",))


def of_place(log: Recorded, cart: Cart) -> Iterator[Candidate]:
    c, s, (dx, dy) = np.cos(log.heading), np.sin(log.heading), cart.com
    slope = [stacked(c, -dx * s - dy * c), stacked(s, dx * c - dy * s)]
    yield Candidate("floor_slope", cart.weight * np.hstack(slope), ("grade_x", "grade_y"))
    friction = cart.weight * np.tanh(log.u / EDGE)
    column, row = (in_parts(place, CELLS) for place in (log.x, log.y))
    xs, ys = (edges(place, CELLS) for place in (log.x, log.y))
    for i, j in np.ndindex(CELLS, CELLS):
        box = {"x_min": xs[i], "x_max": xs[i + 1], "y_min": ys[j], "y_max": ys[j + 1]}
        inside = (column == i) & (row == j)
        yield Candidate("floor_patch", stacked(inside * friction), ("coefficient",), settings=box)


def of_time(log: Recorded, cart: Cart) -> Iterator[Candidate]:
    load = one_kilogram(log, cart)
    part, times = in_parts(log.time, LOADINGS), edges(log.time, LOADINGS)
    for k in range(1, LOADINGS):
        loaded = np.tile(part >= k, 3)[:, None]
        yield Candidate("payload_change", loaded * load, ("mass",), settings={"time": times[k]})
    windows = round(float(np.ptp(log.time)) / WINDOW)
    part, times = in_parts(log.time, windows), edges(log.time, windows)
    for k in range(windows):
        span = {"start": times[k], "duration": times[k + 1] - times[k]}
        yield Candidate("external_push", pushed(part == k), ("force", "moment"), settings=span)


def one_kilogram(log: Recorded, cart: Cart) -> np.ndarray:
    """(3 n, 1), at the CoM."""
    return (body_columns(log) @ (cart.body / cart.mass))[:, None]


def pushed(during: np.ndarray) -> np.ndarray:
    """(3 n, 2), by a force of 1 N and a moment of 1 N m."""
    minus = np.where(during, -1.0, 0.0)
    return np.hstack([stacked(minus), stacked(moment=minus)])


def stacked(
    force: np.ndarray | None = None, moment: np.ndarray | None = None, side: np.ndarray | None = None
) -> np.ndarray:
    """One column (3 n, 1)."""
    parts = (force, moment, side)
    n = next(len(part) for part in parts if part is not None)
    return np.concatenate([np.zeros(n) if part is None else part for part in parts])[:, None]


def shared(log: Recorded, wrench: np.ndarray, total: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces and moment of an arm without the noise that the target has too: forward, its slow share of what a refit
    predicts of the sum; the others, slowly."""
    kernel = np.ones(SLOWLY) / SLOWLY

    def slow(column: np.ndarray) -> np.ndarray:
        return np.convolve(column, kernel, "same")

    share = slow(wrench[:, 0] * total) / np.maximum(slow(total**2), 1e-9)
    return share * total, slow(wrench[:, 1]), slow(wrench[:, 5])


def in_parts(values: np.ndarray, count: int) -> np.ndarray:
    """Of `count` equal parts of the range, in which each value lies."""
    share = (values - values.min()) / max(float(np.ptp(values)), 1e-9)
    return np.minimum((share * count).astype(int), count - 1)


def edges(values: np.ndarray, count: int) -> list[float]:
    """Those of the parts."""
    return [float(edge) for edge in np.linspace(values.min(), values.max(), count + 1)]


def followed(values: np.ndarray, way: np.ndarray) -> np.ndarray:
    """What follows values with the way rolled, as casters do."""
    found = np.empty_like(values)
    found[0] = values[0]
    for i in range(1, len(values)):
        found[i] = values[i] + (found[i - 1] - values[i]) * np.exp(-(way[i] - way[i - 1]) / TRAIL)
    return found


def swung(log: Recorded, frequency: float, damping: float = 0.05) -> np.ndarray:
    """The acceleration (n,) of a bob that hangs on a cart."""
    own, position, speed = 2 * np.pi * frequency, 0.0, 0.0
    found, step, pieces = np.empty(len(log.u)), float(np.median(np.diff(log.time))), 20
    for i, pushed in enumerate(log.du):
        found[i] = -(own**2) * position - 2 * damping * own * speed
        for _ in range(pieces):  # the bob's place against the cart; half-implicit, so that it stays bounded
            speed += (-pushed - own**2 * position - 2 * damping * own * speed) * step / pieces
            position += speed * step / pieces
    return found
