"""What the kernels of all effects do together: `situation.py` says which an effect may have, and a file in `effects/`
has those of the effect that is called as it is.

Numba compiles no call that is chosen at run time. So each of these functions is a chain: a link calls its own effect's
kernel if that is asked for, and the next link if not. Links stand where they are called (`forceinline`): what a kernel
is given takes longer to hand on than most kernels to work with.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

from cartgrasp.compiling import JIT_OPTIONS, inner

from . import effects
from .jit import compiled

KERNELS: dict[str, ModuleType] = {
    module.name: import_module(f"{effects.__name__}.{module.name}") for module in iter_modules(effects.__path__)
}
KINDS = {name: kind for kind, name in enumerate(sorted(KERNELS))}
STICTION_EFFECTS = frozenset(name for name, module in KERNELS.items() if hasattr(module, "stiction"))


@compiled
def _nothing(asked: int, at: Any, own: Any, out: Any) -> None:
    pass


@compiled
def _none(asked: int, at: Any, own: Any, out: Any) -> int:
    return 0


# A step of the dynamics takes 0.5 times as long with `forceinline` as with one function of branches, and 7 without.
def _link(kind: int, kernel: Callable[..., Any], following: Callable[..., Any]) -> Callable[..., Any]:
    def call(asked: int, at: Any, own: Any, out: Any) -> Any:
        if asked == kind:
            return kernel(at, own, out)
        return following(asked, at, own, out)

    return inner(call, {**JIT_OPTIONS, "forceinline": True})


def _chain(name: str, end: Callable[..., Any]) -> Callable[..., Any]:
    """The effects' kernels of a name, as one that is told first which of them is asked for."""
    for effect, module in KERNELS.items():
        if hasattr(module, name):
            end = _link(KINDS[effect], getattr(module, name), end)
    return end


add_phi_change = _chain("phi_change", _nothing)
add_wrench = _chain("wrench", _nothing)
add_memory_rate = _chain("memory_rate", _nothing)
add_stiction = _chain("stiction", _none)
settle = _chain("settled", _nothing)
