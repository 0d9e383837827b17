"""A map proposed for a table: what is not sure has a question mark, what only the user knows is blank."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ....errors import LogError, printable
from ...csv_log import PAGE
from ..table_map import TableFormat
from .columns import FileColumns
from .forces import Arm, arms_of, judged
from .layout import Layout
from .motion_units import Clock, Entry, MotionUnits, one_of_several
from .proposed_value import ProposedValue, word

MAP_HEADER = f"""\
# How {{name}} is read ({PAGE}). A value that ends with ? is a guess: take the ? away if it is right, else put what is
# right there; fill in what is blank. Until then no command reads the table.
"""


@dataclass(frozen=True)
class Proposal:
    """`text` is the map, `files` what it was made of, the file itself first; `notes` what was seen."""

    text: str
    files: tuple[FileColumns, ...]
    notes: tuple[str, ...]


@dataclass
class _Writer:
    lines: list[str] = field(default_factory=list)

    def add(self, text: str, *whys: str) -> None:
        said = "; ".join(dict.fromkeys(printable(why) for why in whys if why))
        self.lines.append(f"{text.rstrip():<44}  # {said}" if said else text.rstrip())

    def value(self, indent: str, key: str, said: ProposedValue) -> None:
        self.add(f"{indent}{key}: {said}", said.why or ("fill in" if said.value is None else ""))

    def entry(self, indent: str, key: str, entry: Entry | ProposedValue) -> None:
        if isinstance(entry, ProposedValue):
            self.value(indent, key, entry)
        elif isinstance(entry.column.value, list):
            self.add(f"{indent}{key}: {{quaternion: {entry.column}}}", entry.column.why)
        else:
            sign = "" if entry.sign.value == 1 and entry.sign.is_sure else f", sign: {entry.sign}"
            text = f"{indent}{key}: {{column: {entry.column}, unit: {entry.unit}{sign}}}"
            self.add(text, entry.column.why, entry.unit.why, entry.sign.why)


def propose(path: Path, others: Sequence[Path] = ()) -> Proposal:
    """The proposal of a map for a file, with `others` in its folder where it lacks poses or forces. Raises LogError
    where it is no table."""
    main = FileColumns.of(path)
    files = [main, *_siblings(main, others)]
    posed = next((file for file in files if file.has_pose), main)
    units = MotionUnits(posed)
    heading = units.heading_rad() if units.heading else _ahead(units)
    sensors = [replace(arm, length=str(units.lengths["x"].value or "m")) for arm in arms_of(files)]
    arms = judged(sensors, units.motion, units.time, heading)
    writer = _Writer([MAP_HEADER.format(name=printable(path.name)).rstrip()])
    _layout(writer, "", main.layout)
    _time(writer, "", main)
    rates = {"pose": units.clock.rate, **{word(arm.name): arm.clock.rate for arm in arms}}
    slowest = min(rates, key=lambda name: rates[name] * (0.999 if name == "pose" else 1.0))
    gap = max(0.1, 5 / min(rates.values())) if min(rates.values()) else 0.1
    writer.add(f"clock: {slowest}", "whose times are the log's: the slowest; or a rate in Hz")
    writer.add(f"max_gap: {gap:.3g}", "s; longer gaps are left out, never bridged")
    _pose(writer, units, main)
    _arms(writer, arms, main, files)
    faults = [c.fault for f in files for c in f.columns if c.fault and c.meaning]
    strays = [f"{c.title} is left out: {c.role}, but no fx or fy is of the same part" for f in files for c in f.strays]
    return Proposal("\n".join(writer.lines) + "\n", tuple(files), (*units.notes, *strays, *faults))


def _ahead(units: MotionUnits) -> np.ndarray | None:
    """The heading of a cart of which only one coordinate is recorded."""
    return np.zeros(len(units.time)) if units.columns["y"] is None and units.columns["x"] is not None else None


def _siblings(main: FileColumns, others: Sequence[Path]) -> list[FileColumns]:
    """The other files that hold what the main one lacks; where some are akin by name, those alone."""
    akin = [path for path in others if is_akin(path, main.path)]
    found = []
    for path in akin or others:
        try:
            file = FileColumns.of(path)
        except LogError:
            continue
        if (file.has_pose and not main.has_pose) or (file.arms and not main.arms):
            found.append(file)
    return found


def is_akin(one: Path, other: Path) -> bool:
    """Whether names say that two files are of one run: `run3_pose` and `run3_left`, not `run3_pose` and `run4_left`."""
    a, b = ({w for w in re.split(r"[\W_]+", path.stem.lower()) if w} for path in (one, other))
    return bool(a & b) and not any(c.isdigit() for word in a ^ b for c in word)


def _layout(writer: _Writer, indent: str, layout: Layout) -> None:
    plain = TableFormat()
    if layout.format == plain:
        return
    parts = []
    for key in ("separator", "decimal", "header", "first"):
        value = getattr(layout.format, key)
        if key == "decimal" and not layout.is_sure:
            parts.append(f'decimal: "{value}?"')
        elif value != getattr(plain, key) or key == "first":
            text = "" if value is None else f'"{value}"' if isinstance(value, str) else str(value)
            parts.append(f"{key}: {text}".replace('"\t"', '"\\t"'))
    why = "" if layout.is_sure else "or do commas part thousands?"
    writer.add(f"{indent}table: {{{', '.join(parts)}}}", why)


def _time(writer: _Writer, indent: str, file: FileColumns) -> None:
    clock = Clock.of(file)
    if clock.column is None:
        text = file.clock_of_text
        why = "no column holds times" if text is None else f"{text.title} holds text; write its times as seconds"
        writer.add(f"{indent}time: {{rate: }}", f"Hz: {why}; or {{column: NAME, unit: s}}")
        return
    said = ProposedValue(clock.column.ref, len(file.of_role("t")) == 1 or clock.column.unit is not None)
    writer.add(f"{indent}time: {{column: {said}, unit: {clock.unit}}}", clock.unit.why)


def _file(writer: _Writer, indent: str, file: FileColumns, main: FileColumns) -> None:
    """Writes the lines of a sensor with a file of its own."""
    is_sure = is_akin(file.path, main.path)
    said = ProposedValue(file.path.name, is_sure, "" if is_sure else "in the same folder; is it of the same run?")
    writer.value(indent, "file", said)
    _layout(writer, indent, file.layout)
    _time(writer, indent, file)


def _pose(writer: _Writer, units: MotionUnits, main: FileColumns) -> None:
    writer.add("pose:")
    if units.file is not main:
        _file(writer, "  ", units.file, main)
    is_line = units.columns["x"] is not None and units.columns["y"] is None
    constant = {"y": "does it roll on a line?", "theta": "does it never turn?"} if is_line else {}
    for role, unit in (("x", "m"), ("y", "m"), ("theta", "rad")):
        column = units.columns[role]
        if role == "theta" and units.heading is not None:
            writer.entry("  ", role, units.heading)
        elif column is not None:
            writer.entry("  ", role, Entry(one_of_several(column, units.is_only[role]), units.lengths[role]))
        elif role in constant:
            writer.value("  ", role, ProposedValue(0.0, False, f"no column holds it: {constant[role]}"))
        else:
            writer.add(f"  {role}:", f"no column is known to hold it: {{column: NAME, unit: {unit}}}")
    yaw = ProposedValue(round(float(units.offset.value), 4), units.offset.is_sure)
    what = "pose x, y, yaw of the cart's frame {b} in the frame that is tracked: m, rad"
    writer.add(f"  body: [0.0, 0.0, {yaw}]", what, units.offset.why)
    velocity = "columns" if units.velocity else "none"
    writer.add(f"  velocity: {velocity}", "columns, spline or none (estimators need none)")
    for name, entry in units.velocity.items():
        writer.entry("  ", name, entry)
    if units.velocity:
        writer.value("  ", "frame", units.frame)


def _arms(writer: _Writer, arms: Sequence[Arm], main: FileColumns, files: Sequence[FileColumns]) -> None:
    unknown = [column.title for file in files for column in file.unknown()]
    if arms:
        writer.add("arms:")
    elif unknown:
        why = f"no column is known to hold a force, of {', '.join(unknown[:4])}; {{}} if nobody touches the cart"
        writer.add("arms:", why)
    else:
        writer.add("arms: {}", "no column holds a force: nobody touches the cart")
    for arm in arms:
        writer.add(f"  {word(arm.name)}:")
        if arm.file is not main:
            _file(writer, "    ", arm.file, main)
        _contact(writer, arm)
        writer.value("    ", "force", arm.force)
        writer.add(f"    measures: [{', '.join(arm.measures)}]")
        for component in arm.measures:
            writer.entry("    ", component, arm.entry(component))
        if arm.unmeasured is not None:
            writer.value("    ", "unmeasured", arm.unmeasured)
        if arm.latency.is_open or arm.file is not main:
            writer.value("    ", "latency", arm.latency)
        if arm.yaw.is_open:
            writer.add(f"    sensor: {{rpy: [0.0, 0.0, {arm.yaw}]}}", arm.yaw.why)


def _contact(writer: _Writer, arm: Arm) -> None:
    if not arm.contact:
        writer.add("    contact:", "[x, y, z] of the contact point in the cart's frame {b}, m: x forward, y left, z up")
        return
    writer.add("    contact:")
    for name in ("px", "py", "pz"):
        if name in arm.contact:
            writer.entry("      ", name, arm.entry(name))
        else:
            writer.add(f"      {name}:", "no column holds it; a number, m, if it is constant")
