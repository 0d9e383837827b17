"""How functions here are compiled: once, and again when any of their sources has changed (numba's own cache looks at
the file of the caller alone)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

SOURCES = ("body.py", "compiling.py", "driver.py", "wheels.py", "world.py")


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    return numba.njit(cache=True)(function)


def forget_older(folder: Path) -> None:
    """Removes what was compiled before the newest source was written."""
    newest = max((folder / name).stat().st_mtime for name in SOURCES)
    for path in (folder / "__pycache__").glob("*.nb?"):
        if path.is_file() and path.stat().st_mtime < newest:
            path.unlink(missing_ok=True)


forget_older(Path(__file__).parent)
