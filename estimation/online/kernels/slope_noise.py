"""What noise of the motion in rows' slopes does, and what rows tell in spite of it.

The noise e of B[nu'] is in a row's slopes s and in its innovation r alike (errors in variables): `E[s W r]` is not zero
at the true parameters, which pulls towards zero whatever rows leave free. Two things are done about it.

What is foreseen of e is taken off the slopes (conditional score; Stefanski and Carroll 1987). It is foreseen by the
innovation, as far as that is not what parameters that are not known yet do; so a bias is left, which is added to the
score (corrected score; Nakamura 1990). `u = s W r + bias` then is zero in the mean at the true parameters, of whatever
weights W and guess.

Its slope is not `S = sum of s W s` but `J = S - N`, of which N is what noise alone adds. So rows have Godambe's
information `J C^-1 J` (Godambe 1960), where C is how u varies: S, and what is not known of N while there are few rows,
times how far off parameters may be. In a direction in which J does not stand out of what is not known of N, it is
nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .jit import Indices, row_compiled
from .matrices import add_product, congruence, in_units, inner, product, solved, times, turned, without
from .row_algebra import FilteredRow
from .row_parts import FILTER_RATE, SIGNIFICANCE_SIGMAS

MIN_EXCITATION_RATIO = 1e-3
"""Share of the first information below which a direction counts as not asked by rows."""


class SlopeNoise(NamedTuple):
    """What noise in slopes has added to the `information` (k, k) since a belief was given: its mean (k,), covariance
    (k, k) and information `first` (k, k). `squares` (1,) is the sum over rows of the squares of what each added, in
    `first` variances."""

    information: Array
    squares: Array
    mean: Array
    covariance: Array
    first: Array


class CorrectedSlopes(NamedTuple):
    """What is added to a row's slopes (n, k - 1); the covariance (n, n) of the noise that is `left` in B[nu'] then, and
    how it goes with the innovation, `across` (n, n)."""

    slopes: Array
    left: Array
    across: Array


@row_compiled
def after_row(noise: SlopeNoise, added: Array, kept: float) -> SlopeNoise:
    """After a row which added to the information (k, k)."""
    information, squares, size = kept * noise.information, kept**2 * noise.squares, 0.0
    for i in range(len(added)):
        for j in range(len(added)):
            information[i, j] += added[i, j]
            size += added[i, j] * noise.covariance[i, j]
    squares[0] += size**2
    return SlopeNoise(information, squares, noise.mean, noise.covariance, noise.first)


@row_compiled
def without_foreseen_noise(
    row: FilteredRow, free: Indices, motion: tuple[Array, Array], spreads: tuple[Array, Array], innovation: Array
) -> CorrectedSlopes:
    """What is foreseen of a row's noise of B[nu'] is taken off; rows before tell its covariance (n, n), and the mean
    (n,) of what takes it off. The innovation (n,) has the first covariance (n, n) if parameters are known, the second
    as they are."""
    (covariance, foreseen), (alone, spread) = motion, spreads
    usual = alone + row.quieter
    by_wrench = product(covariance, turned(row.ends)) / -FILTER_RATE
    gain = turned(solved(spread + row.quieter, turned(by_wrench)))
    taken = foreseen + times(gain, innovation)
    crossed = product(gain, turned(by_wrench))
    left = covariance - crossed - turned(crossed) + congruence(gain, usual)
    found = CorrectedSlopes(
        np.zeros((len(innovation), len(free))), left, turned(by_wrench) - product(usual, turned(gain))
    )
    for q in range(len(free)):
        slope = times(row.by_rise[:, :, free[q]].copy(), taken)
        for i in range(len(slope)):
            found.slopes[i, q] = slope[i]
    return found


@row_compiled
def in_score(row: FilteredRow, free: Indices, found: CorrectedSlopes, weight: Array) -> tuple[Array, Array]:
    """What noise that is left in slopes does to the score `s W r` of a weight (n, n): what is to be added to it
    (k,), and the information (k, k) that it makes."""
    n, m = len(weight), len(free)
    uneven, bias, information = product(weight, found.across), np.zeros(m + 1), np.zeros((m + 1, m + 1))
    noisy, weighed = np.zeros((m, n, n)), np.zeros((m, n, n))
    for q in range(m):
        by = row.by_rise[:, :, free[q]].copy()
        add_product(by, found.left, noisy[q])
        add_product(weight, by, weighed[q])
        bias[q] = inner(uneven, by)
        for i in range(q + 1):
            information[q, i] = information[i, q] = inner(noisy[i], weighed[q])
    information[m, m] = inner(weight, row.of_delay[0])
    bias[m] = -inner(weight, row.of_delay[1])
    return bias, information


@row_compiled
def without_slope_noise(belief: tuple[Array, Array], noise: SlopeNoise) -> tuple[Array, Array]:
    """The information that rows have in spite of noise in their slopes, and its product with the mean, from what they
    have with it; k unknowns, and others beside."""
    k, (information, pull) = len(noise.mean), belief
    most = inner(noise.information, noise.covariance)
    if not most > 0.0:
        return belief
    if len(pull) > k:
        information, pull = without(information, pull, k, len(pull))
    size = np.empty(k)
    for i in range(k):
        size[i] = math.sqrt(noise.first[i, i])
    added, known, made = in_units(information, size), in_units(noise.first, size), in_units(noise.information, size)
    rows = added - (1.0 - MIN_EXCITATION_RATIO) * known
    root, least = _root_of_inverse(rows)
    if not least > 0.0:
        rows = added - (1.0 - MIN_EXCITATION_RATIO) * _left_of(known, added)
        root, _ = _root_of_inverse(rows)
    share, turn = np.linalg.eigh(congruence(turned(root), made))
    directions = product(root, turn)
    asked = product(rows, directions)
    score = times(turned(directions), (pull - times(information - noise.information, noise.mean)) / size)
    first = congruence(turned(asked), in_units(noise.covariance, 1.0 / size))
    lost, missed = np.zeros((k, k)), np.zeros(k)
    for i in range(k):
        noisy = max(share[i], 0.0)
        slope = max(1.0 - noisy, 0.0)
        chance = SIGNIFICANCE_SIGMAS**2 * 2.0 * noise.squares[0] / most**2 * noisy**2
        weight = max(1.0 - chance / max(slope**2, 1e-300), 0.0)
        varies = 1.0 + noisy + noise.squares[0] / most * noisy * (1.0 + noisy * first[i, i] / most)
        for a in range(k):
            missed[a] += (1.0 - weight * slope / varies) * asked[a, i] * score[i]
            for b in range(k):
                lost[a, b] += (1.0 - weight * slope**2 / varies) * asked[a, i] * asked[b, i]
    lost = in_units(lost, 1.0 / size)
    missed = missed * size + times(lost - noise.information, noise.mean)
    found, more = belief[0].copy(), belief[1].copy()
    for a in range(k):
        more[a] -= missed[a]
        for b in range(k):
            found[a, b] -= lost[a, b]
    return found, more


@row_compiled
def _left_of(first: Array, information: Array) -> Array:
    """What is left of what was known first, of which rows may have faded some, too: no more of it in a direction than
    there is."""
    root, _ = _root_of_inverse(first)
    size, turn = np.linalg.eigh(congruence(turned(root), information))
    along, left = product(first, product(root, turn)), np.zeros(first.shape)
    for i in range(len(size)):
        for a in range(len(size)):
            for b in range(len(size)):
                left[a, b] += min(size[i], 1.0) * along[a, i] * along[b, i]
    return left


@row_compiled
def _root_of_inverse(matrix: Array) -> tuple[Array, float]:
    """R of `R Rᵀ`, the inverse; and the smallest eigenvalue of the matrix, which is positive where it has one."""
    size, turn = np.linalg.eigh(matrix)
    for i in range(len(size)):
        for j in range(len(size)):
            turn[j, i] /= math.sqrt(max(size[i], 1e-9))
    return turn, size[0]
