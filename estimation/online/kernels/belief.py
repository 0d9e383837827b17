"""The algebra of `regressor/regression_belief.py` and `load_monitor.py`, which say what they are about."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .correction import factorise, put
from .jit import Indices, row_compiled, row_entry
from .matrices import congruence, inverse, product, solved, times, turned, without
from .row_algebra import FilteredRow
from .row_parts import FILTER_RATE
from .slope_noise import SlopeNoise, after_row, in_score, without_foreseen_noise, without_slope_noise

Belief = tuple[Array, Array]
"""Information (k, k) or (k + l, k + l), with the link, and its product with the mean."""
RowInnovation = tuple[float, Array, Array, Array, Array, Array, Array, tuple[Array, Array, Array]]
"""A row's normalised square, and what it says of a change: information's product (k - 1,), information, and how much of
that is noise in slopes; what was not foretold, its covariance, and that if parameters were known; and these three with
noise in slopes as it is, and noise of the motion as the belief's own masses make it."""
UpdateLimits = tuple[float, float, float]
"""The share kept of what is known, and the squares by component beyond which a row pulls less, and is none."""
COVARIANCE_ROUNDING = 1e-11
"""Share of a covariance that is rounding."""
MIN_SHARED_NOISE_RATIO = 1e-9
"""Share of a row's noise that is taken as shared where nothing is."""


@row_entry
def concluded(
    belief: Belief, noise: SlopeNoise, theta: Array, free: Indices
) -> tuple[Belief, tuple[Array, Array, Array, float]]:
    """What rows tell, noise in their slopes taken off; and parameters (p,), of which those that are `free` are as
    believed then, with their covariance (p, p), a root of it (p, f), and the delay."""
    told = without_slope_noise(belief, noise)
    f, p, covariance = len(free), len(theta), inverse(told[0])
    mean, factor = times(covariance, told[1]), covariance[:f, :f].copy()
    found, whole, root = theta.copy(), np.zeros((p, p)), np.zeros((p, f))
    factorise(factor, f)
    for a in range(f):
        found[free[a]] = mean[a]
        for b in range(f):
            whole[free[a], free[b]] = covariance[a, b]
            if b <= a:
                root[free[a], b] = factor[a, b]
    return told, (found, whole, root, mean[f])


