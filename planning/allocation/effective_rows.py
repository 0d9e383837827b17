"""The cart's effective rows in words."""

from __future__ import annotations

from cartgrasp.frames import Array

PLANAR_NAMES = ("fx", "fy", "tau")


def in_words(direction: Array) -> str:
    """A combination of (fx, fy, tau), as `fx` or `tau - 0.3 fy`."""
    parts = sorted(zip(direction, PLANAR_NAMES, strict=True), key=lambda part: part[1] != "tau" or part[0] < 0)
    text = ""
    for factor, name in parts:
        if abs(factor) > 1e-9:
            sign = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += sign + ("" if abs(abs(factor) - 1) < 1e-9 else f"{abs(factor):.4g} ") + name
    return text or "0"
