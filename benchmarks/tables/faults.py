"""Tables whose labels lie, or whose axes and signs are others than they seem: who tells, the proposal or the check."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cartgrasp.cart_file import cart_from_text
from cartgrasp.errors import CartgraspError
from cartgrasp.frames import Array
from cartgrasp.logs import read_log
from cartgrasp.logs.tables.proposing import propose
from cartgrasp.logs.tables.questions import put, without_marks
from cartgrasp.logs.tables.table_map import open_questions
from cartgrasp.yaml_file import dump_yaml, parse_yaml
from estimation.sensor_check import check_sensors

from .pushes import Push, drawn_push

NAMES = ("t [s]", "x [m]", "y [m]", "yaw [rad]", "fx [N]", "fy [N]", "tz [Nm]")
Change = Callable[[Array], Array]
SOUND, GUESSED = "as it is", "as it is, the file's mass and inertia 0.4 to 2.5 times the true"


def scaled(column: int, factor: float) -> Change:
    def change(table: Array) -> Array:
        table = table.copy()
        table[:, column] *= factor
        return table

    return change


def swapped(one: int, other: int) -> Change:
    def change(table: Array) -> Array:
        order = list(range(table.shape[1]))
        order[one], order[other] = other, one
        return table[:, order]

    return change


def both(*changes: Change) -> Change:
    def change(table: Array) -> Array:
        for one in changes:
            table = one(table)
        return table

    return change


FAULTS: Mapping[str, Change] = {
    SOUND: lambda table: table,
    "t in ms": scaled(0, 1e3),
    "x, y in mm": both(scaled(1, 1e3), scaled(2, 1e3)),
    "yaw in degrees": scaled(3, 180 / np.pi),
    "yaw turned into radians twice": scaled(3, np.pi / 180),
    "yaw clockwise": scaled(3, -1.0),
    "y to the right": scaled(2, -1.0),
    "x and y swapped": swapped(1, 2),
    "forces in kN": both(scaled(4, 1e-3), scaled(5, 1e-3)),
    "forces in lbf": both(scaled(4, 1 / 4.448), scaled(5, 1 / 4.448)),
    "wrench reversed": both(scaled(4, -1.0), scaled(5, -1.0), scaled(6, -1.0)),
    "fx reversed": scaled(4, -1.0),
    "tz reversed": scaled(6, -1.0),
    "fx and fy swapped": swapped(4, 5),
}
"""By what it is, what is done to the columns; their labels stay."""


@dataclass(frozen=True)
class Told:
    """Whether the proposal asks (beside the contact point, which it always asks for), whether the check of the log that
    its guesses make suspects something, and whether that stops a command."""

    fault: str
    is_asked: bool
    is_suspected: bool
    is_stopped: bool

    @property
    def is_told(self) -> bool:
        return self.is_asked or self.is_suspected


def told(folder: Path, seed: int, faults: Mapping[str, Change] = FAULTS, span: float = np.inf) -> list[Told]:
    """Of the first `span` (s) of one push, all faults one by one. Guesses are taken as they are; the check believes the
    true cart."""
    random = np.random.default_rng([seed, 21])
    push = drawn_push(random, ("hand",))
    table, path = _table(random, push, span), folder / "run.csv"
    folder.mkdir(parents=True, exist_ok=True)
    return [_told(name, _written(change(table), path), push) for name, change in faults.items()]


def sound(folder: Path, seed: int, span: float = np.inf) -> list[Told]:
    """Of a sound push, with the true cart, and with one that is drawn off."""
    random = np.random.default_rng([seed, 21])
    push = drawn_push(random, ("hand",))
    folder.mkdir(parents=True, exist_ok=True)
    path = _written(_table(random, push, span), folder / "run.csv")
    off = float(np.exp(random.uniform(-1.0, 1.0) * np.log(2.5)))
    return [_told(SOUND, path, push), _told(GUESSED, path, push, off)]


def _written(table: Array, path: Path) -> Path:
    rows = (",".join(f"{value:.6f}" for value in row) for row in table.tolist())
    path.write_text("\n".join([",".join(NAMES), *rows]) + "\n", encoding="utf-8")
    return path


def _table(random: np.random.Generator, push: Push, span: float) -> Array:
    time = np.arange(0, min(push.time[-1], span), 0.01)
    pose = push.at(time, push.pose) + random.normal(0, 5e-4, (len(time), 3))
    wrench = push.at(time, push.hands["hand"].wrench)[:, [0, 1, 5]] + random.normal(0, [0.3, 0.3, 0.02], (len(time), 3))
    return np.column_stack([time, pose, wrench])


def _told(fault: str, path: Path, push: Push, off: float = 1.0) -> Told:
    document = parse_yaml(propose(path).text, "proposal")
    questions = open_questions(document, "proposal")
    is_asked = any(q.where[-1] != "contact" for q in questions)
    for question in questions:
        if question.said is None:
            known = {"contact": push.hands["hand"].contact.tolist(), "force": "on_cart"}
            put(document, question.where, known.get(question.where[-1], 0.0))
    own = path.with_name("map.yaml")
    own.write_text(dump_yaml(without_marks(document, "proposal")), encoding="utf-8")
    try:
        cart = cart_from_text(push.cart, "the true cart")
        body = replace(cart.inertia, mass=off * cart.inertia.mass, about_com=off * cart.inertia.about_com)
        suspicions = check_sensors(read_log(path, own), cart.with_inertia(body))
    except CartgraspError as error:
        print(f"{fault}: {error}")
        return Told(fault, is_asked, True, True)
    return Told(fault, is_asked, bool(suspicions), any(one.is_refused for one in suspicions))


def table_of_faults(found: Sequence[Told]) -> str:
    lines = ["| | logs | asked by the map | suspected by the check | stopped | in silence |", "| --- |" + " --- |" * 5]
    for fault in dict.fromkeys(one.fault for one in found):
        own = [one for one in found if one.fault == fault]
        counts = [sum(getattr(one, name) for one in own) for name in ("is_asked", "is_suspected", "is_stopped")]
        silent = "" if fault in (SOUND, GUESSED) else str(sum(not one.is_told for one in own))
        lines.append("| " + " | ".join([fault, str(len(own)), *map(str, counts), silent]) + " |")
    return "\n".join(lines) + "\n"
