"""How strangers write a push down: names, units, signs, clocks, files and marks, each drawn; with the map that reads it
right."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs.tables.units import UNITS

from .pushes import Push, drawn_push

WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
SENSORS = {"all six": WRENCH, "planar": ("fx", "fy", "tz"), "forces": ("fx", "fy", "fz")}
SAID_UNITS = {"m/s": ("m/s", "mps"), "mm/s": ("mm/s", "mms"), "deg/s": ("deg/s", "dps"), "rad/s": ("rad/s", "radps")}
SAID_UNITS |= {"deg": ("°", "deg"), "N·m": ("Nm", "Nm"), "N·mm": ("Nmm", "Nmm"), "lbf·ft": ("lbf-ft", "lbfft")}
SAID_UNITS |= {"lbf·in": ("in-lbf", "lbfin"), "kgf·m": ("kgf·m", "kgfm")}
PLAIN = {"t": "t", "theta": "theta", "omega": "omega"}
WORDS = {
    "t": "Time",
    "x": "Position X",
    "y": "Position Y",
    "theta": "Yaw",
    "vx": "Velocity X",
    "vy": "Velocity Y",
    "omega": "Yaw Rate",
    "fx": "Force X",
    "fy": "Force Y",
    "fz": "Force Z",
    "tx": "Torque X",
    "ty": "Torque Y",
    "tz": "Torque Z",
    "px": "Contact X",
    "py": "Contact Y",
    "pz": "Contact Z",
}
GERMAN = {
    "t": "Zeit",
    "x": "Weg X",
    "y": "Weg Y",
    "theta": "Winkel",
    "vx": "Geschwindigkeit X",
    "vy": "Geschwindigkeit Y",
    "omega": "Gierrate",
    "fx": "Kraft X",
    "fy": "Kraft Y",
    "fz": "Kraft Z",
    "tx": "Drehmoment X",
    "ty": "Drehmoment Y",
    "tz": "Drehmoment Z",
    "px": "Kontakt X",
    "py": "Kontakt Y",
    "pz": "Kontakt Z",
}
CAMEL = {
    "t": "timestamp",
    "x": "posX",
    "y": "posY",
    "theta": "heading",
    "vx": "velX",
    "vy": "velY",
    "omega": "yawRate",
    "fx": "forceX",
    "fy": "forceY",
    "fz": "forceZ",
    "tx": "torqueX",
    "ty": "torqueY",
    "tz": "torqueZ",
    "px": "gripX",
    "py": "gripY",
    "pz": "gripZ",
}
ROS = {
    "t": "field.header.stamp",
    "x": "field.pose.pose.position.x",
    "y": "field.pose.pose.position.y",
    **{q: f"field.pose.pose.orientation.{q[1]}" for q in ("qx", "qy", "qz", "qw")},
    "vx": "field.twist.twist.linear.x",
    "vy": "field.twist.twist.linear.y",
    "omega": "field.twist.twist.angular.z",
    **{f"f{k}": f"wrench.force.{k}" for k in "xyz"},
    **{f"t{k}": f"wrench.torque.{k}" for k in "xyz"},
    **{f"p{k}": f"contact.{k}" for k in "xyz"},
}


@dataclass(frozen=True)
class Habit:
    """All that one stranger does. `label` is how units are written: suffix, brackets, row, or not at all."""

    names: str
    label: str
    separator: str
    decimal: str
    preamble: tuple[str, ...]
    units: Mapping[str, str]
    clock: str
    heading: str
    clockwise: bool
    velocity: str
    force: str
    sensor: str
    contact_columns: bool
    is_apart: bool
    has_extras: bool
    suffix: str


@dataclass(frozen=True)
class Made:
    """`path` is the file to be asked about, `map` what reads it right, `push` what was true; `zero` (s) is the log's
    time at the push's begin, `kind` in a few words."""

    path: Path
    map: dict[str, object]
    push: Push
    habit: Habit
    zero: float
    kind: str


