"""Every snippet of README.md and docs/ runs, one page after the other, and prints what the page says."""

from __future__ import annotations

import importlib.util
import shutil

import pytest

from ..cli.commands import ROOT
from .given import put_files
from .snippets import Reader, blocks

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
WITH_CODE = [page for page in PAGES if blocks(page)]
NEEDS = {"arms.md": "pinocchio"}


@pytest.fixture(scope="session")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reader")
    put_files(folder)
    return folder


@pytest.mark.parametrize("has_time", [False, pytest.param(True, marks=pytest.mark.prove)], ids=["quick", "slow too"])
@pytest.mark.parametrize("page", WITH_CODE, ids=lambda page: page.name)
def test_snippets(page, has_time, files, tmp_path, monkeypatch):
    needed = NEEDS.get(page.name)
    if needed and importlib.util.find_spec(needed) is None:
        pytest.skip(f"{needed} is not installed")
    folder = shutil.copytree(files, tmp_path / "reader")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "80")
    reader = Reader(folder, has_time)
    for block in blocks(page):
        reader.follow(block)
