"""Effects whose physics is a kernel (`cartgrasp/kernels/`): the methods here loop it over leading axes."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError
from ..frames import Array
from ..inertia import PHI_NAMES
from ..wheels import WheelSet
from .effect import SMOOTHING_SPEED, Contribution, ForceEffect, InertiaEffect, Situation

if TYPE_CHECKING:
    from ..compiled_dynamics import CompiledDynamics

N_PHI = len(PHI_NAMES)
NO_WHEELS = WheelSet.of((), rolls_along_x=True)


class CompiledForce(ForceEffect):
    """A force effect with a kernel under its name."""

    @property
    def constants(self) -> tuple[float, ...]:
        """The numbers of the kernel that are no parameters."""
        return ()

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        return self._contribution(situation, (memory, parameters), 0)

    def memory_rate(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        return self._contribution(situation, (memory, parameters), 1)

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array | None:
        dynamics, point = self._alone(situation, memory, parameters)
        columns = dynamics.stiction(point)
        return columns if columns.shape[-1] else None

    def settled_memory(self, situation: Situation, memory: Array) -> Array:
        if not memory.shape[-1]:
            return memory
        dynamics, point = self._alone(situation, memory, self.values)
        return dynamics.settled(point)

    def _contribution(self, situation: Situation, own: tuple[Array, Array], which: int) -> Contribution:
        """The contribution to the wrench (`which` = 0), or to the memory's rate (1)."""
        dynamics, point = self._alone(situation, *own)
        _, _, wrench, rate, _ = dynamics.parts(dynamics.sums(point))
        parts = (wrench, rate)[which]
        return Contribution(**parts._replace(by_parameters=parts.by_parameters[..., N_PHI:])._asdict())

    def _alone(self, situation: Situation, memory: Array, parameters: Array) -> tuple[CompiledDynamics, Any]:
        """A cart on casters with this effect only, and the situation as a point of its."""
        sizes = memory.shape[-1], parameters.shape[-1]
        wanted = len(self.memory_names(situation.wheels)), len(self.parameters)
        if sizes != wanted:  # kernels look at no bounds
            raise UsageError(f"{self.key}: memory and parameters have {sizes} numbers, but {wanted} are needed")
        state = _joined(situation.pose_sb, situation.velocity_b, memory)
        point = state, situation.time, _joined(situation.phi, parameters)
        return _dynamics(self.name, self.constants, situation.wheels, sizes), point


class WheelForce(CompiledForce):
    """What each wheel does, along its heading or across. A caster's heading follows from how its pivot moves
    (`kernels/casters.py`). It is one memory, whichever effects look at it; at first it is taken to be ahead."""

    drives_memory = False

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        return ()

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        count = len(wheels.pivots) if wheels.lists_casters else 0
        return tuple(f"caster{i + 1}.heading" for i in range(count))


class CompiledInertia(InertiaEffect):
    """An inertia effect with a kernel under its name."""

    def phi_change(self, time: Any, parameters: Array) -> Contribution:
        if parameters.shape[-1] != len(self.parameters):
            raise UsageError(f"{self.key}: {parameters.shape[-1]} parameters, but {len(self.parameters)} are needed")
        dynamics = _dynamics(self.name, (), NO_WHEELS, (0, parameters.shape[-1]))
        point = np.zeros(6), time, _joined(np.zeros(N_PHI), parameters)
        value, by_parameters, *_ = dynamics.parts(dynamics.sums(point))
        return Contribution(value, by_parameters=by_parameters[..., N_PHI:])


@lru_cache(maxsize=256)
def _dynamics(name: str, constants: tuple[float, ...], wheels: WheelSet, sizes: tuple[int, int]) -> CompiledDynamics:
    from ..compiled_dynamics import CompiledDynamics
    from ..kernels.workspace import PackedEffect

    n_memory, n_parameters = sizes
    effect = PackedEffect(name, slice(N_PHI, N_PHI + n_parameters), slice(0, n_memory), constants)
    return CompiledDynamics([effect], wheels, np.eye(3), (n_memory, N_PHI + n_parameters), SMOOTHING_SPEED)


def _joined(*parts: Array) -> Array:
    lead = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*lead, part.shape[-1])) for part in parts], axis=-1)
