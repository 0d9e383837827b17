"""LISDD (Wang, 2026, arXiv 2606.23215): in which regime a model is wrong, by which term, and how sure that is.

Of the paper we had the abstract alone: the known physics is fitted on a clean regime that is found automatically;
regions are flagged by a calibrated energy of residuals; in each, an exhaustive search of a library by holdout selects
the missing term, and an F-test on split samples confirms it; over regions the false discovery rate is controlled. It
has no code here but this. What is a guess:

- noise: an autoregression in each channel of what the whole library leaves with all terms free; it whitens all rows;
- regions: connected cells of time, of place or of speed, gaps of one cell closed; or the whole log, which may be all
  wrong. Of these the kind whose terms predict samples held out of the fit best;
- the clean regime: cells whose energy Benjamini-Hochberg does not reject, from the quieter half of them on; where it
  is less than half of the log, regions of that kind are none;
- the library: what acts in a time, in a place, at a speed, or all along, one term a region;
- samples: every second selects, fitted and held out in turn; the others test;
- the F-test: on clean samples and those of the region, physics free; exact where noise is as said.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.ndimage import binary_closing, label
from scipy.signal import lfilter
from scipy.stats import f as f_distribution

from .columns import Candidate, candidates, in_parts, of_motion, of_place, one_kilogram, pushed
from .physics import measured, nominal_columns, report, weights
from .recorded import Cart, Recorded

LEVEL = 0.01
"""False discovery rate, of cells and of terms; of 0.05, 0.01 and 0.001 the best on seeds 40 to 43."""
ORDER = 3
"""Of the noise's autoregression."""
WINDOW, SQUARES, SPEEDS = 2.0, 6, 8
"""s; cells along each axis of the floor; cells of speed."""
TRIMS, TURNS = 3, 10
"""Rounds in which the quieter half is the clean regime; of all at most."""
LEAST_CLEAN = 0.5
LOCAL = ("floor_patch", "payload_change", "external_push")


@dataclass(frozen=True, eq=False)
class Rows:
    """Whitened: target (3, n), columns of the physics (3, n, k); the noise's degrees of freedom."""

    target: np.ndarray
    physics: np.ndarray
    free: float

    def left(self, columns: Sequence[np.ndarray], fitted: np.ndarray, asked: np.ndarray) -> tuple[float, int]:
        """The squares that physics and columns (3, n, k), fitted to samples `fitted` (n,), leave of samples `asked`,
        and the fit's rank."""
        design = np.concatenate([self.physics, *columns], axis=2)
        value, _, rank, _ = np.linalg.lstsq(flat(design[:, fitted]), self.target[:, fitted].ravel(), rcond=1e-9)
        return float(((self.target[:, asked] - design[:, asked] @ value) ** 2).sum()), int(rank)


@dataclass(frozen=True, eq=False)
class Partition:
    """The samples (n,) that are clean, and those of each region."""

    kind: str
    clean: np.ndarray
    regions: list[np.ndarray]


@dataclass(frozen=True, eq=False)
class Term:
    """Of a region, its samples (n,), and whitened columns (3, n, k) that are 0 elsewhere."""

    candidate: Candidate
    region: np.ndarray
    columns: np.ndarray


def localised(log: Recorded, cart: Cart, _: float = 0.0) -> dict[str, Any]:
    """A report, whose only `where` is all that is flagged."""
    taps, free = noise(log, cart)
    rows = Rows(whitened(taps, measured(log)[:, None])[..., 0], whitened(taps, nominal_columns(log, cart)), free)
    turn = np.arange(rows.target.shape[1]) % 4
    found = []
    for part in partitions(log, rows):
        library = [(one, whitened(taps, one.columns)) for one in library_of(part.kind, log, cart)]
        tried = [[placed(*one, region, log) for one in library] for region in part.regions]
        terms = [term for some in tried if (term := selected(rows, part, some, turn))]
        found.append((held_out(rows, terms, turn, turn >= 0), part, terms))
    _, part, terms = min(found, key=lambda one: one[0], default=(0.0, None, []))
    sure = confirmed(rows, part, terms, turn % 2 == 1) if part else []
    told = report(cart, flat(rows.physics), rows.target.ravel(), [(one.candidate, flat(one.columns)) for one in sure])
    if part and not sure:
        told["verdict"] = "unexplained"
    return told | {"where": where(log.time[ORDER:], np.any(part.regions, axis=0)) if part else []}