def drawn_habit(random: np.random.Generator) -> Habit:
    def one(*choices: str) -> str:
        return str(random.choice(np.array(choices, dtype=object)))

    names = one("plain", "words", "camel", "german", "plain", "words", "ros")
    separator = one(",", ",", ";", "\t") if names != "german" else ";"
    decimal = "," if names == "german" or (separator == ";" and random.random() < 0.5) else "."
    preambles = ((), (), (), ("# recorded on Monday", "# cart 3"), ("Logger v2.1", "", "Rig: hall 4"))
    suffix = ".parquet" if random.random() < 0.1 else ".csv"
    labels = (
        ("suffix", "brackets", "brackets", "row", "none") if names != "words" else ("brackets", "row", "none", "slash")
    )
    label = one(*labels) if names != "ros" else "none"
    label = "brackets" if label == "row" and suffix == ".parquet" else label
    units = {
        "length": one("m", "mm", "cm", "m", "ft"),
        "speed": one("m/s", "mm/s", "m/s", "km/h"),
        "rate": one("rad/s", "deg/s"),
        "force": one("N", "N", "kN", "lbf", "kgf"),
        "moment": one("N·m", "N·m", "N·mm", "lbf·ft", "lbf·in"),
    }
    if label == "none":  # who says no unit has a usual one
        units = {
            "length": one("m", "m", "mm"),
            "speed": one("m/s", "m/s", "mm/s"),
            "rate": one("rad/s", "rad/s", "deg/s"),
            "force": one("N", "N", "N", "kN"),
            "moment": "N·m",
        }
    if names == "ros":
        units = {"length": "m", "speed": "m/s", "rate": "rad/s", "force": "N", "moment": "N·m"}
    return Habit(
        names=names,
        label=label,
        separator=separator,
        decimal=decimal,
        preamble=preambles[random.integers(len(preambles))],
        units=units,
        clock=one("s", "ms", "epoch s", "epoch ms", "us", "s", "ms", "none") if names != "ros" else "epoch ns",
        heading=one("rad", "rad wrapped", "deg", "deg wrapped", "deg 360"),
        clockwise=bool(random.random() < 0.2 and names != "ros"),
        velocity=one("none", "none", "world", "cart"),
        force=one("on_cart", "on_cart", "on_sensor"),
        sensor=one("all six", "planar", "planar", "forces"),
        contact_columns=bool(random.random() < 0.3),
        is_apart=bool(random.random() < 0.25),
        has_extras=bool(random.random() < 0.5),
        suffix=suffix,
    )


def write(folder: Path, seed: int) -> Made:
    """A table, with sensors' own files beside it where the stranger keeps them apart."""
    random = np.random.default_rng([seed, 20])
    habit = drawn_habit(random)
    hands = (("hand",), ("left", "right"), ())[random.choice(3, p=(0.5, 0.4, 0.1))]
    push = drawn_push(random, hands, is_line=bool(random.random() < 0.1))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return _Writer(folder, habit, push, random).made()


