"""Where a motion along one line has a corner: its speed changes within a tenth of a second, or at once.

Around an instant motions are parabolas with two breaks, told apart by how well they fit:

- *sudden*: the speed changes over `MAX_TOUCH_DURATION` at most, and the acceleration may be another before and after;
- *gradual*: the acceleration breaks twice, at least `MIN_PUSH_DURATION` apart, as under a push, or once, as under a
  step of it;
- *smooth*: a cubic and a quartic, or a wave;
- *jumping*: the place itself jumps twice, as a tracker's does, or once beside a break of the acceleration.

All have five coefficients and up to two places in time, so likelihoods compare as they are. The noise is what each
leaves: with n rows the log likelihood ratio is (n - 7) / 2 times the log of the ratio of the two sums of squares. What
is left is coloured where places are rounded or repeated, or where a parabola is not the whole truth; n then counts the
rows that are worth an independent one (`_worth`).

Where another hypothesis holds, a log likelihood ratio exceeds c with a probability of e^-c at most. So a corner is told
where it beats a mere break of the acceleration by log(N / `FALSE_CORNER_PROBABILITY`) at one of N instants, and each
other hypothesis by log(K / `FALSE_CORNER_PROBABILITY`) at one of the K instants that are left; and where its jump
stands as far out of the jumps that fit the motion everywhere else: what a log shows all the time is not sudden in it.

What throws the motion back at one place again and again is one thing: three corners or more there, which turn it the
same way, are told by the sum of their evidence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cartgrasp.frames import Array

from ..log_noise.log_noise import MAD_TO_STD
from ..log_noise.sample_step import usual_step

CORNER_HALF_WINDOW, MIN_HALF_WINDOW_ROWS = 0.4, 8
"""s to either side, and rows where these are few: what a parabola follows, and what it takes to tell."""
MIN_HALF_WINDOW = 0.15
"""s to either side that are needed at least: less shows no parabola beside a touch of `MAX_TOUCH_DURATION`."""
MAX_TOUCH_DURATION, MIN_PUSH_DURATION = 0.1, 0.3
"""s: bumpers and walls are touched for pi sqrt(m / k), 0.1 s at 20 kg and 20 kN/m; hands push for 0.3 s or more."""
CORNER_TIME_STEP = 0.02
"""s between instants that are tried."""
WAVE_PERIODS = (0.6, 0.75, 0.95, 1.2, 1.5)
"""s, of waves: twice `MIN_PUSH_DURATION` to what a window shows no more of than a quartic does."""
ACCELERATION_BREAK_STEP = 0.05
"""s between places where accelerations may break."""
N_HYPOTHESIS_PARAMETERS = 7
"""That a hypothesis has."""
FALSE_CORNER_PROBABILITY = 0.01
"""Probability that a log without a corner has one told, for each hypothesis that may hold there."""
CORNER_PLACE_TOLERANCE, MIN_CORNERS_AT_PLACE = 0.03, 3
"""m, rad: how well a corner's place is known; corners that make a place one where motion is thrown back."""
MIN_POSE_NOISE = 2e-6
"""m, rad: no tracker knows a place better."""
INSTANTS_PER_BLOCK = 256


@dataclass(frozen=True)
class Track:
    """Places (n,) along a line at times (n,), known to `noise` at best (what they are rounded to)."""

    time: Array
    place: Array
    noise: float = MIN_POSE_NOISE


class Corner(NamedTuple):
    """The speed changes at `time` (s), over `lasts` (s), by `jump`; `evidence` is the log of a likelihood ratio."""

    time: float
    lasts: float
    jump: float
    evidence: float


