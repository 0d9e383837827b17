"""`CompiledDynamics`: a cart's kernels behind calls that broadcast over leading axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from .errors import UsageError
from .frames import Array
from .kernels import entries
from .kernels.jit import Ints
from .kernels.situation import SWINGING_ROW, Parts
from .kernels.vocabulary import STICTION_EFFECTS
from .kernels.workspace import (
    MEMORY_COLUMN,
    N_PHI,
    N_WRENCH,
    PHI_COLUMN,
    POSE_COLUMN,
    VELOCITY_COLUMN,
    PackedEffect,
    pack,
    sums_size,
)
from .wheels import GRAVITY, WheelSet

ZERO_STEPS = np.zeros(2)
MAX_STEP_STIFFNESS = 1.5
"""Largest product of step time and stiffness at which `advanced` is run; in theory it is stable up to 2.78."""


# Many methods: one for each compiled entry, which lays out its arguments as the kernel takes them.
class CompiledDynamics:
    """Dynamics of one structure: effects, wheels, the basis of free velocities (3, f), `sizes` (how much memory, how
    many parameters). `floats` and `ints` are the workspace that kernels unpack; `n_sums` and `most_stictions` say how
    long a row of `entries.effects` is."""

    floats: Array
    ints: Ints

    def __init__(
        self,
        effects: Sequence[PackedEffect],
        wheels: WheelSet,
        basis_b: Array,
        sizes: tuple[int, int],
        smoothing_speed: float,
    ) -> None:
        (self.n_memory, self.n_parameters), self.n_free = sizes, basis_b.shape[1]
        self.n_state = 3 + self.n_free + self.n_memory
        table = np.column_stack([wheels.positions, wheels.is_caster])
        self.floats, self.ints = pack(effects, (table, wheels.pivots), basis_b, sizes, (GRAVITY, smoothing_speed))
        self._n_wheels, self.n_sums = len(table), sums_size(self.n_memory, self.n_parameters)
        sticking = sum(effect.name in STICTION_EFFECTS for effect in effects)
        self.most_stictions = sticking * (2 * len(table) + 2) + (self.n_memory if sticking else 0)

    def warm_up(self) -> None:
        """Loads the kernels, or compiles them. They are the same for all carts."""
        point = np.zeros(self.n_state), 0.0, np.ones(self.n_parameters)
        self.rate(point, np.zeros(3))
        self.inverse(point, np.zeros(self.n_free))
        self.sums(point)
        self.floor(point, np.ones(1))
        self.memories((point[0][None], np.zeros(1), point[2][None]))

    def rates(self, point: StatePoint, wrench_b: Array, foreign: Array | None = None) -> tuple[Array, ...]:
        """Rate (..., n) and its partials by state, wrench and parameters."""
        n, p = self.n_state, self.n_parameters
        found = self._ask(
            entries.rates, self._given(point, _wrench_and_steps(wrench_b, ZERO_STEPS), foreign), n * (1 + n + 3 + p)
        )
        return split(found, ((n,), (n, n), (n, 3), (n, p)))

    def rate(self, point: StatePoint, wrench_b: Array, foreign: Array | None = None) -> Array:
        return self._ask(
            entries.rates, self._given(point, _wrench_and_steps(wrench_b, ZERO_STEPS), foreign), self.n_state
        )

    def advanced(self, point: StatePoint, wrench_b: Array, step: Any, n_steps: Any) -> Array:
        """The state (..., n) after classical fourth-order steps (...) under a wrench that is held."""
        return next(self.driven(point, wrench_b[None], step, n_steps))

    def driven(self, point: StatePoint, wrenches_b: Array, step: Any, n_steps: Any) -> Iterator[Array]:
        """The state (..., n) after each of wrenches (k, ..., 3), which are held as in `advanced`: one array, which may
        be changed on the way."""
        given = self._given(point, _wrench_and_steps(wrenches_b[0], np.stack([step, n_steps], axis=-1)))
        first = self.n_state + 1 + self.n_parameters
        for wrench_b in wrenches_b:
            given[..., first : first + 3] = wrench_b
            self._ask(entries.rates, given, 0)
            yield given[..., : self.n_state]

    def inverse(self, point: StatePoint, acceleration: Array, foreign: Array | None = None) -> tuple[Array, ...]:
        """What `kernels.dynamics.Inverse` holds, with leading axes."""
        f, k, n, p = self.n_free, self.n_memory, self.n_state, self.n_parameters
        return self._inverse(point, acceleration, foreign, ((f,), (f, f), (f, p), (f, n), (k,), (k, n), (k, p)))

    def inverse_by_parameters(
        self, point: StatePoint, acceleration: Array, foreign: Array | None = None
    ) -> tuple[Array, ...]:
        """The reduced wrench (..., f), and its partials by acceleration (..., f, f) and parameters (..., f, p)."""
        f, p = self.n_free, self.n_parameters
        return self._inverse(point, acceleration, foreign, ((f,), (f, f), (f, p)))

    def _inverse(
        self, point: StatePoint, acceleration: Array, foreign: Array | None, shapes: Sequence[tuple[int, ...]]
    ) -> tuple[Array, ...]:
        if acceleration.shape[-1] != self.n_free:
            raise UsageError(
                f"model: acceleration has {acceleration.shape[-1]} numbers, but this cart's has {self.n_free}"
            )
        size = sum(math.prod(shape) for shape in shapes)
        return split(self._ask(entries.inverses, self._given(point, (acceleration,), foreign), size), shapes)

    def memories(self, point: StatePoint) -> Array:
        """The memory (n, k) along instants (n,), from the first one's on."""
        return self._ask(entries.memories, self._given(point), self.n_memory)

    def sums(self, point: StatePoint, foreign: Array | None = None) -> Array:
        """The sums (..., size) of what effects add; `parts` says what stands where."""
        found, _ = self._effects(point, foreign)
        return found[..., : self.n_sums]

    def floor(
        self, point: StatePoint, com_height: Array, foreign: Array | None = None, with_partials: bool = False
    ) -> Array:
        """Rows (..., 1, n_wheels + 1, 7) as `kernels.floor.react` has them; with their partials by the parameters
        behind them, (..., 1 + p, n_wheels + 1, 7)."""
        count = 1 + self.n_parameters if with_partials else 1
        found = self._ask(entries.floors, self._given(point, (com_height,), foreign), count * 7 * (self._n_wheels + 1))
        return found.reshape(*found.shape[:-1], count, -1, 7)

    def parts(self, sums: Array) -> tuple[Array, Array, Parts, Parts, Parts]:
        """Views of sums: phi, its partials by the parameters, the wrench, the rate of the memory, and, as one row, the
        mass that swings."""
        p, k = self.n_parameters, self.n_memory
        width = MEMORY_COLUMN + k + p
        phi, by_parameters, wrench, rate = split(sums, ((N_PHI,), (N_PHI, p), (N_WRENCH, width), (k, width)))
        felt, swung = wrench[..., :SWINGING_ROW, :], wrench[..., SWINGING_ROW : SWINGING_ROW + 1, :]
        return phi, by_parameters, _of_rows(felt, k), _of_rows(rate, k), _of_rows(swung, k)

    def values(self, sums: Array) -> tuple[Array, Array]:
        """Views of sums: the wrench (..., 3) and the mass that swings (...)."""
        width, first = MEMORY_COLUMN + self.n_memory + self.n_parameters, N_PHI * (1 + self.n_parameters)
        values = sums[..., first : first + N_WRENCH * width : width]
        return values[..., :SWINGING_ROW], values[..., SWINGING_ROW]

    def settled(self, point: StatePoint) -> Array:
        """The memory (..., k) when it has come to rest."""
        found, _ = self._effects(point)
        return found[..., self.n_sums : self.n_sums + self.n_memory]

    def stiction(self, point: StatePoint) -> Array:
        """Wrenches (..., 3, k)."""
        if not self.most_stictions:
            return np.zeros((*np.broadcast_shapes(*(part.shape[:-1] for part in point[::2])), 3, 0))
        found, n = self._effects(point)
        first = self.n_sums + self.n_memory
        columns = found[..., first : first + 3 * n].reshape(*found.shape[:-1], n, 3)
        return np.swapaxes(columns, -1, -2)

    def _effects(self, point: StatePoint, foreign: Array | None = None) -> tuple[Array, int]:
        given = self._given(point, foreign=foreign)
        found = np.empty((*given.shape[:-1], self.n_sums + self.n_memory + 3 * self.most_stictions))
        return found, entries.effects(self.floats, self.ints, _rows(given), _rows(found))

    def _given(self, point: StatePoint, rest: tuple[Array, ...] = (), foreign: Array | None = None) -> Array:
        """Rows as kernels expect them. They look at no bounds, so this does."""
        state, time, parameters = point
        if state.shape[-1] != self.n_state or parameters.shape[-1] != self.n_parameters:
            raise UsageError(
                f"model: state has {state.shape[-1]} numbers and parameters {parameters.shape[-1]}, but this cart's "
                f"have {self.n_state} and {self.n_parameters}"
            )
        parts = [state, np.asarray(time, dtype=float)[..., None], parameters, *rest]
        if foreign is not None:
            parts.append(foreign)
        if max(part.ndim for part in parts) == 1:
            return np.concatenate(parts)
        lead = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        given = np.empty((*lead, sum(part.shape[-1] for part in parts)))
        at = 0
        for part in parts:
            given[..., at : at + part.shape[-1]] = part
            at += part.shape[-1]
        return given

    def _ask(self, entry: Callable[[Array, Ints, Array, Array], None], given: Array, size: int) -> Array:
        found = np.empty((*given.shape[:-1], size))
        entry(self.floats, self.ints, _rows(given), _rows(found))
        return found


