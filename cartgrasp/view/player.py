"""The top-down player: one HTML page that shows a run, opens from disk and loads nothing.

Names and titles come from logs, so nothing of them is ever markup: the title is escaped, all else is data
that the script puts into the page as text. The Content-Security-Policy lets only this script and style work.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
from functools import cache
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from ..writing import write_atomically
from .player_data import player_data
from .shown_run import ShownRun

PLAYER_SCRIPTS = ("data.js", "scene.js", "cart.js", "arms.js", "legends.js", "charts.js", "panels.js", "player.js")


def player_page(run: ShownRun, title: str) -> str:
    """The page as text."""
    script, style = "\n".join(_asset(name) for name in PLAYER_SCRIPTS), _asset("player.css")
    policy = (
        f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    return Template(_asset("player.html")).substitute(
        policy=policy,
        title=html.escape(title.encode("utf-8", "replace").decode("utf-8")),
        style=style,
        data=_inert_json(player_data(run, title)),
        script=script,
    )


def write_player(run: ShownRun, path: str | os.PathLike[str], title: str) -> Path:
    """Writes the page of `player_page`."""
    return write_atomically(path, player_page(run, title))


@cache
def _asset(name: str) -> str:
    return files("cartgrasp.view").joinpath("assets", name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    """The source expression of CSP for an inline text."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


def _inert_json(value: Any) -> str:
    """JSON in ASCII without `<`, `>` and `&`: nothing in it can end the element it stands in."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text