@dataclass(frozen=True)
class Windows:
    """Rows (m, n) around m instants: times from each, places, and which of the rows are there."""

    time: Array
    place: Array
    seen: NDArray[np.bool_]
    noise: float

    def cleared(self, columns: Array) -> Array:
        """Columns (m, k, n) without the parabola that fits each best."""
        base = np.stack([np.ones_like(self.time), self.time, self.time**2], axis=-1) * self.seen[..., None]
        smooth = np.linalg.qr(base)[0]
        columns = columns * self.seen[:, None]
        return np.asarray(columns - (columns @ smooth) @ np.swapaxes(smooth, 1, 2))

    def left(self, columns: Array, others: Array) -> tuple[Array, Array, Array]:
        """What is left (m, k, n) beside parabolas with two columns each (m, k, n), and the sizes (m, k) of these."""
        y, a, b = self.cleared(self.place[:, None]), self.cleared(columns), self.cleared(others)
        products = (a * a).sum(-1), (b * b).sum(-1), (a * b).sum(-1)
        first, second = _sizes(products, (a * y).sum(-1), (b * y).sum(-1))
        return np.asarray(y - first[..., None] * a - second[..., None] * b), first, second

    def least_left(self, columns: Array, pairs: tuple[np.ndarray, np.ndarray]) -> float:
        """The least sum of squares beside a parabola with two columns (k, n), of the pairs (v,), in one window."""
        y, own = self.cleared(self.place[:, None])[0, 0], self.cleared(columns[None])[0]
        (a, b), products, pull = pairs, own @ own.T, own @ y
        first, second = _sizes((products[a, a], products[b, b], products[a, b]), pull[a], pull[b])
        explained = first * pull[a] + second * pull[b]
        return max(float(y @ y - explained.max()), float(self.seen.sum() * self.noise**2))

    def squares(self, left: Array) -> Array:
        """Sums of squares of residuals (..., n), at least as large as the noise of the places makes them."""
        least = self.seen.sum(axis=-1) * self.noise**2
        return np.asarray(np.maximum((left**2).sum(axis=-1), least.reshape(-1, *[1] * (left.ndim - 2))))


def _sizes(products: tuple[Array, Array, Array], ay: Array, by: Array) -> tuple[Array, Array]:
    """The least-squares sizes of two columns, from their `products` aa, bb and ab and those with what they fit. Where
    both are alike, all is the first one's."""
    (aa, bb, ab), tiny = products, np.finfo(float).tiny
    first = ay / np.maximum(aa, tiny)
    rest = bb - ab**2 / np.maximum(aa, tiny)
    second = np.where(rest > 1e-9 * bb, (by - ab * first) / np.maximum(rest, tiny), 0.0)
    return first - second * ab / np.maximum(aa, tiny), second


