"""How Sphinx makes these pages: `make docs`. They load nothing from anywhere."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from sphinx.util.inspect import TypeAliasForwardRef  # noqa: E402

import cartgrasp  # noqa: E402

project = "cartgrasp"
author = "The cartgrasp authors"
version = release = cartgrasp.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "formulas"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_math_renderer = "svg"
smartquotes = False
html_theme = "furo"
html_title = "cartgrasp"
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["pages.css"]
autodoc_member_order = "bysource"
autodoc_type_aliases = {"Array": "Array", "ArrayLike": "ArrayLike"}
TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # within other types, too
nitpick_ignore_regex = [("py:.*", ".*")]
"""Types in signatures: not each is on the page of the API. Links between pages stay strict."""


def setup(app):
    app.connect("builder-inited", draw_effects)
    app.connect("autodoc-process-docstring", plain, priority=400)  # before napoleon, which reads "Args:"


def draw_effects(app):
    """Those pictures that are not there yet."""
    from effect_pictures import draw_missing

    draw_missing()


def plain(app, what, name, value, options, lines):
    """Docstrings are no reStructuredText: what is between backticks is code, an example too, the rest stands as it
    is."""
    text, mark, example = "\n".join(lines).partition("\nExample:\n")
    parts = text.split("`")
    parts[::2] = (re.sub(r"([*|\\]|_(?!\w))", r"\\\1", part) for part in parts[::2])
    lines[:] = ("``".join(parts) + mark + example).split("\n")
