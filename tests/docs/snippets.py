"""The code blocks of a page, and how they are run: one after another, in one folder, as a reader would.

`python` is run in one namespace, a line of `sh` that begins with `cartgrasp` as a command, another one as it stands
(`# exit status 2` behind it says how it ends); `text` is what the block before it printed, and the complaint if that
was to end with a status above 1; `yaml` must be YAML. A comment on the line before a block says otherwise:

    <!-- file: NAME -->              the block is written to NAME
    <!-- given: a, b -->             names that the page's reader has, made by `controller_checks.py`
    <!-- numbers vary -->            of a `text` block: only its words are compared
    <!-- slow: how slow -->          it is run by `make prove` alone, and what follows it is compared there
    <!-- not run: why -->

A block without a language is a drawing.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cartgrasp.cli import main
from cartgrasp.yaml_file import parse_yaml

from . import given

BLOCK = re.compile(
    r"(?:^<!-- (?P<mark>[^\n]*) -->\n)?^```(?P<language>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
LANGUAGES = ("python", "sh", "text", "yaml", "c", "")
MARKS = ("", "file", "given", "numbers vary", "slow", "not run")
COMMAND = re.compile(r"^(cartgrasp|make|pip|python|import|from) \S", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """`place` is the page and its line, `kind` what the mark is about and `said` what it says."""

    place: str
    kind: str
    said: str
    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    """Those that are code; Sphinx's own directives are none."""
    source = page.read_text(encoding="utf-8")
    found = []
    for match in BLOCK.finditer(source):
        language = match["language"].strip()
        if language.startswith("{"):
            continue
        line = source.count("\n", 0, match.start("language")) + 1
        kind, _, said = (match["mark"] or "").partition(": ")
        block = Block(f"{page.name}:{line}", kind, said, language, match["text"])
        assert language in LANGUAGES, f"{block.place}: {language!r} is none of {LANGUAGES}"
        assert kind in MARKS, f"{block.place}: {kind!r} is none of {MARKS}"
        assert language or not COMMAND.search(block.text), f"{block.place}: commands in a block without a language"
        found.append(block)
    return found


class Reader:
    """Does in a folder what the blocks of a page say."""

    def __init__(self, folder: Path, has_time: bool = False) -> None:
        self.folder, self.has_time = folder, has_time
        self.names: dict[str, object] = {}
        self.printed: str | None = ""

    def follow(self, block: Block) -> None:
        if block.kind == "not run" or (block.kind == "slow" and not self.has_time):
            self.printed = None
            return
        if block.kind == "given":
            self.names |= {name: getattr(given, name)(self.folder) for name in block.said.split(", ")}
        if block.kind == "file":
            (self.folder / block.said).write_text(block.text, encoding="utf-8")
        elif block.language == "text":
            self._compare(block)
        elif block.language == "python":
            code = compile("\n" * int(block.place.rpartition(":")[2]) + block.text, block.place, "exec")
            self.printed, _ = printed_by(lambda: exec(code, self.names))
        elif block.language == "sh":
            self.printed = "".join(self._command(line) for line in block.text.splitlines())
        elif block.language == "yaml":
            parse_yaml(block.text, block.place)
        else:
            assert not block.language, f"{block.place}: say why it is not run"

    def _command(self, line: str) -> str:
        """A comment may say with which exit status it ends."""
        words = shlex.split(line, comments=True)
        expected = int(said[1]) if (said := re.search(r"# exit status (\d+)", line)) else 0
        if words[0] == "cartgrasp":
            status: list[int] = []
            printed, complaint = printed_by(lambda: status.append(main(words[1:])))
            assert status == [expected], f"{line}: {complaint}"
            return printed + (complaint if expected > 1 else "")
        words = [sys.executable, *words[1:]] if words[0] == "python" else words
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == expected, f"{line}: {done.stderr}"
        return done.stdout

    def _compare(self, block: Block) -> None:
        if self.printed is None:
            return
        said, printed = ([line.rstrip() for line in text.strip().splitlines()] for text in (block.text, self.printed))
        if block.kind == "numbers vary":
            said, printed = ([without_numbers(line) for line in lines] for lines in (said, printed))
        assert said == printed, f"{block.place}: prints\n{self.printed}"


def without_numbers(line: str) -> str:
    return " ".join(re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "0", line).replace("─", "").split())


def printed_by(act: Callable[[], object]) -> tuple[str, str]:
    """What goes to stdout, and to stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        act()
    return out.getvalue(), err.getvalue()
