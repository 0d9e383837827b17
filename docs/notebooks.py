"""Makes the notebooks of the tutorials from their pages: `python docs/notebooks.py`, after a change of a page.

A page's `python` blocks become cells, the `text` block behind one its output, all else words. The pages are the source;
the tests run them in an empty folder, and compare.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "tutorials"
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)


def notebook(page: Path) -> dict[str, Any]:
    """The page as a notebook in version 4.5 of the format."""
    source, cells, at = re.sub(r"^<!-- .* -->\n", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE), [], 0
    for match in [*BLOCK.finditer(source), None]:
        words = source[at : match.start() if match else None].strip()
        if words:
            cells.append({"cell_type": "markdown", "metadata": {}, "source": _lines(words)})
        if match and match[1] == "python":
            code = {"execution_count": None, "metadata": {}, "outputs": [], "source": _lines(match[2].rstrip())}
            cells.append({"cell_type": "code", **code})
        elif match:
            printed = {"name": "stdout", "output_type": "stream", "text": _lines(match[2])}
            cells[-1]["outputs"].append(printed)
        at = match.end() if match else at
    for i, cell in enumerate(cells):
        cell["id"] = f"{page.stem.replace('_', '-')}-{i}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def as_text(page: Path) -> str:
    return json.dumps(notebook(page), indent=1, ensure_ascii=False, sort_keys=True) + "\n"


if __name__ == "__main__":
    for page in sorted(FOLDER.glob("*.md")):
        page.with_suffix(".ipynb").write_text(as_text(page), encoding="utf-8")
        print("written:", page.with_suffix(".ipynb").name)
