"""What commands that learn from whole logs begin with: a cart, the logs, and a folder for what comes out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from ..cart_file import load_cart
from ..errors import CartgraspError, LogError, UsageError
from ..logs import RunLog, files_of, read_log, said_to_coast
from ..logs.coasting import check_said
from ..logs.emps import rail_cart
from ..model import CartModel
from .output import check_writable, make_folder, say
from .sensors import check_accepted

CART_FILE_NAME = "cart.yaml"
"""What identify and discrepancy write into their folder."""


@dataclass(frozen=True)
class Sources:
    """What such a command is given: `topics` maps all bags and tables but run logs, `coasting` says of all logs without
    wrenches that nobody pushed, and `accepted` are suspicions that stop nothing."""

    logs: tuple[Path, ...]
    cart: Path | None = None
    topics: Path | None = None
    coasting: bool = False
    accepted: tuple[str, ...] = ()

    @property
    def files(self) -> tuple[Path | None, ...]:
        """All that is read."""
        return self.cart, self.topics, *(file for log in self.logs for file in files_of(log, self.topics))


def cart_and_logs(sources: Sources, out: Path | None = None) -> tuple[CartModel, list[RunLog]]:
    """The folder `out` is made where it is wanted, before the work whose results go there."""
    check_accepted(sources.accepted)
    paths, topics = sources.logs, sources.topics
    cart = _cart(sources)
    resolved = [path.resolve() for path in paths]
    for i, path in enumerate(paths):  # the same run twice would count as twice the evidence
        if resolved[i] in resolved[:i]:
            raise UsageError(f"{path}: is given twice; name each log once")
    if out is not None:
        make_folder(out)
        check_writable(out / CART_FILE_NAME, *sources.files)
    read = _log if topics is None or len(paths) == 1 else _one_of_several
    logs = [read(path, topics, sources.coasting) for path in paths]
    for (path, log), (other, same) in combinations(zip(paths, logs, strict=True), 2):
        if _are_alike(log, same):
            raise UsageError(f"{other}: holds the rows of {path}; give each run once")
    return cart, logs


def _cart(sources: Sources) -> CartModel:
    if sources.cart is not None:
        return load_cart(sources.cart)
    if sources.logs[0].suffix.lower() == ".mat":
        return rail_cart()
    raise UsageError("--cart is missing: name the cart.yaml with the cart's structure and first guess")


def _log(path: Path, topics: Path | None, coasting: bool) -> RunLog:
    """A log in which somebody pushes, or that is known to coast."""
    log = read_log(path, topics)
    if coasting:
        return said_to_coast(log)
    check_said(log)
    return log


def _one_of_several(path: Path, topics: Path | None, coasting: bool) -> RunLog:
    """What the map can't read may be a run log, as `simulate` writes it."""
    try:
        return _log(path, topics, coasting)
    except LogError as error:
        try:
            log = _log(path, None, coasting)
        except CartgraspError:
            raise error from None
    say(f"{path}: is read without {topics}, as a run log")
    return log


def _are_alike(one: RunLog, other: RunLog) -> bool:
    arms = zip(one.arms.values(), other.arms.values(), strict=False)
    pairs = [(one.time, other.time), (one.pose, other.pose), *((a.wrench, b.wrench) for a, b in arms)]
    return one.arms.keys() == other.arms.keys() and all(np.array_equal(*pair, equal_nan=True) for pair in pairs)