@row_entry
def absorbed(
    known: tuple[Belief, SlopeNoise], row: FilteredRow, at: Array, free: Indices, limits: UpdateLimits
) -> tuple[tuple[Belief, SlopeNoise], RowInnovation]:
    """The belief after a row around parameters (p,), whose link is handed on, and its innovation. A row that is no
    measurement teaches nothing."""
    belief, in_slopes = known
    kept, gate, absurd = limits
    n, k = len(row.residual), len(free) + 1
    noise, slopes, value = row.noise + row.curvature, np.empty((n, k)), row.residual.copy()
    for j in range(k):
        of = free[j] if j < k - 1 else len(at)
        for a in range(n):
            slopes[a, j] = row.slopes[a, of]
            value[a] += slopes[a, j] * at[of] if j < k - 1 else 0.0
    linking = _linking(noise, row.shared, row.before)
    information, pull = belief if len(belief[1]) > k else _linked(belief, linking)
    whole, more = without_slope_noise((information, pull), in_slopes)
    covariance = inverse(whole)
    mean = times(covariance, more)
    before, after = np.zeros((n, k + 2 * n)), np.zeros((n, 2 * n))
    put(slopes, before[:, :k])
    put(row.ends, after[:, :n])
    for a in range(n):
        before[a, k + n + a] = after[a, n + a] = 1.0
        for b in range(n):
            before[a, k + b] = -row.fade * row.ends[a, b]
    alone, linking = noise - 2.0 * row.shared, _linking(noise, row.shared, row.after)
    own, raw = alone + congruence(after, linking), value - times(before, mean)
    bent = _of_bent_delay(row.bent_by_delay, (before, covariance), own, raw, k - 1)
    alone, own = alone + bent, own + bent
    link = solved(information[k:, k:], np.eye(2 * n))
    spreads = own + congruence(before[:, k:].copy(), link), own + congruence(before, covariance)
    motion = FILTER_RATE**2 * (row.after + row.fade**2 * link[:n, :n])
    foreseen = FILTER_RATE * row.fade * mean[k : k + n].copy()
    found = without_foreseen_noise(row, free, (motion, foreseen), spreads, raw)
    more_noise = _by_own_masses(row, free, motion, mean[: k - 1] - _of_free(at, free))
    in_own = raw, spreads[1] + more_noise, spreads[0] + more_noise
    for a in range(n):
        for j in range(k - 1):
            slopes[a, j] += found.slopes[a, j]
            value[a] += found.slopes[a, j] * at[free[j]]
    put(slopes, before[:, :k])
    innovation, spread = value - times(before, mean), congruence(before, covariance) + own
    square = _square(innovation, spread)
    if not square < absurd * n:
        none = np.zeros((k - 1, k - 1))
        nothing = square, np.zeros(k - 1), none, none, innovation, spread, spreads[0], in_own
        return ((information, pull), in_slopes), nothing
    scale = max(1.0, square / (gate * n))
    taught = slopes[:, : k - 1].copy()
    weight = solved(scale * spread, np.eye(n))
    asked = product(turned(taught), weight)
    bias, by_noise = in_score(row, free, found, weight)
    pulled = times(asked, innovation) + bias[: k - 1]
    of_change = pulled, product(asked, taught), by_noise[: k - 1, : k - 1].copy()
    said = square, *of_change, innovation, spread, spreads[0], in_own
    whole, more = _linked((information, pull), linking)
    _forget(whole, more, slopes, scale * own, (mean, covariance), kept)
    wide = np.empty((n, k + 4 * n))
    put(before, wide[:, : k + 2 * n])
    put(after, wide[:, k + 2 * n :])
    weighed = turned(solved(scale * alone, wide))
    whole += product(weighed, wide)
    more += times(weighed, value)
    bias, by_noise = in_score(row, free, found, solved(scale * spreads[0], np.eye(n)))
    for j in range(k):
        more[j] += bias[j]
        for i in range(k - 1):
            more[j] -= by_noise[j, i] * at[free[i]]
    left = without(whole, more, k, k + 2 * n)
    return (left, after_row(in_slopes, by_noise, kept)), said


@row_compiled
def _of_bent_delay(bent: Array, known: tuple[Array, Array], own: Array, innovation: Array, at: int) -> Array:
    """The covariance (n, n) of `bent z² / 2`, which a row that is linear in the delay leaves out; z is how far off that
    was, as the row itself tells. The delay is unknown number `at` of those with slopes (n, u) and covariance (u, u);
    the row's own noise is `own` (n, n)."""
    n, (slopes, covariance) = len(bent), known
    noise = np.zeros((n, n))
    if not np.abs(bent).max() > 0.0:
        return noise
    towards = np.zeros((n, 1))
    for a in range(n):
        for j in range(len(covariance)):
            towards[a, 0] += slopes[a, j] * covariance[j, at]
    weighed, off, variance = solved(own + congruence(slopes, covariance), towards), 0.0, covariance[at, at]
    for a in range(n):
        off += weighed[a, 0] * innovation[a]
        variance -= weighed[a, 0] * towards[a, 0]
    fourth = 3.0 * variance**2 + 6.0 * variance * off**2 + off**4
    for a in range(n):
        for b in range(n):
            noise[a, b] = 0.25 * bent[a] * bent[b] * fourth
    return noise


