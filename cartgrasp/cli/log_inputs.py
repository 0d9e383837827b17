"""What commands on whole logs begin with: a cart, the logs, and a folder for what comes out."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from ..errors import CartgraspError, LogError, UsageError
from ..logs import RunLog
from ..model import CartModel
from .estimate import cart_of, log_of
from .output import check_writable, make_folder, say

CART_FILE_NAME = "cart.yaml"
"""What identify and discrepancy write into their folder."""


def cart_and_logs(
    paths: Sequence[Path],
    cart_path: Path | None,
    out: Path | None,
    topics: Path | None = None,
    coasting: bool = False,
) -> tuple[CartModel, list[RunLog]]:
    """The folder `out` is made where it is wanted, before the work whose results go there; `topics` maps all bags and
    tables but run logs, and `coasting` says of all logs without wrenches that nobody pushed."""
    cart = cart_of(paths[0], cart_path)
    _check_distinct(paths)
    if out is not None:
        make_folder(out)
        check_writable(out / CART_FILE_NAME, cart_path, topics, *paths)
    read = log_of if topics is None or len(paths) == 1 else _one_of_several
    logs = [read(path, topics, coasting) for path in paths]
    _check_other_rows(paths, logs)
    return cart, logs


def _one_of_several(path: Path, topics: Path | None, coasting: bool) -> RunLog:
    """What the map can't read may be a run log, as `simulate` writes it."""
    try:
        return log_of(path, topics, coasting)
    except LogError as error:
        try:
            log = log_of(path, None, coasting)
        except CartgraspError:
            raise error from None
    say(f"{path}: is read without {topics}, as a run log")
    return log


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
