"""Formulas as pictures within the page (SVG, by ziamath): no script, no network, no font of the reader's."""

from __future__ import annotations

import html

import ziamath
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

SIZE = 17
"""px, beside text of 16."""


def setup(app: Sphinx) -> dict[str, bool]:
    ziamath.config.svg2 = False
    app.add_html_math_renderer("svg", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def visit_inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(picture(node.astext(), inline=True))
    raise nodes.SkipNode


def visit_block(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(f'<div class="formula">{picture(node.astext(), inline=False)}</div>')
    raise nodes.SkipNode


def picture(formula: str, inline: bool) -> str:
    """Its baseline is the text's, its colour too; readers that can't see it are told the TeX."""
    drawn = ziamath.Latex(formula, size=SIZE, color="currentColor", inline=inline)
    shown = f'style="vertical-align: {drawn.getyofst():.1f}px" role="img" aria-label="{html.escape(formula.strip())}"'
    return drawn.svg().replace("<svg ", f"<svg {shown} ", 1)
