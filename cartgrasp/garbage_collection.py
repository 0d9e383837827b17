"""The interpreter's collector of garbage beside a loop that must not wait."""

from __future__ import annotations

import gc


def freeze_live_objects() -> None:
    """Collects garbage now, and lets the collector look no more at what lives by then: with kernels that is 165,000
    objects, which take it 80 ms in whatever tick it goes through them. `gc.unfreeze()` undoes it."""
    gc.collect()
    gc.freeze()
