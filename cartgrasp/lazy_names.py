"""Packages whose names are imported when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_names(names: dict[str, Any], homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of the package whose globals are `names`; `homes` says which modules of it hold which
    names, these parted by spaces. `dir` shows what is public."""
    package = names["__name__"]

    def get(name: str) -> Any:
        for home, held in homes.items():
            if name in held.split():
                value = names[name] = getattr(import_module(f".{home}", package), name)
                return value
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get, lambda: sorted({*names["__all__"], *(name for name in names if name.startswith("__"))})
