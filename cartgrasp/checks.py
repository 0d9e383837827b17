"""Checks where values are born: kinds, numbers, angles and names, each refused in one sentence with the cure."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import Any

import numpy as np

from .errors import UsageError
from .frames import Array

MAX_ANGLE = 4 * math.pi
"""rad: two turns. What is more was meant in degrees."""
MAX_DISTANCE = 50.0
"""m from {b}: what is farther is no part of a cart, nor where a hand holds it."""
MAX_NUMBER = 1e12
"""The largest finite number that is accepted: squares of larger ones mean nothing."""
MAX_FLOAT = sys.float_info.max
MAX_SHOWN_CHARS = 60


def shown(value: Any) -> str:
    """The `repr` of a value in one short line."""
    words = " ".join(repr(value).split())
    return words if len(words) <= MAX_SHOWN_CHARS else f"{words[: MAX_SHOWN_CHARS - 2]} …"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """`; did you mean …?`, or the list of what is known."""
    known = list(known)
    close = [one for one in known if one.lower() == word.lower()] or difflib.get_close_matches(word, known, n=1)
    return f"; did you mean {close[0]}?" if close else f"; known are {', '.join(known) or 'none'}"


def check_kind(what: str, value: Any, kind: type | tuple[type, ...], cure: str) -> None:
    """Refuses a value of another kind, which the first of several names; `cure` says what to write."""
    if not isinstance(value, kind):
        name = (kind[0] if isinstance(kind, tuple) else kind).__name__
        raise UsageError(f"{what}: {shown(value)} is no {name}; {cure}")


def check_known(what: str, words: Iterable[str], known: Iterable[str]) -> None:
    """Refuses words that aren't known."""
    known = list(known)
    for word in words:
        if word not in known:
            raise UsageError(f"{what}: there is no {word!r}{did_you_mean(str(word), known)}")


def listed(what: str, values: Any, kind: type, cure: str) -> tuple[Any, ...]:
    """The values as a tuple, checked to be a list of one `kind`."""
    if isinstance(values, str | kind) or not isinstance(values, Iterable):
        raise UsageError(f"{what}: {shown(values)} is no list; {cure}")
    found = tuple(values)
    for value in found:
        check_kind(what, value, kind, cure)
    return found


def number(what: str, value: Any, low: float = -math.inf, high: float = math.inf, cure: str = "") -> float:
    """The value as a number from `low` to `high`; text, truth values and NaN are no numbers."""
    try:
        found = math.nan if isinstance(value, str | bytes | bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not low <= found <= high:
        raise UsageError(f"{what}: {shown(value)} is not {_range(low, high)}{cure and f'; {cure}'}")
    return found


def positive(what: str, value: Any, high: float, cure: str) -> float:
    """Above 0, up to `high`."""
    found = number(what, value, 0.0, high, cure)
    if found == 0.0:
        raise UsageError(f"{what}: 0 is not > 0; {cure}")
    return found


def numbers(what: str, values: Any, form: str, low: float = -math.inf, high: float = math.inf) -> tuple[float, ...]:
    """The numbers of `values`, checked to be as many as `form` names in brackets: `(x, y, z) in {b}`. Sets are refused,
    as they have no order, and iterators, as they can be read only once."""
    try:
        if isinstance(values, Set | Mapping | Iterator):
            raise TypeError
        found = tuple([float(value) for value in values])
        is_text = isinstance(values, str | bytes) or any(isinstance(value, str | bytes | bool) for value in values)
    except (TypeError, ValueError, OverflowError):
        found, is_text = (), True
    n = form.partition(")")[0].count(",") + 1
    if is_text or len(found) != n:
        many = "" if is_text else f"; {n} numbers are needed, {len(found)} given"
        raise UsageError(f"{what}: {shown(values)} is not {form}{many}")
    for value in found:
        if not low <= value <= high:
            raise UsageError(f"{what}: {shown(values)} is not {form}: {value:g} is not {_range(low, high)}")
    return found


def rows(what: str, values: Any, columns: Sequence[str], count: int | None = None) -> Array:
    """Numbers (count, columns) as floats, NaN where missing; (n,) of one column, and as many rows as there are where
    `count` isn't given."""
    try:
        found = np.asarray(values)
    except (TypeError, ValueError):
        found = np.asarray(None)
    form = ", ".join(columns)
    if found.dtype.kind not in "fiu":
        said = f"an array of {values.dtype}" if isinstance(values, np.ndarray) else shown(values)
        raise UsageError(f"{what}: {said} is no array of numbers; give {form} of each row, NaN where missing")
    width = (len(columns),) if len(columns) > 1 else ()
    if found.ndim != 1 + len(width) or found.shape[1:] != width or count not in (None, len(found)):
        wanted = ", ".join(map(str, ("n" if count is None else count, *width)))
        one = f"; one for all rows is np.tile(values, ({count or 'n'}, 1))" if width and found.shape == width else ""
        comma = "" if width else ","
        raise UsageError(f"{what}: shape {found.shape} instead of ({wanted}{comma}): {form} of each row{one}")
    return np.asarray(found, dtype=float)


def angle(what: str, value: Any) -> float:
    """rad."""
    found = number(what, value, -math.inf, math.inf)
    if not abs(found) <= MAX_ANGLE:
        cure = f"; {found:g} degrees are {math.radians(found):.4g} rad" if math.isfinite(found) else ""
        raise UsageError(f"{what}: {found:g} rad is more than two turns, or not finite; angles are in rad{cure}")
    return found


def pose(what: str, values: Any) -> tuple[float, float, float]:
    """(x, y, theta), finite."""
    x, y, theta = numbers(what, values, "(x, y, theta) in m and rad", -MAX_NUMBER, MAX_NUMBER)
    return x, y, angle(f"{what}: theta", theta)


def brief(name: str, *parts: str) -> str:
    """A `repr` of a few words."""
    return f"{name}({', '.join(part for part in parts if part)})"


def digits(values: float | Sequence[float]) -> str:
    """Numbers to four digits: `0.25`, `(1, 0, 0.5236)`."""
    if isinstance(values, int | float):
        return f"{values:.4g}"
    return f"({', '.join(f'{value:.4g}' for value in values)})"


def unrounded(value: float, size: float) -> float:
    """The value to be printed: nought where it is only what rounding left beside numbers of a size."""
    return 0.0 if abs(value) < 1e-9 * size else value


def _range(low: float, high: float) -> str:
    what = "a finite number" if high == MAX_FLOAT else "a number"
    high = math.inf if high == MAX_FLOAT else high
    if low == -math.inf and high == math.inf:
        return what
    if high == math.inf:
        return f"{what} >= {low:g}"
    return f"{what} from {low:g} to {high:g}" if low > -math.inf else f"{what} <= {high:g}"
