"""Which logs there are: file, what is believed at first, what is known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from cartgrasp.model import CartModel

from . import carts, truths
from .truths import Truth
from .variants import AS_IT_IS, VARIANTS, Variant

FOLDERS = ("real", "emps")
NO_LOGS = ("sensor_track",)
"""Folders of `real` that hold something else."""


@dataclass(frozen=True)
class MeasuredLog:
    """`path` is in the folder of the data. `idle` names variants that leave the log as it is, `has` what some need."""

    name: str
    path: str
    cart: CartModel
    truth: Truth
    idle: frozenset[str] = frozenset()
    has: frozenset[str] = frozenset({"force"})

    def variants(self) -> tuple[Variant, ...]:
        """Those that change it, itself first."""
        return (AS_IT_IS, *(v for v in VARIANTS if v.name not in self.idle and v.needs <= self.has))


def _incline(name: str, file: str, truth: Truth) -> MeasuredLog:
    """By a ranger alone, which shows centimetres and hundredths of a second."""
    idle = frozenset({"x in mm", "x in 5 mm", "t in ms"})
    return MeasuredLog(name, f"real/incline/{file}", carts.INCLINE, truth, idle, has=frozenset())


LOGS = (
    MeasuredLog("wheelchair", "real/wheelchair/push.csv", carts.WHEELCHAIR, truths.WHEELCHAIR),
    MeasuredLog("car", "real/car/drive_and_coast.csv", carts.CAR, truths.CAR, frozenset({"t in ms"})),
    MeasuredLog("emps", "emps/DATA_EMPS.mat", carts.EMPS, truths.EMPS),
    _incline("good cart", "good_cart.csv", truths.GOOD_CART),
    _incline("magnetic bumper", "magnetic_bumper.csv", truths.MAGNETIC_BUMPER),
    _incline("sail", "sail.csv", truths.SAIL),
    _incline("still", "still.csv", truths.STILL),
)


def undeclared(data: Path, logs: Iterable[MeasuredLog] = LOGS) -> list[str]:
    """Files in the folder of the data of which nothing is known here."""
    known = {log.path for log in logs}
    found = (
        path.relative_to(data)
        for folder in FOLDERS
        for suffix in ("csv", "mat", "parquet")
        for path in (data / folder).rglob(f"*.{suffix}")
    )
    return sorted(p.as_posix() for p in found if p.as_posix() not in known and p.parent.name not in NO_LOGS)
