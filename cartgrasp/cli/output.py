"""What commands print: one JSON document on stdout, or tables; progress and messages on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..strict_json import finite


def print_json(document: Any) -> None:
    """Strict JSON: what is not finite is null."""
    is_unicode = (sys.stdout.encoding or "").lower().replace("-", "").startswith("utf")
    json.dump(finite(document), sys.stdout, ensure_ascii=not is_unicode, allow_nan=False)
    sys.stdout.write("\n")


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> None:
    """A table that fits 80 columns where its text does; the first `left` columns are text."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title), title_justify="left", header_style="bold", expand=False)
    for i, column in enumerate(columns):
        table.add_column(escape(column), justify="left" if i < left else "right", overflow="fold")
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console = Console()
    console.print(table, width=None if console.is_terminal else 100)


def say(message: str) -> None:
    print(message, file=sys.stderr)


@contextmanager
def progress(what: str) -> Iterator[Callable[[float], None]]:
    """A bar on stderr, where that is a terminal, with the time left; the caller tells the share done."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def stages(what: str) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr, where that is a terminal; the caller tells what is being done."""
    from rich.console import Console
    from rich.markup import escape

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status(escape(what)) as status:
        yield lambda stage: status.update(escape(f"{what}: {stage}"))


def make_folder(path: Path) -> Path:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out {path}: can't be made: {error.strerror}; name another folder") from error
    return path


def check_writable(path: Path) -> None:
    """Said before the work whose result would go there."""
    if path.is_dir():
        raise UsageError(f"--out {path}: is a folder; name a file in it")
    if not path.parent.is_dir():
        raise UsageError(f"--out {path}: there is no folder {path.parent}; make it, or name another place")
