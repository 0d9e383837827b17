"""What a column's name says: which quantity, of which part, in which unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..table_map import DIMENSIONS
from ..units import UNITS, unit_of

VOCABULARY: Mapping[str, frozenset[str]] = {
    kind: frozenset(words.split())
    for kind, words in {
        "time": "t time timestamp stamp zeit temps tiempo elapsed clock seconds secs sec millis",
        "position": "p pos position location coord translation weg ort posizione",
        "speed": "v vel velocity speed geschwindigkeit vitesse",
        "rate": "omega w gyro yawrate thetadot turnrate drehrate gierrate",
        "heading": "theta yaw heading psi phi hdg angle winkel gier gierwinkel azimuth th ang rotation rot",
        "force": "f force kraft effort fuerza forza kracht loadcell load push",
        "moment": "m t mom moment torque tau tq trq drehmoment couple",
        "quaternion": "q quat quaternion orientation",
        "contact": "contact grip grasp hand tool point kontakt",
        # words of what is no part of a run
        "others": "a acc accel acceleration cmd command ref reference des desired target set setpoint goal sp soll std "
        "cov covariance var sigma roll pitch motor battery joint temp temperature current voltage wheel encoder err "
        "error jerk snap d delta diff seq",
        # words that tell nothing apart
        "filler": "ft wrench sensor measured meas cart base body robot pose odom odometry world map link linear lin "
        "data filtered cell in of the at mocap local global frame state run rel abs raw plane horizontal ee kart wagen "
        "field header twist ros since start",
    }.items()
}
RATE_WORDS = frozenset(("rate", "dot", "vel", "velocity", "speed"))
DERIVATIVE_NAMES = frozenset(("xdot", "ydot", "dx", "dy"))
AXIS_WORDS = {
    **dict.fromkeys(["fwd", "forward", "forwards", "long", "longitudinal", "ahead", "vorwaerts", "laengs"], "x"),
    **dict.fromkeys(["lat", "lateral", "side", "sideways", "across", "quer", "seitlich"], "y"),
    **dict.fromkeys(["vert", "vertical", "up"], "z"),
}
"""Words for directions of forces."""
LETTER_BY_DIMENSION = {"force": "f", "moment": "t"}
"""What an axis alone is in such a unit."""
IMPLIED_TIME_UNITS = {"millis": "ms", "seconds": "s", "secs": "s", "sec": "s"}
BRACKET_PATTERN = r"[\[({<]([^\])}>]*)[\])}>]"


@dataclass(frozen=True)
class Meaning:
    """`role` is a column of a run log without its arm, or a component of a quaternion (`qx` to `qw`); `group` are the
    words that are left; `odd` is a unit that is none of the role's dimension."""

    role: str
    unit: str | None = None
    group: str = ""
    odd: str = ""


def meaning_of(name: str, unit: str = "") -> Meaning | None:
    """The meaning of a column by its name, and by the unit that stands below it, if any."""
    rest, inside = re.sub(BRACKET_PATTERN, " ", name), re.findall(BRACKET_PATTERN, name)
    labels = [word for word in (*inside, unit) if word.strip() and _is_unit(word)]
    odd = [word for word in (*re.findall(r"\[([^\]]*)\]", name), unit) if _is_odd(word)]
    words = _words(" ".join([rest, *(word for word in inside if not _is_unit(word) and word not in odd)]))
    if labels or odd:
        return _labelled(words, [*labels, *odd][0])
    for count in (3, 2, 1):
        for label in _joined(words[-count:]) if len(words) > count else ():
            found = _labelled(words[:-count], label) if _is_unit(label) else None
            if found is not None and not found.odd:
                return found
    found = _role(words)
    if found is None:
        alone = unit_of(words[0], "time") if len(words) == 1 and words[0] not in ("s", "m") else None
        return Meaning("t", alone) if alone else None
    return Meaning(found.role, IMPLIED_TIME_UNITS.get(words[-1]) if found.role == "t" else None, found.group)


def _labelled(words: Sequence[str], label: str) -> Meaning | None:
    """The meaning of words with a unit: it says whether an axis alone is a force, and whether a yaw is a moment."""
    if unit_of(label, "force"):
        words = [AXIS_WORDS.get(word, word) for word in words]
    found = _role(words)
    if found is not None and found.role in DIMENSIONS and (known := unit_of(label, DIMENSIONS[found.role])):
        return Meaning(found.role, known, found.group)
    axis = next((word for word in words if word in ("x", "y", "z")), "z" if found and found.role == "theta" else "")
    for dimension, letter in LETTER_BY_DIMENSION.items():
        known = unit_of(label, dimension)
        if known and axis and (found is None or found.role in ("x", "y", "theta")) and label.lower() != "m":
            kinds = VOCABULARY["heading"] | VOCABULARY["filler"] | VOCABULARY["moment"] | VOCABULARY["force"]
            left = [word for word in words if word != axis and word not in kinds]
            return Meaning(f"{letter}{axis}", known, "_".join(left))
    return None if found is None else Meaning(found.role, None, found.group, label)


def _is_unit(word: str) -> bool:
    return any(unit_of(word, dimension) for dimension in UNITS)


