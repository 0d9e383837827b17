"""What commands print: one JSON document on stdout, or tables; progress and messages on stderr."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from typing import Any

from ..errors import UsageError
from ..strict_json import finite


def print_json(document: Any) -> None:
    """Strict JSON: what is not finite is null."""
    is_unicode = (sys.stdout.encoding or "").lower().replace("-", "").startswith("utf")
    json.dump(finite(document), sys.stdout, ensure_ascii=not is_unicode, allow_nan=False)
    sys.stdout.write("\n")


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> None:
    """Prints a table at most as wide as the terminal (80 in a pipe). The first `left` columns are text; only there, and
    in headings, may a line break between words."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table
    from rich.text import Text

    console = Console()
    widths, gap = _widths(columns, rows, console.width)
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, gap - 1, 0, 0), header_style="bold")
    for i, (column, width) in enumerate(zip(columns, widths, strict=True)):
        table.add_column(escape(column), justify="left" if i < left else "right", overflow="fold", width=width)
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console.print(Text(title, "italic"))
    console.print(table)


def _widths(columns: Sequence[str], rows: Sequence[Sequence[str]], room: int) -> tuple[list[int], int]:
    """Widths of the columns, and of the gap between them. The widest columns are narrowed until all fit, none below its
    longest word unless nothing else is left."""
    from rich.cells import cell_len

    cells = [[column, *(row[i] for row in rows)] for i, column in enumerate(columns)]
    widths = [max(map(cell_len, column)) for column in cells]
    words = [max((cell_len(word) for cell in column for word in cell.split()), default=1) for column in cells]
    gap = 2 if sum(words) + 2 * (len(words) - 1) <= room else 1
    for least in (words, [1] * len(words)):
        while sum(widths) + gap * (len(widths) - 1) > room:
            wide = [i for i, width in enumerate(widths) if width > least[i]]
            if not wide:
                break
            widths[max(wide, key=widths.__getitem__)] -= 1
    return widths, gap


def say(message: str) -> None:
    print(message, file=sys.stderr)


MIN_PROGRESS_INTERVAL, MAX_PROGRESS_INTERVAL, PROGRESS_INTERVAL_RATIO = 4.0, 20.0, 0.2
"""s between lines of progress where nobody draws a bar, and between these the share of the time that is gone."""


class KernelProgressLines:
    """Lines on stderr while kernels are compiled, of so many if that is known."""

    def __init__(self, most: int | None = None) -> None:
        self.count, self._most = 0, most

    def __call__(self, kernel: str) -> None:
        self.count += 1
        of_all = "" if self._most is None else f" of {self._most}"
        say(f"preparing kernels, once on this machine: {self.count}{of_all} ({kernel})")


@contextmanager
def told_on(what: str) -> Iterator[None]:
    """Lines on stderr of how long it has taken so far, whatever else is told."""
    begun, is_over = time.monotonic(), Event()

    def tell() -> None:
        while not is_over.wait(MIN_PROGRESS_INTERVAL):
            say(f"{what}: {time.monotonic() - begun:.0f} s")

    teller = Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        is_over.set()
        teller.join()


class ShareProgressLines:
    """Lines on stderr of how much is done, and how long the rest may take, while something takes long; and one at the
    beginning, if that is asked for."""

    def __init__(self, what: str, *, tells_begin: bool = False) -> None:
        self._what, self._begun = what, time.monotonic()
        if tells_begin:
            say(f"{what} ...")
        self._told = self._begun

    def __call__(self, share: float) -> None:
        now = time.monotonic()
        interval = PROGRESS_INTERVAL_RATIO * (now - self._begun)
        interval = min(max(interval, MIN_PROGRESS_INTERVAL), MAX_PROGRESS_INTERVAL)
        if now - self._told >= interval and 0.0 < share < 1.0:
            self._told, left = now, (now - self._begun) * (1.0 - share) / share
            rest = f"{left / 60:.0f} min" if left >= 120.0 else f"{left:.0f} s"
            say(f"{self._what}: {100 * share:.0f} %, {rest} left")


@contextmanager
def progress(what: str, *, tells_begin: bool = False) -> Iterator[Callable[[float], None]]:
    """A bar on stderr with the time left, or lines where that is no terminal; the caller tells the share done."""
    if not sys.stderr.isatty():
        yield ShareProgressLines(what, tells_begin=tells_begin)
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(what), total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def stages(what: str) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr, where that is a terminal, with the time taken; the caller tells what is being done."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(escape(what))
        yield lambda stage: bar.update(task, description=escape(f"{what}: {stage}"))


def make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out {path}: can't be made: {error.strerror}; name another folder") from error
    try:
        _try_to_write(path)
    except OSError as error:
        raise UsageError(f"--out {path}: can't be written: {error.strerror}; name another folder") from error


def _try_to_write(folder: Path) -> None:
    """Raises OSError where no file can be made; permissions alone don't tell."""
    from tempfile import TemporaryFile

    with TemporaryFile(dir=folder):
        pass


def check_writable(path: Path, *inputs: Path | None, option: str = "--out") -> None:
    """Said before the work whose result would go there; what a command reads it never writes over."""
    try:
        if path.is_dir():
            raise UsageError(f"{option} {path}: is a folder; name a file in it")
        if not path.parent.is_dir():
            raise UsageError(f"{option} {path}: there is no folder {path.parent}; make it, or name another place")
        if any(one and os.path.exists(one) and path.exists() and path.samefile(one) for one in inputs):
            raise UsageError(f"{option} {path}: is read by this command; name another file")
        for folder in (one for one in inputs if one and os.path.isdir(one)):
            from ..logs.bags.bag import STORAGES  # with numpy

            is_inside = path.exists() and path.resolve().is_relative_to(folder.resolve())
            if is_inside and path.suffix in STORAGES:
                raise UsageError(f"{option} {path}: is of the recording {folder}; name another file")
        _try_to_write(path.parent)
    except OSError as error:
        raise UsageError(f"{option} {path}: can't be written: {error.strerror}; name another file") from error
