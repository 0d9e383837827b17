"""What a column's name says: which quantity, of which part, in which unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..table_map import DIMENSIONS
from ..units import UNITS, unit_of

TIME = frozenset(
    ["t", "time", "timestamp", "stamp", "zeit", "temps", "elapsed", "clock", "tiempo", "seconds", "secs", "millis"]
)
POSITION = frozenset(["p", "pos", "position", "location", "coord", "translation", "weg", "ort", "posizione"])
SPEED = frozenset(["v", "vel", "velocity", "speed", "geschwindigkeit", "vitesse"])
RATE = frozenset(["omega", "w", "gyro", "yawrate", "thetadot", "turnrate", "drehrate", "gierrate"])
HEADING = frozenset(
    [
        "theta",
        "yaw",
        "heading",
        "psi",
        "hdg",
        "orientation",
        "angle",
        "winkel",
        "gier",
        "azimuth",
        "th",
        "ang",
        "rotation",
    ]
)
FORCE = frozenset(["f", "force", "kraft"])
MOMENT = frozenset(["m", "t", "mom", "moment", "torque", "tau", "trq", "drehmoment", "couple"])
OTHERS = frozenset(
    [
        "a",
        "acc",
        "accel",
        "acceleration",
        "cmd",
        "command",
        "ref",
        "reference",
        "des",
        "desired",
        "target",
        "set",
        "setpoint",
        "goal",
        "sp",
        "soll",
        "std",
        "cov",
        "var",
        "sigma",
        "roll",
        "pitch",
        "motor",
        "battery",
        "joint",
        "temp",
        "temperature",
        "current",
        "voltage",
        "wheel",
        "encoder",
        "err",
        "error",
        "jerk",
        "snap",
        "quat",
        "q",
    ]
)
"""Words of what is no part of a run."""
CONTACT = frozenset(["contact", "grip", "grasp", "hand", "tool", "point", "kontakt"])
FILLERS = frozenset(
    [
        "ft",
        "wrench",
        "sensor",
        "measured",
        "meas",
        "cart",
        "base",
        "body",
        "robot",
        "pose",
        "odom",
        "odometry",
        "world",
        "map",
        "link",
        "linear",
        "lin",
        "data",
        "filtered",
        "loadcell",
        "cell",
        "in",
        "of",
        "the",
        "at",
        "mocap",
        "local",
        "global",
        "frame",
        "state",
        "run",
        "rel",
        "abs",
        "raw",
        "plane",
        "horizontal",
        "ee",
        "kart",
        "wagen",
    ]
)
RATE_OF = frozenset(["rate", "dot", "vel", "velocity", "speed"])
AXES = ("x", "y", "z")
IN_CART = frozenset(["body", "cart", "local", "base"])


@dataclass(frozen=True)
class Meaning:
    """`role` is a column of a run log without its arm; `group` are the words that are left; `odd` is a unit that is
    none of the role's dimension."""

    role: str
    unit: str | None = None
    group: str = ""
    odd: str = ""
    in_cart: bool = False


def meaning_of(name: str, unit: str = "") -> Meaning | None:
    """Of a column by its name, and by the unit that stands below it, if any."""
    rest, inside = re.subn(r"[\[({<]([^\])}>]*)[\])}>]", " ", name)[0], re.findall(r"[\[({<]([^\])}>]*)[\])}>]", name)
    said = [word for word in (*inside, unit) if word.strip() and _is_unit(word)]
    words = _words(" ".join([rest, *(word for word in inside if not _is_unit(word))]))
    if not said:
        for count in (3, 2, 1):
            for word in _joined(words[-count:]) if len(words) > count else ():
                found = _role(words[:-count])
                if found and (known := unit_of(word, DIMENSIONS[found.role])):
                    return Meaning(found.role, known, found.group, "", found.in_cart)
    found = _role(words)
    if found is None:
        lone = unit_of(words[0], "time") if len(words) == 1 and words[0] not in ("s", "m") else None
        return Meaning("t", lone) if lone else None
    if not said:
        implied = {"millis": "ms", "seconds": "s", "secs": "s"}.get(words[-1]) if found.role == "t" else None
        return Meaning(found.role, implied, found.group, "", found.in_cart)
    known = unit_of(said[0], DIMENSIONS[found.role])
    return Meaning(found.role, known, found.group, "" if known else said[0], found.in_cart)