def _is_odd(word: str) -> bool:
    """Whether what stands where units do is one that isn't known; a word of four letters tells parts apart. A `grad` is
    a degree in German and a gon in English."""
    bare = word.strip().lower()
    is_name = re.search(r"[^\W\d_]{4}", bare) or bare in {*"xyzw"} | VOCABULARY["filler"]
    return bare == "grad" or (bool(re.search(r"[^\W\d_]", bare)) and not _is_unit(word) and not is_name)


def _joined(words: Sequence[str]) -> list[str]:
    """The spellings of a unit that may be written over several words."""
    return ["".join(words), "/".join(word for word in words if word != "per")]


def _words(text: str) -> list[str]:
    """The words of a text in lower case: `posX_mm` is pos, x, mm; `FxLeft` is fx, left."""
    found = []
    for piece in re.split(r"[^\w°µ]+|_", text):
        if piece and (_is_unit(piece) or len(piece) <= 2):
            found.append(piece.lower())
        else:
            found += [w.lower() for w in re.findall(r"[A-ZÄÖÜ]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöüß]+|\d+|°", piece)]
    return found


def _role(words: Sequence[str]) -> Meaning | None:
    """The quantity that the words name, and what tells it from others of its kind."""
    is_force = bool(VOCABULARY["force"] & set(words))
    left = [AXIS_WORDS.get(word, word) if is_force else word for word in words if not word.isdigit()]
    if not left or VOCABULARY["others"] & set(left) or (reading := _reading(left)) is None:
        return None
    role, used = reading
    is_contact = role in ("px", "py", "pz")
    is_of_arm = is_contact or (role[0] in "ft" and role[1:] in ("x", "y", "z"))
    silent = VOCABULARY["filler"] | (VOCABULARY["contact"] if is_contact else frozenset())
    group = [word for word in left if word not in used and word not in silent]
    number = "".join(word for word in words if word.isdigit())
    return Meaning(role, None, "_".join([*group, *([number] if number and is_of_arm else [])]))


def _reading(words: Sequence[str]) -> tuple[str, set[str]] | None:
    """The role that fits, with the words that say so."""
    own, v = set(words), VOCABULARY
    axis = next((word for word in words if word in ("x", "y", "z")), "")
    for word in words:
        if len(word) > 1:
            for kind, end in ((word[:-1], word[-1]), (word[1:], word[0])):
                is_either = end == word[-1] or len(kind) > 2
                if end in "xyzw" and is_either and (role := _of_kind(kind, end, own)):
                    return role, {word, *(own & (v["position"] | v["contact"]))}
    component = axis or ("w" if "w" in own else "")
    if component and own & v["quaternion"]:
        return f"q{component}", own & (v["quaternion"] | {component})
    is_turning = bool(own & v["rate"]) or bool(own & v["heading"] and own & RATE_WORDS)
    is_turning |= "angular" in own and bool(own & (v["speed"] | {"twist"}))
    if is_turning and axis in ("", "z"):
        return "omega", own & (v["rate"] | v["heading"] | RATE_WORDS | v["speed"] | {"angular", "z"})
    if "twist" in own and "linear" in own:
        return (f"v{axis}", {axis}) if axis in ("x", "y") else None
    if own & DERIVATIVE_NAMES or (axis in ("x", "y") and "dot" in own):
        axis = axis or next(iter(own & DERIVATIVE_NAMES)).strip("dot")
        return f"v{axis}", own & (DERIVATIVE_NAMES | {"dot", axis})
    for i, kind in enumerate(words):
        follows = axis in words[i + 1 :]
        if axis and (follows or len(kind) > 1) and (role := _of_kind(kind, axis, own)):
            return role, {kind, axis}
    if own & v["heading"] and axis in ("", "z"):
        return "theta", own & (v["heading"] | {"z"})
    if own & v["time"]:
        return "t", own & v["time"]
    if own & v["force"] or own & (v["moment"] - {"m", "t"}):
        return None
    if axis and own & v["contact"]:
        return f"p{axis}", {axis, *(own & v["contact"])}
    if axis in ("x", "y") and not own & v["speed"]:
        return axis, {axis}
    if own & (v["position"] - {"p"}) and not axis:
        return "x", own & v["position"]
    return None


def _of_kind(kind: str, axis: str, own: set[str]) -> str | None:
    """A word for a quantity, with an axis."""
    v = VOCABULARY
    if kind in v["quaternion"]:
        return f"q{axis}"
    if axis == "w":
        return None
    if kind in v["force"]:
        return f"f{axis}"
    if kind in v["moment"] and not (kind == "t" and own & (v["time"] - {"t"})):
        return f"t{axis}"
    if kind in v["speed"]:
        if own & {"angular", "rot"}:
            return "omega" if axis == "z" else None
        return f"v{axis}" if axis != "z" else None
    if kind in v["rate"]:
        return "omega" if axis == "z" else None
    if kind in v["heading"] and len(kind) > 2:
        return "theta" if axis == "z" else None
    if kind in v["position"]:
        if kind == "p" or own & v["contact"]:
            return f"p{axis}"
        return axis if axis != "z" else None
    return None