def held_out(rows: Rows, terms: Sequence[Term], turn: np.ndarray, used: np.ndarray) -> float:
    """Squares that fits to every fourth of the samples `used` leave of those two samples on, in turn."""
    columns, first, second = [one.columns for one in terms], used & (turn == 0), used & (turn == 2)
    return rows.left(columns, first, second)[0] + rows.left(columns, second, first)[0]


def noise(log: Recorded, cart: Cart) -> tuple[list[np.ndarray], float]:
    """Filters that make each channel's noise white and of size one, and its degrees of freedom."""
    physics, target = nominal_columns(log, cart), measured(log)
    weight = weights(physics, target)
    design = weight * np.hstack([physics, *(one.columns for one in candidates(log, cart))])
    sides, sizes, _ = np.linalg.svd(design / np.maximum(np.linalg.norm(design, axis=0), 1e-12), full_matrices=False)
    sides = sides[:, sizes > 1e-6 * sizes[0]]
    scaled = weight[:, 0] * target
    left = ((scaled - sides @ (sides.T @ scaled)) / weight[:, 0]).reshape(3, -1)
    free = left.shape[1] - (sides**2).reshape(3, left.shape[1], -1).sum(axis=(1, 2))
    taps = []
    for one, degrees in zip(left, free, strict=True):
        lags = np.array([one[: len(one) - k] @ one[k:] for k in range(ORDER + 1)])
        lags[0] = 1e-12 + (1 + 1e-9) * lags[0]
        tap = np.array([1.0, *-solve_toeplitz(lags[:-1], lags[1:])])
        size = np.sqrt((lfilter(tap, 1.0, one)[ORDER:] ** 2).sum() / max(degrees - ORDER, 1.0))
        taps.append(tap / max(size, 1e-9))
    return taps, float(free.sum())


def whitened(taps: Sequence[np.ndarray], columns: np.ndarray) -> np.ndarray:
    """(3, n - ORDER, k) of columns (3 n, k)."""
    channels = columns.reshape(3, -1, columns.shape[1])
    return np.stack([lfilter(tap, 1.0, one, axis=0)[ORDER:] for tap, one in zip(taps, channels, strict=True)])


def partitions(log: Recorded, rows: Rows) -> Iterator[Partition]:
    """Those with regions; of a part of the log those that leave most of it clean."""
    windows = max(round(float(np.ptp(log.time)) / WINDOW), 1)
    axes = {
        "all": [(0 * log.time.astype(int), 1)],
        "time": [(in_parts(log.time, windows), windows)],
        "place": [(in_parts(log.x, SQUARES), SQUARES), (in_parts(log.y, SQUARES), SQUARES)],
        "speed": [(in_parts(log.u, SPEEDS), SPEEDS)],
    }
    for kind, along in axes.items():
        shape = tuple(count for _, count in along)
        cell = np.ravel_multi_index([place for place, _ in along], shape)[ORDER:]
        flagged = ~clean_cells(rows, cell, int(np.prod(shape))).reshape(shape)
        flagged |= binary_closing(np.pad(flagged, 1))[(slice(1, -1),) * len(shape)]
        number = label(flagged)[0].ravel()[cell]
        regions = [number == k for k in np.unique(number[number > 0])]
        if regions and (kind == "all" or (number == 0).mean() >= LEAST_CLEAN):
            yield Partition(kind, number == 0, regions)