class _Writer:
    def __init__(self, folder: Path, habit: Habit, push: Push, random: np.random.Generator) -> None:
        self.folder, self.habit, self.push, self.random = folder, habit, push, random
        self.is_line = not push.velocity[:, 1:].any()
        self.is_apart = habit.is_apart and bool(push.hands)
        self.clock = "s" if self.is_apart and habit.clock == "none" else habit.clock
        self.zero = 1.7e9 + float(random.integers(10**6)) if self.clock.startswith("epoch") else 0.0

    def made(self) -> Made:
        h = self.habit
        rate = float(self.random.choice([50, 100, 120]))
        time = np.arange(0, self.push.time[-1], 1 / rate)
        columns, pose = self._pose(time)
        document: dict[str, object] = {}
        arms: dict[str, object] = {}
        for name in self.push.hands:
            if self.is_apart:
                own, arm = self._arm(name, self._sensor_times())
                own = self._clock(own.pop("time"), "t") | own
                path, layout = self._file(f"run_{name}", own)
                arms[name] = {"file": path.name, "table": layout, "time": self._time_entry(), **arm}
            else:
                own, arm = self._arm(name, time)
                own.pop("time")
                columns |= own
                arms[name] = arm
        if h.has_extras:
            columns |= {("battery", "V", ""): 24 - 0.001 * time, ("cmd_vx", "", ""): 0.5 + 0 * time}
        if self.clock != "none":
            columns = self._clock(time, "t") | columns
        path, layout = self._file("run_pose" if self.is_apart else "run", columns)
        document |= {"table": layout, "time": self._time_entry(rate), "max_gap": 0.2}
        document |= {"pose": pose, "arms": arms}
        kind = ", ".join(
            [h.names, h.label, self.clock, h.heading + (" clockwise" if h.clockwise and not self.is_line else "")]
            + [f"velocity {h.velocity}", h.force if self.push.hands else "nobody", h.sensor]
            + ["apart"] * self.is_apart
            + ["a line"] * self.is_line
        )
        return Made(path, document, self.push, h, self.zero, kind)

    def _sensor_times(self) -> Array:
        """A clock of its own, which begins elsewhere."""
        rate = float(self.random.choice([100, 240, 500]))
        return np.arange(self.random.uniform(0, 0.3), self.push.time[-1], 1 / rate)

    def _clock(self, time: Array, role: str) -> dict[tuple[str, str, str], Array]:
        unit = self.clock.removeprefix("epoch ")
        numbers = (time + self.zero) / UNITS["time"][unit]
        return {(role, unit, ""): np.round(numbers) if unit in ("ms", "us", "ns") else np.round(numbers, 6)}

    def _time_entry(self, rate: float = 0.0) -> dict[str, object]:
        if self.clock == "none":
            return {"rate": rate}
        unit = self.clock.removeprefix("epoch ")
        return {"column": self._name("t", unit, ""), "unit": unit}

    def _pose(self, time: Array) -> tuple[dict[tuple[str, str, str], Array], dict[str, object]]:
        h, unit = self.habit, self.habit.units["length"]
        noisy = self.push.at(time, self.push.pose) + self.random.normal(0, [5e-4, 5e-4, 5e-4], (len(time), 3))
        entry: dict[str, object] = {}
        columns: dict[tuple[str, str, str], Array] = {}
        for k, role in enumerate(("x",) if self.is_line else ("x", "y")):
            columns[role, unit, ""] = noisy[:, k] / UNITS["length"][unit]
            entry[role] = {"column": self._name(role, unit, ""), "unit": unit}
        if self.is_line:
            return columns, entry | {"y": 0.0, "theta": 0.0, "velocity": "none"}
        if h.names == "ros":
            half = noisy[:, 2] / 2
            parts = {"qx": 0 * half, "qy": 0 * half, "qz": np.sin(half), "qw": np.cos(half)}
            columns |= {(role, "", ""): numbers for role, numbers in parts.items()}
            entry |= {"theta": {"quaternion": [self._name(role, "", "") for role in parts]}, "velocity": "none"}
            if h.velocity != "none":
                self._velocity(time, columns, entry, noisy[:, 2])
            return columns, entry
        angle, sign = h.heading.split()[0], -1 if h.clockwise else 1
        turned = sign * noisy[:, 2] / UNITS["angle"][angle]
        whole = {"rad": 2 * np.pi, "deg": 360.0}[angle]
        if "wrapped" in h.heading:
            turned = (turned + whole / 2) % whole - whole / 2
        elif "360" in h.heading:
            turned = turned % whole
        columns["theta", angle, ""] = turned
        entry["theta"] = {"column": self._name("theta", angle, ""), "unit": angle, "sign": sign}
        entry["velocity"] = "none"
        if h.velocity != "none":
            self._velocity(time, columns, entry, noisy[:, 2])
        return columns, entry

    def _velocity(
        self, time: Array, columns: dict[tuple[str, str, str], Array], entry: dict[str, object], heading: Array
    ) -> None:
        h = self.habit
        velocity = self.push.at(time, self.push.velocity) + self.random.normal(0, [4e-3, 4e-3, 4e-3], (len(time), 3))
        if h.velocity == "cart":
            c, s = np.cos(heading), np.sin(heading)
            velocity = np.column_stack(
                [c * velocity[:, 0] + s * velocity[:, 1], c * velocity[:, 1] - s * velocity[:, 0], velocity[:, 2]]
            )
        entry |= {"velocity": "columns", "frame": h.velocity}
        for k, role in enumerate(("vx", "vy", "omega")):
            dimension = "rate" if role == "omega" else "speed"
            unit, sign = h.units[dimension], -1 if role == "omega" and h.clockwise else 1
            columns[role, unit, ""] = sign * velocity[:, k] / UNITS[dimension][unit]
            entry[role] = {"column": self._name(role, unit, ""), "unit": unit, "sign": sign}

    def _arm(self, name: str, time: Array) -> tuple[dict, dict[str, object]]:
        h, hand = self.habit, self.push.hands[name]
        group = name if len(self.push.hands) > 1 and not self.is_apart else ""
        measures = SENSORS[h.sensor]
        wrench = self.push.at(time, hand.wrench) + self.random.normal(0, [0.3] * 3 + [0.02] * 3, (len(time), 6))
        columns: dict = {"time": time}
        arm: dict[str, object] = {"force": h.force, "measures": list(measures)}
        sign = -1 if h.force == "on_sensor" else 1
        for k, role in enumerate(WRENCH):
            if role in measures:
                dimension = "force" if role[0] == "f" else "moment"
                unit = h.units[dimension]
                columns[role, unit, group] = sign * wrench[:, k] / UNITS[dimension][unit]
                arm[role] = {"column": self._name(role, unit, group), "unit": unit}
        if len(measures) < 6:
            arm["unmeasured"] = "zero"
        arm["contact"] = hand.contact.tolist()
        if h.contact_columns:
            unit = h.units["length"]
            arm["contact"] = {}
            for k, role in enumerate(("px", "py", "pz")):
                columns[role, unit, group] = np.full(len(time), hand.contact[k] / UNITS["length"][unit])
                arm["contact"][role] = {"column": self._name(role, unit, group), "unit": unit}
        return columns, arm

    def _name(self, role: str, unit: str, group: str) -> str:
        h = self.habit
        bracket, suffix = SAID_UNITS.get(unit, (unit, unit))
        if role in ("battery", "cmd_vx"):
            return role
        if h.names == "plain":
            name = f"{group}_{role}" if group else role
        elif h.names == "ros":
            name = f"{group}.{ROS[role]}" if group else ROS[role]
        elif h.names == "camel":
            name = CAMEL[role] + group.title()
        else:
            name = f"{(WORDS if h.names == 'words' else GERMAN)[role]}{' ' + group if group else ''}"
        if h.label == "suffix":
            return f"{name}_{suffix}"
        if h.label == "slash":
            return f"{name} / {bracket}"
        return f"{name} [{bracket}]" if h.label == "brackets" else name

    def _file(self, stem: str, columns: dict[tuple[str, str, str], Array]) -> tuple[Path, dict[str, object]]:
        h = self.habit
        names = [self._name(*key) for key in columns]
        path = self.folder / f"{stem}{h.suffix}"
        if h.suffix == ".parquet":
            import pyarrow
            import pyarrow.parquet

            pyarrow.parquet.write_table(pyarrow.table(dict(zip(names, columns.values(), strict=True))), path)
            return path, {}
        lines = [*h.preamble, h.separator.join(names)]
        if h.label == "row":
            lines.append(h.separator.join(SAID_UNITS.get(unit, (unit, unit))[0] for _, unit, _ in columns))
        formats = [_format(numbers) for numbers in columns.values()]
        for row in zip(*columns.values(), strict=True):
            cells = [form(value) for form, value in zip(formats, row, strict=True)]
            lines.append(h.separator.join(cell.replace(".", h.decimal) for cell in cells))
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        header = len(h.preamble) + 1
        first = header + 1 + (h.label == "row")
        return path, {"separator": h.separator, "decimal": h.decimal, "header": header, "first": first}


def _format(numbers: Array) -> Callable[[float], str]:
    """As many digits as what is written needs: whole numbers, or six that count."""
    if np.array_equal(numbers, np.round(numbers)) and np.abs(numbers).max() > 100:
        return lambda value: f"{value:.0f}"
    return lambda value: f"{value:.6f}"


def as_yaml(document: dict[str, object]) -> str:
    """JSON is YAML."""
    return json.dumps(document, ensure_ascii=False)
