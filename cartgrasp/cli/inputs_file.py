"""`inputs.json` in a report's folder: the cart and logs that it was made of, so that a later one can follow it.

Paths are relative to the folder; sums (SHA-256) tell whether what they name is still what it was.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from ..errors import DataError, UsageError
from ..logs import files_of
from ..logs.provenance import sum_of_all
from ..writing import write_atomically
from .log_inputs import Sources

INPUTS_FILE_NAME = "inputs.json"


@dataclass(frozen=True)
class Input:
    """A file, or a recorder's folder, and its sum."""

    path: str
    sha256: str


@dataclass(frozen=True)
class Inputs:
    """The sources of one report, with checksums; `cart` is None where a data set brings its own. `beside` are the maps
    that the logs have of their own, and tables that maps name."""

    cart: Input | None
    logs: tuple[Input, ...]
    topics: Input | None = None
    coasting: bool = False
    accepted: tuple[str, ...] = ()
    beside: tuple[Input, ...] = ()

    @classmethod
    def of(cls, sources: Sources, folder: Path) -> Inputs:
        """With the checksums of the files as they are now, and paths relative to a report's folder."""

        def told(path: Path) -> Input:
            return Input(os.path.relpath(path.resolve(), folder.resolve()), sum_of_all(path))

        cart, topics = (told(path) if path else None for path in (sources.cart, sources.topics))
        logs = tuple(map(told, sources.logs))
        further = dict.fromkeys(file for log in sources.logs for file in files_of(log, sources.topics)[1:])
        beside = tuple(told(file) for file in further if file != sources.topics and file.is_file())
        return cls(cart, logs, topics, sources.coasting, sources.accepted, beside)

    def save(self, folder: Path) -> Path:
        return write_atomically(folder / INPUTS_FILE_NAME, json.dumps(asdict(self), indent=1) + "\n")


def following(sources: Sources, folder: Path) -> Sources:
    """The sources with the logs of an earlier report before one's own, and with its cart unless another is given."""
    inputs = _read(folder / INPUTS_FILE_NAME)
    logs = tuple(_there(folder, one, "log") for one in inputs.logs)
    for one in inputs.beside:
        _there(folder, one, "map or table beside a log")
    return Sources(
        (*logs, *sources.logs),
        sources.cart or (_there(folder, inputs.cart, "cart") if inputs.cart else None),
        sources.topics or (_there(folder, inputs.topics, "topic map") if inputs.topics else None),
        sources.coasting or inputs.coasting,
        tuple(dict.fromkeys([*inputs.accepted, *sources.accepted])),
    )


def _read(path: Path) -> Inputs:
    try:
        return TypeAdapter(Inputs).validate_json(path.read_bytes(), strict=True)
    except OSError as error:
        why = f"can't be read: {error.strerror}; name the --out folder of an earlier `cartgrasp discrepancy`"
        raise UsageError(f"--follow {path.parent}: {path.name} {why}") from error
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise DataError(f"{path}: {place}: {first['msg']}; make the report anew") from error


def _there(folder: Path, one: Input, what: str) -> Path:
    """Where it is, if it is what it was."""
    path = Path(os.path.relpath(folder / one.path))
    if not path.exists():
        raise DataError(f"{path}: the {what} that {folder} was made of is gone; put it back, or make the report anew")
    if sum_of_all(path) != one.sha256:
        raise DataError(f"{path}: the {what} has changed since {folder} was made; make the report anew")
    return path