def clean_cells(rows: Rows, cell: np.ndarray, count: int) -> np.ndarray:
    """(count,): whether physics that is fitted on such cells leaves no more there than noise."""
    size = 3 * np.maximum(np.bincount(cell, minlength=count), 1)
    clean = np.ones(count, dtype=bool)
    for turn in range(TURNS):
        inside, before = clean[cell], clean
        value = np.linalg.lstsq(flat(rows.physics[:, inside]), rows.target[:, inside].ravel(), rcond=1e-9)[0]
        energy = np.bincount(cell, ((rows.target - rows.physics @ value) ** 2).sum(axis=0), count) / size
        clean = ~rejected(f_distribution.sf(energy, size, rows.free))
        if turn < TRIMS and count > 1:
            clean = energy <= np.median(energy[np.unique(cell)])
        elif (clean == before).all() or not clean[cell].any():
            break
    return clean


def library_of(kind: str, log: Recorded, cart: Cart) -> list[Candidate]:
    """What acts in a time, in a place, at a speed, or all along."""
    if kind == "time":
        push = Candidate("external_push", pushed(np.ones(len(log.time))), ("force", "moment"))
        return [push, Candidate("payload_change", one_kilogram(log, cart), ("mass",))]
    if kind == "place":
        patch = [replace(one, name="floor_patch") for one in of_motion(log, cart) if one.name == "rolling_resistance"]
        return [*patch, *(one for one in of_place(log, cart) if one.name not in LOCAL)]
    if kind == "speed":
        return list(of_motion(log, cart))
    return [one for one in candidates(log, cart) if one.name not in LOCAL]


def placed(one: Candidate, columns: np.ndarray, region: np.ndarray, log: Recorded) -> Term:
    """A term of a region, which says when or where that is. What is heavier before a time is a load taken off."""
    own, sign, settings = np.flatnonzero(region) + ORDER, 1.0, {}
    start, stop = (float(log.time[own[k]]) for k in (0, -1))
    if one.name == "external_push":
        settings = {"start": start, "duration": stop - start}
    elif one.name == "payload_change":
        settings, sign = ({"time": stop}, -1.0) if region[0] else ({"time": start}, 1.0)
    elif one.name == "floor_patch":
        places = {"x": log.x[own], "y": log.y[own]}
        settings = {f"{name}_{end.__name__}": float(end(at)) for name, at in places.items() for end in (min, max)}
    return Term(replace(one, settings=settings), region, sign * columns * region[:, None])


def selected(rows: Rows, part: Partition, terms: Sequence[Term], turn: np.ndarray) -> Term | None:
    """Of a region's, that with which held-out samples are predicted best; None where they are without any."""
    used = part.clean | terms[0].region
    errors = [held_out(rows, some, turn, used) for some in ([], *([one] for one in terms))]
    return (None, *terms)[int(np.argmin(errors))]


def confirmed(rows: Rows, part: Partition, terms: Sequence[Term], tested: np.ndarray) -> list[Term]:
    """On samples `tested` (n,), which have selected nothing."""
    p = []
    for term in terms:
        used = tested & (part.clean | term.region)
        (without, fewer), (best, rank) = (rows.left(some, used, used) for some in ([], [term.columns]))
        gained, free = rank - fewer, 3 * int(used.sum()) - rank
        p.append(
            f_distribution.sf((without - best) / gained * free / max(best, 1e-300), gained, free) if gained > 0 else 1.0
        )
    return [term for term, is_sure in zip(terms, rejected(np.array(p)), strict=True) if is_sure]


def rejected(p: np.ndarray) -> np.ndarray:
    """(n,) bool, by Benjamini and Hochberg (1995)."""
    order = np.sort(p)
    below = order[order <= LEVEL * np.arange(1, len(p) + 1) / max(len(p), 1)]
    return p <= (below[-1] if len(below) else -1.0)


def flat(columns: np.ndarray) -> np.ndarray:
    """(3, n, k) as (3 n, k)."""
    return columns.reshape(-1, columns.shape[2])


def where(time: np.ndarray, flagged: np.ndarray) -> list[dict[str, Any]]:
    """All samples that are flagged, as one condition of a report."""
    edges = np.flatnonzero(np.diff(flagged.astype(int), prepend=0, append=0)).reshape(-1, 2)
    spans = [(float(time[first]), float(time[end - 1])) for first, end in edges]
    return [{"start": spans[0][0], "stop": spans[-1][1], "intervals": spans}]
