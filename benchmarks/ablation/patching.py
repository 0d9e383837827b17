"""A constant at another value, in its module and wherever it was copied to, for a while."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from cartgrasp.errors import UsageError

from .constants import ROOT, Constant
from .sources import copies, worked_out_from


@contextmanager
def patched(constant: Constant, value: Any) -> Iterator[None]:
    """Refuses a constant from which modules work out something when they are loaded: that would stay as it was."""
    module = f"{ROOT}.{constant.module}"
    if worked_out_from(module, constant.attribute):
        raise UsageError(f"{constant.full_name}: modules work out others from it when they are loaded; move those")
    places = [(import_module(where), name) for where, name in copies(module, constant.attribute)]
    before = getattr(*places[0])
    now = {**before, constant.entry: value} if constant.entry else value
    for where, name in places:
        setattr(where, name, now)
    try:
        yield
    finally:
        for where, name in places:
            setattr(where, name, before)