def corners(track: Track, n_tracks: int) -> list[Corner]:
    """The corners of a track in order of time; `n_tracks` are looked at in all. The clearest is looked at first: it
    parts the track for the rest."""
    instants = track.time[np.unique((track.time - track.time[0]) // CORNER_TIME_STEP, return_index=True)[1]]
    least = math.log(n_tracks * len(instants) / FALSE_CORNER_PROBABILITY)
    found, unsure = list[Corner](), list[Corner]()
    evidence, jumps = _scanned(track, instants, found)
    usual = float(np.median(np.abs(jumps[jumps != 0.0]))) * MAD_TO_STD if jumps.any() else 0.0
    tried = 0
    while evidence.max() > least:
        best = int(np.argmax(evidence))
        corner = _told(track, float(instants[best]), found)
        tried += 1
        evidence[np.abs(instants - instants[best]) < MAX_TOUCH_DURATION] = 0.0
        if corner is None or abs(corner.jump) <= math.sqrt(2 * least) * usual:
            continue
        if corner.evidence <= -math.log(FALSE_CORNER_PROBABILITY):
            unsure.append(corner)
            continue
        found.append(corner)
        around = (np.abs(instants - corner.time) < 2 * reach_of(track)) & (evidence > 0.0)
        evidence[around], _ = _scanned(track, instants[around], found)
    needed = math.log(max(tried, 1) * n_tracks / FALSE_CORNER_PROBABILITY)
    known = [*found, *unsure]
    return sorted(one for one in known if one.evidence > needed or _evidence_of_place(track, one, known) > needed)


def _evidence_of_place(track: Track, corner: Corner, known: Sequence[Corner]) -> float:
    """The evidence of a place where several corners turn the motion the same way as this one does; 0 where they are
    few."""
    times = np.array([one.time for one in known])
    places = np.interp([corner.time, *times], track.time, track.place)
    alike = np.sign([one.jump for one in known]) == np.sign(corner.jump)
    there = alike & (np.abs(places[1:] - places[0]) < CORNER_PLACE_TOLERANCE)
    evidence = np.array([one.evidence for one in known])[there]
    return float(evidence.sum()) if len(evidence) >= MIN_CORNERS_AT_PLACE else 0.0


def jump_at(track: Track, time: float, lasts: float) -> float:
    """The change of a speed at a time (s) over a while (s), where it is taken to be; 0 where that can't be told."""
    rows, windows = windows_around(track, np.array([time]), ())
    if not len(rows):
        return 0.0
    bend, turn = _bent(windows.time, np.zeros(1)), turning(windows.time, np.zeros(1), np.array([lasts]))
    return float(windows.left(bend[None], turn[None])[2][0, 0])


def reach_of(track: Track) -> float:
    """s to either side of an instant that are looked at."""
    return max(CORNER_HALF_WINDOW, MIN_HALF_WINDOW_ROWS * usual_step(track.time))


def without_corner(found: Sequence[Corner], at: Array) -> tuple[Array, Array]:
    """The times (m,) from which and until which the motion around instants (m,) has no corner."""
    times = np.array([-np.inf, *sorted(corner.time for corner in found), np.inf])
    after = np.searchsorted(times[1:-1], at, side="right")
    return times[after] + MAX_TOUCH_DURATION / 2, times[after + 1] - MAX_TOUCH_DURATION / 2


def turning(time: Array, at: Array, lasts: Array) -> Array:
    """Places of a motion whose speed rises by 1 around an instant, over a while."""
    half = np.maximum(lasts, 1e-9) / 2
    return np.asarray((_bent(time, at - half) - _bent(time, at + half)) / (2 * half))


def _bent(time: Array, at: Array) -> Array:
    """Places of a motion whose acceleration rises by 1 at an instant."""
    return np.asarray(np.maximum(time - at, 0.0) ** 2 / 2)


def _scanned(track: Track, instants: Array, found: Sequence[Corner]) -> tuple[Array, Array]:
    """Evidence (m,) of a corner at each instant against a mere break of the acceleration there, and by how much the
    speed changes at it (m,); 0 where it can't be told."""
    evidence, jumps = np.zeros((2, len(instants)))
    lasts = np.array([0.0, MAX_TOUCH_DURATION / 2, MAX_TOUCH_DURATION])[:, None]
    for start in range(0, len(instants), INSTANTS_PER_BLOCK):
        block = instants[start : start + INSTANTS_PER_BLOCK]
        rows, windows = windows_around(track, block, found)
        if not len(rows):
            continue
        time = windows.time[:, None]
        others = np.concatenate([np.zeros_like(time), turning(time, np.zeros(1), lasts)], axis=1)
        left, _, sizes = windows.left(np.broadcast_to(_bent(time, np.zeros(1)), others.shape), others)
        squares = windows.squares(left)
        best = 1 + squares[:, 1:].argmin(axis=1)
        each = np.arange(len(rows))
        worth = _worth(left[each, best], windows.seen)
        evidence[start + rows] = worth / 2 * np.log(squares[:, 0] / squares[each, best])
        jumps[start + rows] = sizes[each, best]
    return evidence, jumps


def _told(track: Track, instant: float, found: Sequence[Corner]) -> Corner | None:
    """The corner near an instant, if there is one: a break of the acceleration that comes a little sooner or later is
    as good as a small one."""
    rows, windows = windows_around(track, np.array([instant]), found)
    if not len(rows):
        return None
    at, lasts = np.meshgrid(np.arange(-6, 7) / 100, np.arange(0, 6) * MAX_TOUCH_DURATION / 5)
    at, lasts = at.reshape(-1, 1), lasts.reshape(-1, 1)
    left, bends, jumps = windows.left(_bent(windows.time, at)[None], turning(windows.time, at, lasts)[None])
    squares = windows.squares(left)[0]
    best = int(squares.argmin())
    if abs(jumps[0, best]) < MAX_TOUCH_DURATION * abs(bends[0, best]):
        return None
    worth = float(_worth(left[:, best], windows.seen)[0])
    evidence = math.inf
    for others in (_smooth(windows.time[0]), _gradual(windows.time[0]), _jumping(windows.time[0])):
        evidence = min(evidence, worth / 2 * math.log(windows.least_left(*others) / squares[best]))
    return Corner(instant + float(at[best, 0]), float(lasts[best, 0]), float(jumps[0, best]), evidence)


Others = tuple[Array, tuple[np.ndarray, np.ndarray]]
"""Columns (k, n), and which two of them (v,), (v,) are a hypothesis."""


def _gradual(time: Array) -> Others:
    """Pairs of breaks of the acceleration."""
    places = np.arange(time[0], time[-1] + ACCELERATION_BREAK_STEP, ACCELERATION_BREAK_STEP)
    first, second = np.triu_indices(len(places))
    apart = places[second] - places[first] > MIN_PUSH_DURATION - ACCELERATION_BREAK_STEP / 2
    return _bent(time, places[:, None]), (first[apart], second[apart])


def _smooth(time: Array) -> Others:
    """A cubic and a quartic, and both phases of waves."""
    pace = 2 * np.pi / np.array(WAVE_PERIODS)[:, None] * time
    each = np.arange(1 + len(WAVE_PERIODS))
    return np.vstack([time**3, np.cos(pace), time**4, np.sin(pace)]), (each, len(each) + each)


def _jumping(time: Array) -> Others:
    """Pairs of jumps, and jumps beside a break of the acceleration."""
    steps = np.tri(len(time), k=-1)[:, :-1].T
    bends = _bent(time, np.arange(time[0], time[-1], ACCELERATION_BREAK_STEP)[:, None])
    first, second = np.triu_indices(len(steps), 1, len(steps) + len(bends))
    return np.concatenate([steps, bends]), (first, second)


def windows_around(track: Track, instants: Array, found: Sequence[Corner]) -> tuple[np.ndarray, Windows]:
    """Which of the instants (m,) have rows enough around them, and their windows."""
    reach, time = reach_of(track), track.time
    since, until = without_corner(found, instants)
    first = np.searchsorted(time, np.maximum(instants - reach, since))
    last = np.searchsorted(time, np.minimum(instants + reach, until), side="right")
    here = np.searchsorted(time, instants, side="right")
    rows = np.flatnonzero(
        (here - first >= MIN_HALF_WINDOW_ROWS / 2) & (last - here >= MIN_HALF_WINDOW_ROWS / 2) & (here < len(time))
    )
    begins, before = time[first[rows]], time[here[rows] - 1]
    after, ends = time[here[rows]], time[last[rows] - 1]
    at = instants[rows]
    enough = (
        (at - begins >= MIN_HALF_WINDOW)
        & (ends - at >= MIN_HALF_WINDOW)
        & (at - before < MAX_TOUCH_DURATION)
        & (after - at < MAX_TOUCH_DURATION)
    )
    rows = rows[enough]
    index = first[rows, None] + np.arange(int((last - first)[rows].max(initial=0)))
    seen = index < last[rows, None]
    index = np.minimum(index, len(time) - 1)
    places = track.place[index] - track.place[here[rows] - 1, None]
    return rows, Windows(np.where(seen, time[index] - instants[rows, None], 0.0), places, seen, track.noise)


def _worth(left: Array, seen: np.ndarray) -> Array:
    """How many rows more than a hypothesis has numbers what is left (m, n) is worth: as many as leave a mean of a first
    order process as uncertain. It has to change its sign as often as there are numbers, which noise does in twice as
    many rows."""
    squares = np.maximum((left**2).sum(axis=-1), np.finfo(float).tiny)
    follows = np.clip((left[:, 1:] * left[:, :-1]).sum(axis=-1) / squares, 0.0, 1.0)
    n = seen.sum(axis=-1)
    independent = np.maximum(n * (1 - follows) / (1 + follows), 2 * N_HYPOTHESIS_PARAMETERS)
    return np.asarray(np.maximum(np.minimum(n, independent) - N_HYPOTHESIS_PARAMETERS, 0.0))