@row_compiled
def _by_own_masses(row: FilteredRow, free: Indices, motion: Array, change: Array) -> Array:
    """How much more noise (n, n) a row has, of which B[nu'] has the covariance `motion` (n, n), with the free
    parameters changed by so much."""
    masses, own = row.ends / -FILTER_RATE, row.ends / -FILTER_RATE
    for q in range(len(free)):
        own += change[q] * row.by_rise[:, :, free[q]]
    return congruence(own, motion) - congruence(masses, motion)


@row_compiled
def _of_free(theta: Array, free: Indices) -> Array:
    found = np.empty(len(free))
    for q in range(len(free)):
        found[q] = theta[free[q]]
    return found


@row_entry
def evidence(since: tuple[Array, Array, Array], root: Array) -> float:
    """The log evidence of a load of covariance `root @ rootᵀ`, root (f, m), that came at the most likely of n moments,
    since each of which there is a score u (n, f). It varies by the information S (n, f, f), of which noise in slopes
    makes N (n, f, f), and a change moves it by `S - N`: `log N(u; 0, S + (S - N) P (S - N)) - log N(u; 0, S)`."""
    information, by_noise, scores = since
    best = -math.inf
    for i in range(len(scores)):
        asked, noise = congruence(turned(root), information[i]), congruence(turned(root), by_noise[i])
        varies, moves = asked + noise, asked - noise
        score = times(turned(root), scores[i])
        least = COVARIANCE_ROUNDING * np.trace(varies)
        for a in range(len(score)):
            varies[a, a] += least
        best = max(best, _log_density(score, varies + product(moves, moves)) - _log_density(score, varies))
    return best


@row_compiled
def _log_density(value: Array, covariance: Array) -> float:
    """The log density of a normal value (n,), but for a constant."""
    factor, white, found = covariance.copy(), value.copy(), 0.0
    factorise(factor, len(factor))
    for a in range(len(white)):
        for b in range(a):
            white[a] -= factor[a, b] * white[b]
        white[a] /= factor[a, a]
        found -= 0.5 * white[a] ** 2 + math.log(factor[a, a])
    return found


@row_compiled
def _linking(noise: Array, shared: Array, error: Array) -> Array:
    """Covariance (2 n, 2 n) of what is wrong with nu, given (n, n), and of noise that neighbours share."""
    n = len(error)
    covariance = np.zeros((2 * n, 2 * n))
    put(error, covariance[:n, :n])
    put(shared + MIN_SHARED_NOISE_RATIO * noise, covariance[n:, n:])
    return covariance


@row_compiled
def _linked(belief: Belief, linking: Array) -> Belief:
    """The belief with further unknowns of mean zero and covariance `linking`."""
    information, pull = belief
    k, n = len(pull), len(linking)
    whole, more = np.zeros((k + n, k + n)), np.zeros(k + n)
    put(information, whole[:k, :k])
    put(solved(linking, np.eye(n)), whole[k:, k:])
    copy(pull, more[:k])
    return whole, more


@row_compiled
def _forget(whole: Array, pull: Array, slopes: Array, noise: Array, now: Belief, kept: float) -> None:
    """Forgets, in place, some of the information about what the row asks, and never more than the row answers."""
    k, root = slopes.shape[1], noise.copy()
    factorise(root, len(root))
    for a in range(len(root)):
        root[a, a + 1 :] = 0.0
    asked = solved(root, slopes)
    known, directions = np.linalg.eigh(congruence(asked, now[1][:k, :k]))
    along = product(turned(directions), asked)
    for a in range(len(known)):
        taken, held = min((1.0 - kept) / max(known[a], 1e-300), 1.0), 0.0
        for i in range(k):
            held += along[a, i] * now[0][i]
        for i in range(k):
            pull[i] -= taken * along[a, i] * held
            for j in range(k):
                whole[i, j] -= taken * along[a, i] * along[a, j]


@row_compiled
def _square(innovation: Array, spread: Array) -> float:
    whitened, square = solved(spread, innovation.reshape((len(innovation), 1))), 0.0
    for i in range(len(innovation)):
        square += innovation[i] * whitened[i, 0]
    return square
