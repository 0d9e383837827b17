"""The columns of a file, with what their names mean and the numbers that are in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ....errors import LogError
from ....frames import Array
from ...run_log import CONTACT_COLUMNS, WRENCH_COLUMNS
from ..source import yaw_of
from ..table_file import Table, read_table
from .layout import Layout, layout_of
from .names import Meaning, meaning_of

QUATERNION_ROLES = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True, eq=False)
class Column:
    """`ref` is how a map names it: by number where its name does not do; of a yaw that four columns tell, all their
    names. `numbers` is None where it holds text: `fault` tells the first."""

    ref: str | int | list[str | int]
    title: str
    meaning: Meaning | None
    numbers: Array | None
    fault: str = ""

    @property
    def role(self) -> str:
        return "" if self.meaning is None or self.numbers is None else self.meaning.role

    @property
    def unit(self) -> str | None:
        return None if self.meaning is None else self.meaning.unit

    @property
    def group(self) -> str:
        return "" if self.meaning is None else self.meaning.group

    @property
    def said(self) -> Array:
        assert self.numbers is not None
        return self.numbers

    @property
    def odd(self) -> str:
        return "" if self.meaning is None else self.meaning.odd

    @property
    def span(self) -> tuple[float, float] | None:
        """Least and largest number."""
        if self.numbers is None or not np.isfinite(self.numbers).any():
            return None
        return float(np.nanmin(self.numbers)), float(np.nanmax(self.numbers))


@dataclass(frozen=True, eq=False)
class FileColumns:
    """A file's columns, and how its text is laid out."""

    path: Path
    layout: Layout
    table: Table
    columns: tuple[Column, ...]

    @classmethod
    def of(cls, path: Path) -> FileColumns:
        layout = layout_of(path)
        table = read_table(path, layout.format)
        names = table.header or ("",) * len(table.cells)
        columns = []
        for j, name in enumerate(names):
            unit = layout.units[j] if j < len(layout.units) else ""
            meaning = meaning_of(name, unit) if name else None
            is_plain = name and names.count(name) == 1 and not name.endswith("?") and name.isprintable()
            title, numbers, fault = name or f"column {j + 1}", None, ""
            try:
                numbers = table.column(j + 1)
            except LogError as error:
                fault = f"{title} is left out: line {error.place.line}: {error.why}"
            columns.append(Column(name if is_plain else j + 1, title, meaning, numbers, fault))
        return cls(path, layout, table, tuple(columns))

    def of_role(self, role: str) -> list[Column]:
        """The columns of a role; those that no word tells from another part come first."""
        return sorted((c for c in self.columns if c.role == role and c.span is not None), key=lambda c: bool(c.group))

    @cached_property
    def arms(self) -> dict[str, dict[str, Column]]:
        """Each arm's components of a wrench and of a contact point, by the words that tell arms apart."""
        found: dict[str, dict[str, Column]] = {}
        for column in self.columns:
            if column.role in WRENCH_COLUMNS:
                found.setdefault(column.group, {}).setdefault(column.role, column)
        for column in self.columns:
            own = column.group if column.group in found else next(iter(found), "") if len(found) == 1 else None
            if column.role in CONTACT_COLUMNS and own in found:
                found[own].setdefault(column.role, column)
        return {name: own for name, own in found.items() if "fx" in own or "fy" in own}

    def is_only(self, column: Column) -> bool:
        """Whether no other column of the same arm is taken for the same."""
        return sum(c.role == column.role and c.group == column.group for c in self.columns) == 1

    @property
    def yaw(self) -> Column | None:
        """The heading, rad, of a quaternion whose four components are there, or the two that a yaw alone has."""
        found = {role: self.of_role(role) for role in QUATERNION_ROLES}
        names = [role for role in QUATERNION_ROLES if found[role]]
        if not {"qz", "qw"} <= set(names):
            return None
        roles = list(QUATERNION_ROLES) if len(names) == 4 else ["qz", "qw"]
        columns = [found[role][0] for role in roles]
        refs = [column.ref for column in columns if not isinstance(column.ref, list)]
        numbers = yaw_of(np.column_stack([column.said for column in columns]))
        return Column(refs, "the quaternion", Meaning("theta", "rad"), numbers)

    @property
    def has_pose(self) -> bool:
        return bool(self.of_role("x") or (self.of_role("px") and not self.arms))

    @property
    def strays(self) -> list[Column]:
        """Components of wrenches beside which no force along the floor stands."""
        return [c for c in self.columns if c.role in WRENCH_COLUMNS and c.group not in self.arms]

    @property
    def clock_of_text(self) -> Column | None:
        """A column of times that holds no numbers: dates."""
        return next((c for c in self.columns if c.numbers is None and c.meaning and c.meaning.role == "t"), None)

    def unknown(self) -> list[Column]:
        """Columns of changing numbers that no name tells anything of, and forces among whose numbers is text."""
        return [c for c in self.columns if _changes(c) or (c.fault and c.meaning and c.meaning.role in WRENCH_COLUMNS)]


def _changes(column: Column) -> bool:
    return column.meaning is None and column.span is not None and column.span[0] < column.span[1]


def first_of(columns: Sequence[Column]) -> tuple[Column | None, bool]:
    """The likeliest, and whether it is the only one as likely."""
    if not columns:
        return None, True
    rivals = [c for c in columns if bool(c.group) == bool(columns[0].group)]
    return columns[0], len(rivals) == 1
