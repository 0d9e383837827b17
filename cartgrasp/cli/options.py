"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

Json = Annotated[bool, typer.Option("--json", metavar="", help="Print the result alone, as one JSON document.")]
Out = Annotated[Path, typer.Option("--out", help="Folder for the results.")]
Topics = Annotated[Path | None, typer.Option("--topics", help="Map of a bag or a table (else FILE.topics.yaml).")]
Salvage = Annotated[bool, typer.Option("--salvage", metavar="", help="Read what can be read of a damaged bag.")]
Coasting = Annotated[
    bool, typer.Option("--coasting", metavar="", help="Nobody pushes: wrenches are zero, and no sensor is off.")
]
Accept = Annotated[
    list[str] | None,
    typer.Option("--accept", metavar="KIND", help="sign, unit, axes or frame: it is so, whatever it looks like."),
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of all noise.")]
Method = Literal["filter", "regressor", "paper"]
Course = Literal["straight", "curves", "push-pull"]
Plant = Literal["model", "mujoco"]
