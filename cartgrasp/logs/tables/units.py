"""Units that a table's columns come in, and how strangers write them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

POUND, KILOPOND, INCH, FOOT = 4.4482216152605, 9.80665, 0.0254, 0.3048
UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": INCH, "ft": FOOT},
    "angle": {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3, "gon": math.pi / 200, "turns": 2 * math.pi},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1 / 3.6, "in/s": INCH, "ft/s": FOOT, "mph": 0.44704},
    "rate": {"rad/s": 1.0, "deg/s": math.pi / 180, "mrad/s": 1e-3, "rpm": math.pi / 30},
    "force": {"N": 1.0, "kN": 1e3, "daN": 10.0, "mN": 1e-3, "lbf": POUND, "kgf": KILOPOND, "gf": KILOPOND * 1e-3},
    "moment": {
        "N·m": 1.0,
        "N·mm": 1e-3,
        "N·cm": 1e-2,
        "kN·m": 1e3,
        "daN·m": 10.0,
        "mN·m": 1e-3,
        "lbf·ft": POUND * FOOT,
        "lbf·in": POUND * INCH,
        "kgf·m": KILOPOND,
        "kgf·cm": KILOPOND * 1e-2,
    },
}
"""By dimension and name, what a number is multiplied by to be in SI units."""
UNIT_SYNONYMS: Mapping[str, Mapping[str, str]] = {
    "time": {"s": "sec secs second seconds", "ms": "msec millis milliseconds", "us": "usec micros", "ns": "nsec nanos"},
    "length": {
        "m": "meter meters metre metres",
        "mm": "millimeter millimeters",
        "in": "inch inches",
        "ft": "feet foot",
    },
    "angle": {"rad": "radian radians", "deg": "degree degrees", "turns": "turn rev revs"},
    "speed": {"m/s": "mps ms-1 ms m.s-1", "mm/s": "mmps mms", "cm/s": "cmps cms", "km/h": "kmh kph", "ft/s": "fps fts"},
    "rate": {"rad/s": "rads radps radsec", "deg/s": "degs dps degps degsec", "rpm": "1/min u/min"},
    "force": {"N": "newton newtons", "lbf": "lb lbs pound pounds", "kgf": "kp kg"},
    "moment": {
        "N·m": "newtonmeter nmeter",
        "lbf·ft": "lbft ftlb ftlbf ftlbs lbsft",
        "lbf·in": "lbin inlb inlbf lbsin inlbs",
        "kgf·m": "kpm kgm",
        "kgf·cm": "kpcm kgcm",
    },
}


def _bare(word: str) -> str:
    """Without what only separates, and as lower case: `N*m`, `N·m`, `Nm` and `N m` are one."""
    word = word.strip().lower().replace("°", "deg").replace("º", "deg").replace("µ", "u").replace("μ", "u")
    return re.sub(r"[\s·⋅*_-]+", "", word)


_BY_WORD: Mapping[str, Mapping[str, str]] = {
    dimension: {
        _bare(word): unit
        for unit in units
        for word in (unit, unit.replace("/", ""), *UNIT_SYNONYMS.get(dimension, {}).get(unit, "").split())
    }
    for dimension, units in UNITS.items()
}


def unit_of(word: str, dimension: str) -> str | None:
    """Its name here, if it is one of this dimension; `mN` is not `MN`."""
    if word.strip() == "MN":
        return None
    return _BY_WORD[dimension].get(_bare(word))
