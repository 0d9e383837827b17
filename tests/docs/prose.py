"""Sentences of a page: those of its paragraphs, items and cells; code, comments and addresses are none."""

from __future__ import annotations

import re

ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|vs|cf|al)\.")
PIECE = re.compile(r"^\s*(?:[-*]|\d+\.)\s+|^#+\s+", re.MULTILINE)
CELL = re.compile(r"(?<!\\)\|")


def sentences(source: str) -> list[str]:
    """Code in a line counts as one word, as a formula does; a colon or a semicolon ends nothing."""
    text = re.sub(r"^```.*?^```$|^\$\$.*?^\$\$$|<!--.*?-->", "\n\n", source, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"`[^`]*`|(?<!\w)\$[^$\n]+\$", "code", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = ABBREVIATIONS.sub(r"\1", text)
    found: list[str] = []
    for paragraph in re.split(r"\n\s*\n", PIECE.sub("\n\n", text)):
        lines = [line.strip() for line in paragraph.strip().splitlines()]
        table = all(line.startswith("|") for line in lines)
        pieces = [cell for line in lines for cell in CELL.split(line)] if table else [" ".join(lines)]
        for piece in pieces:
            found += (one.strip() for one in re.split(r"(?<=[.!?])[)\"*]*\s+", piece) if one.strip())
    return found


def words(sentence: str) -> int:
    return sum(bool(re.search(r"\w", one)) for one in sentence.split())