def _is_unit(word: str) -> bool:
    return any(unit_of(word, dimension) for dimension in UNITS)


def _joined(words: Sequence[str]) -> list[str]:
    """As a unit may be written over several words."""
    kept = [word for word in words if word != "per"]
    return ["".join(words), "/".join(kept)]


def _words(text: str) -> list[str]:
    """In lower case: `posX_mm` is pos, x, mm; `FxLeft` is fx, left."""
    found = []
    for piece in re.split(r"[^\w°µ]+|_", text):
        if piece and (_is_unit(piece) or len(piece) <= 2):
            found.append(piece.lower())
        else:
            found += [w.lower() for w in re.findall(r"[A-ZÄÖÜ]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöüß]+|\d+|°", piece)]
    return found


def _role(words: Sequence[str]) -> Meaning | None:
    """The quantity that the words name, and what else they say."""
    left = [word for word in words if not word.isdigit()]
    if not left or OTHERS & set(left):
        return None
    in_cart = bool(IN_CART & set(left))
    number = "".join(word for word in words if word.isdigit())
    for role, used in _readings(left):
        group = [word for word in left if word not in used and word not in FILLERS]
        is_of_arm = (role[0] in "ft" and role != "t" and role != "theta") or role[0] == "p"
        rest = [word for word in group if word not in CONTACT] if role[0] == "p" else group
        return Meaning(role, None, "_".join([*rest, *([number] if number and is_of_arm else [])]), "", in_cart)
    return None


def _readings(words: Sequence[str]) -> list[tuple[str, set[str]]]:
    """The roles that fit, the likeliest first, each with the words that say so."""
    own = set(words)
    axis = next((word for word in words if word in AXES), "")
    found: list[tuple[str, set[str]]] = []
    for word in words:
        head, tail = word[:-1], word[-1:]
        if len(word) > 1 and tail in AXES and (role := _of_kind(head, tail, own)):
            found.append((role, {word, *(own & (POSITION | CONTACT))}))
    is_rate = bool(own & RATE) or bool(own & HEADING and own & RATE_OF) or bool(own & {"angular"} and own & SPEED)
    if is_rate and axis in ("", "z") and not found:
        found.append(("omega", own & (RATE | HEADING | RATE_OF | SPEED | {"angular", "z"})))
    if found:
        return found
    if own & {"xdot", "ydot", "dx", "dy"} or (axis in ("x", "y") and "dot" in own):
        axis = axis or next(iter(own & {"xdot", "ydot", "dx", "dy"})).strip("dot")
        return [(f"v{axis}", own & {"xdot", "ydot", "dx", "dy", "dot", axis})]
    for kind in words:
        if axis and (role := _of_kind(kind, axis, own)):
            return [(role, {kind, axis})]
    if own & HEADING and axis in ("", "z"):
        return [("theta", own & (HEADING | {"z"}))]
    if own & TIME:
        return [("t", own & TIME)]
    if own & FORCE or own & {"torque", "moment", "drehmoment", "trq"}:
        return []
    if axis in AXES and own & CONTACT:
        return [(f"p{axis}", {axis, *(own & CONTACT)})]
    if axis in ("x", "y") and not own & SPEED:
        return [(axis, {axis})]
    if own & (POSITION - {"p"}) and not axis:
        return [("x", own & POSITION)]
    return []


def _of_kind(kind: str, axis: str, own: set[str]) -> str | None:
    """A word for a quantity, with an axis."""
    if kind in FORCE:
        return f"f{axis}"
    if kind in MOMENT and not (kind == "t" and own & TIME - {"t"}):
        return f"t{axis}"
    if kind in SPEED:
        if "angular" in own or "rot" in own:
            return "omega" if axis == "z" else None
        return f"v{axis}" if axis != "z" else None
    if kind in RATE:
        return "omega" if axis == "z" else None
    if kind in POSITION:
        if kind == "p" or own & CONTACT:
            return f"p{axis}"
        return axis if axis != "z" else None
    return None
