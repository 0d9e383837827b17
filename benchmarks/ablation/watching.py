"""Which constants a diagnosis would not have noticed at other values: one run in place of hundreds.

Each constant is replaced by a number that carries along what it would have been at each of its other values, through
all that is worked out from it. Wherever a comparison would have come out otherwise, or such a number is needed plain
(an index, an entry of an array, a rounded number) and would have been another, that value is `noticed`. Of all that
was not, the run is the same to the last digit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from .constants import Constant
from .patching import patched
from .rules import Without

Key = tuple[str, str]
"""Full name of a constant, and a move."""


class Watched(NDArrayOperatorsMixin):
    """A number, or an array, with what it would have been."""

    def __init__(self, value: Any, others: Mapping[Key, Any], noticed: set[Key]) -> None:
        self.value, self.others, self.noticed = value, others, noticed

    def under(self, key: Key) -> Any:
        return self.others.get(key, self.value)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return getattr(ufunc, method)(*map(plain, inputs), **options)
        value = ufunc(*(one.value if isinstance(one, Watched) else one for one in inputs))
        keys = {key for one in inputs if isinstance(one, Watched) for key in one.others} - self.noticed
        others = {key: ufunc(*(one.under(key) if isinstance(one, Watched) else one for one in inputs)) for key in keys}
        found = Watched(value, others, self.noticed)
        if np.asarray(value).dtype != bool:
            return found
        told = found.left()
        return told if np.ndim(told) else bool(told)

    def left(self, change: Callable[[Any], Any] = lambda value: value) -> Any:
        """Plain, after a change; noticed is what it would have been otherwise."""
        value = change(self.value)
        for key in set(self.others) - self.noticed:
            if not np.array_equal(change(self.others[key]), value):
                self.noticed.add(key)
        return value

    def __float__(self) -> float:
        return float(self.left())

    def __int__(self) -> int:
        return int(self.left(int))

    def __index__(self) -> int:
        return int(self.left())

    def __bool__(self) -> bool:
        return bool(self.left(bool))

    def __round__(self, digits: int | None = None) -> Any:
        return self.left(lambda value: _rounded(value, digits))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self.left(), dtype=dtype)

    def __format__(self, how: str) -> str:
        return format(self.left(), how)

    __hash__ = None  # type: ignore[assignment]


def _rounded(value: Any, digits: int | None) -> Any:
    """Of what is infinite, itself."""
    return round(float(value), digits) if np.isfinite(value) else float(value)


def plain(value: Any) -> Any:
    return value.left() if isinstance(value, Watched) else value


def noticed(diagnosed: Callable[[], Any], constants: Sequence[Constant], moves: Sequence[str]) -> tuple[Any, set[Key]]:
    """What a diagnosis says, and the values of constants that are numbers that might have changed it."""
    found: set[Key] = set()
    with ExitStack() as stack:
        for constant in constants:
            others = {(constant.full_name, move): constant.moved(move) for move in moves}
            known = {key: value for key, value in others.items() if value is not None}
            value = constant.value
            if isinstance(constant.off, Without):
                stack.enter_context(patched(constant, _followed(value, constant.off, set(known), found)))
                continue
            if not is_watched(constant):
                found |= set(known)
                continue
            stack.enter_context(patched(constant, Watched(value, known, found)))
        said = diagnosed()
    return said, found


def _followed(rule: Callable[..., Any], without: Without, keys: set[Key], found: set[Key]) -> Callable[..., Any]:
    """A rule that is noticed where it says something else than there would be without it."""

    def told(*arguments: Any) -> Any:
        said = rule(*arguments)
        if not _is_same(said, without(*arguments)):
            found.update(keys)
        return said

    return told


def _is_same(one: Any, other: Any) -> bool:
    """Models are the same where they are one; numbers, words and lists where they are equal."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    return one is other or (isinstance(one, bool | float | str | list) and one == other)


def is_watched(constant: Constant) -> bool:
    """Whether it is a number."""
    return isinstance(constant.value, int | float)
