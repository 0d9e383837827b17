"""The tutorials run in an empty folder, print what they say, and are the notebooks beside them."""

from __future__ import annotations

import json
import re
import time

import pytest

from docs import notebooks

from ..cli.commands import ROOT
from .snippets import Reader, blocks

PAGES = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
UNDER = 600.0
"""s: ten minutes."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_it_runs_in_an_empty_folder(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reader, begin = Reader(tmp_path, has_time=True), time.monotonic()
    for block in blocks(page):
        reader.follow(block)
    assert time.monotonic() - begin < UNDER
    for picture in re.findall(r"\]\((\w+\.png)\)", page.read_text(encoding="utf-8")):
        assert (tmp_path / picture).exists()
        assert (page.parent / picture).exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_notebook_is_the_page(page):
    """After a change of a page: `python docs/notebooks.py`."""
    text = page.with_suffix(".ipynb").read_text(encoding="utf-8")
    assert text == notebooks.as_text(page)
    cells = json.loads(text)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert code == [block.text.rstrip() for block in blocks(page) if block.language == "python"]
    assert len({cell["id"] for cell in cells}) == len(cells)
    assert not re.search(r"/(tmp|home|work|root|usr)/", text)
