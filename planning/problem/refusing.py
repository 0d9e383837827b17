"""What the classes of a problem have against their numbers, told at the place in the file where these stand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from cartgrasp.errors import CartgraspError, FileError

Refuse = Callable[[list[str | int], str], FileError]
"""The error for a place of a document, and why."""


@contextmanager
def refusing(refuse: Refuse, *where: str | int) -> Iterator[None]:
    """What is refused within is so at this place."""
    try:
        yield
    except CartgraspError as error:
        raise refuse([*where], str(error)) from error