StatePoint = tuple[Array, Any, Array]
"""State (..., n), time (...), parameters (..., p)."""


def _wrench_and_steps(wrench_b: Array, steps: Array) -> tuple[Array, Array]:
    """A wrench (..., 3) in {b}, with steps."""
    if wrench_b.shape[-1] != 3:
        raise UsageError(f"model: wrench has {wrench_b.shape[-1]} numbers, but needs 3")
    return wrench_b, steps


def split(found: Array, shapes: Sequence[tuple[int, ...]]) -> tuple[Array, ...]:
    """Parts that stand one after the other on the last axis."""
    parts, at, lead = [], 0, found.shape[:-1]
    for shape in shapes:
        size = shape[0] if len(shape) == 1 else shape[0] * shape[1]
        parts.append(found[..., at : at + size].reshape(lead + shape))
        at += size
    return tuple(parts)


def _rows(stack: Array) -> Array:
    return stack.reshape(math.prod(stack.shape[:-1]), stack.shape[-1])


def _of_rows(rows: Array, n_memory: int) -> Parts:
    """Views of rows (..., n, 11 + k + p) of sums."""
    ends = POSE_COLUMN, VELOCITY_COLUMN, PHI_COLUMN, MEMORY_COLUMN, MEMORY_COLUMN + n_memory
    by_pose, by_velocity, by_phi, by_memory = (rows[..., a:b] for a, b in pairwise(ends))
    return Parts(rows[..., 0], by_pose, by_velocity, by_phi, by_memory, rows[..., ends[-1] :])
