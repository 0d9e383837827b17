"""Sentences are short on the pages that a stranger reads first, and a heading that counts lines counts right."""

from __future__ import annotations

import re

import pytest

from ..cli.commands import ROOT
from .prose import sentences, words
from .snippets import blocks

LONGEST = 25
"""Words of a sentence; a piece of code, a formula or a symbol is one, and only a full stop ends it."""
NOT_YET = {"architecture", "command_line"}
"""Pages of docs/ with longer ones; results are notes of a day, and are not looked at."""
DOCS = [page for page in sorted((ROOT / "docs").glob("*.md")) if page.stem not in NOT_YET]
PAGES = [ROOT / "README.md", *DOCS, *sorted((ROOT / "docs" / "tutorials").glob("*.md"))]
NUMBERS = {"ten": 10, "twelve": 12, "fifteen": 15, "twenty": 20}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_sentences_are_short(page):
    too_long = [one for one in sentences(page.read_text(encoding="utf-8")) if words(one) > LONGEST]
    assert not too_long, "\n".join(f"{words(one)} words: {one}" for one in too_long)


def test_in_fifteen_lines_has_fifteen():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (said,) = re.findall(r"^## In (\w+) lines$", readme, re.MULTILINE)
    code = next(block.text for block in blocks(ROOT / "README.md") if block.language == "python")
    assert len([line for line in code.splitlines() if line.strip()]) == NUMBERS[said]


def test_what_is_counted():
    """Wrapped lines are one sentence, items and cells are their own, code and comments none."""
    page = "# A title\n\nOne two\nthree. Four `five six`!\n\n- a\n  b\n- c\n\n| d e | f |\n| --- | --- |\n"
    page += "<!-- g -->\n```sh\nh\n```\n"
    found = [(one, words(one)) for one in sentences(page) if words(one)]
    expected = [("A title", 2), ("One two three.", 3), ("Four code!", 2), ("a b", 2), ("c", 1), ("d e", 2), ("f", 1)]
    assert found == expected
    assert sentences("[one two](three) is 3.5 m") == ["one two is 3.5 m"]
