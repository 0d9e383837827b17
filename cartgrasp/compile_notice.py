"""What is said while kernels are compiled: that takes seconds each, once on a machine."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

KernelListener = Callable[[str], None]
ADVICE = (
    "compiling kernels, once on this machine, which takes a minute or two; `cartgrasp warm-up` does it ahead, as does "
    "warm_up() of planners and filters"
)


class CompileWarning:
    """Where nobody else tells: a warning in the log, once a process."""

    def __init__(self) -> None:
        self.was_given = False

    def __call__(self, kernel: str) -> None:
        if not self.was_given:
            self.was_given = True
            logging.getLogger("cartgrasp").warning(ADVICE)


_listeners: list[KernelListener] = [CompileWarning()]


def compiling(kernel: str) -> None:
    """Before one that Python calls is compiled."""
    _listeners[-1](kernel)


@contextmanager
def kernel_listener(tell: KernelListener) -> Iterator[None]:
    """Within it, each kernel that is compiled is told by name."""
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)
