"""The pages are made without a warning, each is reached, and none of them loads anything from elsewhere."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from ..cli.commands import ROOT

for name in ("sphinx", "furo", "myst_parser", "ziamath"):
    pytest.importorskip(name, reason="the pages need the extra `docs`")

LOADED = re.compile(r"<(?:script|img|link|iframe|source)[^>]*?\b(?:src|href)=\"([^\"]*)\"")
NAMES = ["load_cart", "Arm", "WrenchPlanner", "plan_or_hold", "CartFilter", "diagnose", "with_effect", "Measurement"]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    out = tmp_path_factory.mktemp("pages")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-n", "-q", "-D", "toc_object_entries=0"]
    command += ["-b", "html", "docs", str(out)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {str(path.relative_to(out)): path.read_text(encoding="utf-8") for path in out.rglob("*.html")}


def test_every_page_is_there(pages):
    sources = [path.relative_to(ROOT / "docs").with_suffix(".html") for path in (ROOT / "docs").rglob("*.md")]
    assert {str(source) for source in sources} <= set(pages)


def test_pages_load_nothing_from_elsewhere(pages):
    loaded = {place for page in pages.values() for place in LOADED.findall(page)}
    assert len(loaded) > 20
    assert not [place for place in loaded if re.match(r"(\w+:)?//", place)]
    assert not [name for name, page in pages.items() if re.search(r"@import|url\(\s*['\"]?(https?:)?//", page)]


def test_formulas_are_pictures(pages):
    assert pages["physics.html"].count('role="img"') > 40
    assert "\\dot" not in re.sub(r'aria-label="[^"]*"', "", pages["physics.html"])


def test_the_public_names_are_told(pages):
    assert [name for name in NAMES if f">{name}<" not in pages["api.html"]] == []
