"""What commands on whole logs begin with: a cart, the logs, and a folder for what comes out."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from ..errors import UsageError
from ..logs import RunLog
from ..model import CartModel
from .estimate import cart_of, log_of
from .output import check_writable, make_folder

CART = "cart.yaml"
"""What identify and discrepancy write into their folder."""


def cart_and_logs(
    paths: Sequence[Path],
    cart_path: Path | None,
    out: Path | None,
    topics: Path | None = None,
    coasting: bool = False,
) -> tuple[CartModel, list[RunLog]]:
    """The folder `out` is made where it is wanted, before the work whose results go there; `topics` maps all bags, and
    `coasting` says of all logs without wrenches that nobody pushed."""
    cart = cart_of(paths[0], cart_path)
    _check_distinct(paths)
    if out is not None:
        make_folder(out)
        check_writable(out / CART, cart_path, topics, *paths)
    logs = [log_of(path, topics, coasting) for path in paths]
    _check_other_rows(paths, logs)
    return cart, logs


def _check_distinct(paths: Sequence[Path]) -> None:
    """The same run twice would count as twice the evidence."""
    seen = set()
    for path in paths:
        if path.resolve() in seen:
            raise UsageError(f"{path}: is given twice; name each log once")
        seen.add(path.resolve())


def _check_other_rows(paths: Sequence[Path], logs: Sequence[RunLog]) -> None:
    """Nor may a copy."""
    for (path, log), (other, same) in combinations(zip(paths, logs, strict=True), 2):
        if _are_alike(log, same):
            raise UsageError(f"{other}: holds the rows of {path}; give each run once")


def _are_alike(one: RunLog, other: RunLog) -> bool:
    arms = zip(one.arms.values(), other.arms.values(), strict=False)
    pairs = [(one.time, other.time), (one.pose, other.pose), *((a.wrench, b.wrench) for a, b in arms)]
    return one.arms.keys() == other.arms.keys() and all(np.array_equal(*pair, equal_nan=True) for pair in pairs)
