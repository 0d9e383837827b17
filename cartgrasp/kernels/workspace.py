"""A cart in two blocks of memory: a call then hands over two arrays, not thirty. `pack` writes what does not change
with state and parameters; the rest is room for what is found on the way. `unpack` says what stands where."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .jit import Ints, compiled
from .situation import HIGH_ROWS
from .vocabulary import KINDS

N_WORKSPACE_SIZES = 7
N_EFFECT_INTS = 8
"""Whole numbers of an effect."""
N_PHI = 4
POSE_COLUMN, VELOCITY_COLUMN, PHI_COLUMN, MEMORY_COLUMN = 1, 4, 7, 11
"""Where the partials by each begin in a row of sums, behind the value; those by parameters end it."""
N_WRENCH = HIGH_ROWS[-1] + 1
"""Rows of the wrench's sums."""


class PackedEffect(NamedTuple):
    """An effect with a kernel: its name, where its parameters and memory begin and end, its constants, the root of how
    long its stiction keeps its value (1: told as it is), and whether it says how its memory moves."""

    name: str
    parameters: slice
    memory: slice
    constants: tuple[float, ...] = ()
    root: float = 1.0
    drives: bool = True


class Workspace(NamedTuple):
    """`effects` (e, 8): kind, first and last + 1 of the parameters, of the memory and of the `constants` (c,), and 1
    for those that say how their memory moves; the `roots` (e,) of how long their stiction keeps its value; `wheels`
    (n, 3) and `pivots` (k, 3) as in `KernelSituation`; `basis` (3, f).

    Then room for what is summed: `phi` (4,), `phi_by_parameters` (4, p), and rows (6, 11 + k + p) of the effects'
    `wrench` with what swings (`SWINGING_ROW`) and what acts high (`HIGH_ROWS`), and (k, 11 + k + p) of the memory's
    rate, one after the other in `sums`; and `loads` (n,), `carried` (n, 4) and `standing` (n,) of the wheels."""

    gravity: float
    smoothing_speed: float
    effects: Ints
    constants: Array
    roots: Array
    wheels: Array
    pivots: Array
    basis: Array
    sums: Array
    phi: Array
    phi_by_parameters: Array
    wrench: Array
    memory_rate: Array
    loads: Array
    carried: Array
    standing: Array


def sums_size(n_memory: int, n_parameters: int) -> int:
    return N_PHI + N_PHI * n_parameters + (N_WRENCH + n_memory) * (MEMORY_COLUMN + n_memory + n_parameters)


def pack(
    effects: Sequence[PackedEffect],
    wheels: tuple[Array, Array],
    basis: Array,
    sizes: tuple[int, int],
    common: tuple[float, float],
) -> tuple[Array, Ints]:
    """`wheels` and pivots; how much memory and how many parameters; gravity and smoothing speed."""
    (table, pivots), (nm, p), nf = wheels, sizes, basis.shape[1]
    n, constants = 3 + nf + nm, [number for effect in effects for number in effect.constants]
    ints = np.zeros(N_WORKSPACE_SIZES + N_EFFECT_INTS * len(effects), np.int64)
    ints[:N_WORKSPACE_SIZES] = len(effects), len(table), len(pivots), nf, nm, p, len(constants)
    end = 0
    for effect in effects:
        if effect.name not in KINDS:
            cure = "derive an effect in numpy from ForceEffect; one with a kernel needs a file in kernels/effects/"
            raise UsageError(f"effects: {effect.name} has no kernel; {cure}")
    for row, effect in zip(ints[N_WORKSPACE_SIZES:].reshape(-1, N_EFFECT_INTS), effects, strict=True):
        own, memory, begin, end = effect.parameters, effect.memory, end, end + len(effect.constants)
        drives = effect.drives and memory.stop > memory.start
        row[:] = KINDS[effect.name], own.start, own.stop, memory.start, memory.stop, begin, end, drives
    roots = [effect.root for effect in effects]
    given = np.concatenate([common, constants, roots, table.ravel(), pivots.ravel(), basis.ravel()])
    room = sums_size(nm, p) + 6 * len(table) + nf * nf + n * (4 + n + 3 + p)
    return np.concatenate([given, np.zeros(room)]), ints


@compiled
def unpack(floats: Array, ints: Ints) -> tuple[Workspace, Array]:
    """And room (nf² + n (7 + n + p),) for a rate with all partials, and for steps."""
    ne, nw, nv, nf, nm, p, nc = ints[0], ints[1], ints[2], ints[3], ints[4], ints[5], ints[6]
    width = MEMORY_COLUMN + nm + p
    constants, roots, at = floats[2 : 2 + nc], floats[2 + nc : 2 + nc + ne], 2 + nc + ne
    wheels, at = floats[at : at + 3 * nw].reshape((nw, 3)), at + 3 * nw
    pivots, at = floats[at : at + 3 * nv].reshape((nv, 3)), at + 3 * nv
    basis, at = floats[at : at + 3 * nf].reshape((3, nf)), at + 3 * nf
    first = at
    phi, at = floats[at : at + N_PHI], at + N_PHI
    phi_by_parameters, at = floats[at : at + N_PHI * p].reshape((N_PHI, p)), at + N_PHI * p
    wrench, at = floats[at : at + N_WRENCH * width].reshape((N_WRENCH, width)), at + N_WRENCH * width
    memory_rate, at = floats[at : at + nm * width].reshape((nm, width)), at + nm * width
    sums = floats[first:at]
    loads, at = floats[at : at + nw], at + nw
    carried, at = floats[at : at + 4 * nw].reshape((nw, 4)), at + 4 * nw
    standing, at = floats[at : at + nw], at + nw
    effects = ints[N_WORKSPACE_SIZES:].reshape((ne, N_EFFECT_INTS))
    w = Workspace(
        floats[0],
        floats[1],
        effects,
        constants,
        roots,
        wheels,
        pivots,
        basis,
        sums,
        phi,
        phi_by_parameters,
        wrench,
        memory_rate,
        loads,
        carried,
        standing,
    )
    return w, floats[at:]


@compiled
def copy(source: Array, into: Array) -> None:
    for i in range(len(into)):
        into[i] = source[i]
