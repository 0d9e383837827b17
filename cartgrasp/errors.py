"""The errors of cartgrasp: each says in one sentence what is wrong, where, and what would mend it."""

from __future__ import annotations

from dataclasses import dataclass


class CartgraspError(Exception):
    """Base of every error this library raises on purpose."""


class UsageError(CartgraspError):
    """A call or a configuration that can't be used (exit status 2 at the command line)."""


class DataError(CartgraspError):
    """Data that can't be read or used (exit status 3 at the command line)."""


class PlantError(CartgraspError):
    """A simulator that can't represent what it is asked to simulate."""


def printable(text: str) -> str:
    """One line that shows, whatever a name in a file holds."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


@dataclass(frozen=True)
class Place:
    """Where in a file something stands; line and column count from 1."""

    file: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        return ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)


class FileError(UsageError):
    """A configuration file with a mistake at a known place: `file:line:column: key: why`."""

    def __init__(self, place: Place, key: str, why: str) -> None:
        self.place, self.key, self.why = place, key, why
        super().__init__(": ".join(part for part in (str(place), key, why) if part))


class SettingError(UsageError):
    """A setting of something that has a key, such as an effect: `key.name: why`."""

    def __init__(self, key: str, name: str, why: str) -> None:
        self.name, self.why = name, why
        super().__init__(f"{key}.{name}: {why}")


class LogError(DataError):
    """A log with something that can't be accepted: `file:line: column: why`."""

    def __init__(self, place: Place, column: str, why: str) -> None:
        self.place, self.column, self.why = place, column, why
        super().__init__(": ".join(part for part in (str(place), column, why) if part))
