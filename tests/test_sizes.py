"""Classes of many methods and functions of many parameters say why, in a comment above them (CONTRIBUTING)."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import takewhile

import pytest

from .test_architecture import sources

MAX_METHODS, MAX_PARAMETERS = 15, 8
METHODS, PARAMETERS = "# Many methods: ", "# Many parameters: "
FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef


def large(source: str) -> Iterator[tuple[str, int, str]]:
    """What is too large to stand without a word: its name, its first line, and how the comment above has to begin."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ClassDef | FUNCTIONS):
            continue
        first = min([node.lineno, *(one.lineno for one in node.decorator_list)])
        if isinstance(node, ast.ClassDef) and sum(isinstance(one, FUNCTIONS) for one in node.body) > MAX_METHODS:
            yield node.name, first, METHODS
        elif isinstance(node, FUNCTIONS) and len(parameters(node)) > MAX_PARAMETERS:
            yield node.name, first, PARAMETERS


def parameters(node: FUNCTIONS) -> list[str]:
    """All that a caller may give."""
    given = node.args
    return [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs) if one.arg not in ("self", "cls")]


def unexplained(source: str) -> list[str]:
    """Names of what is large and has no comment."""
    lines = source.splitlines()
    return [name for name, first, wanted in large(source) if not comment_above(lines, first).startswith(wanted)]


def comment_above(lines: list[str], number: int) -> str:
    """The comment that ends right above a line."""
    above = takewhile(lambda line: line.lstrip().startswith("#"), reversed(lines[: number - 1]))
    return "\n".join(line.lstrip() for line in reversed(list(above)))


def test_what_is_large_says_why() -> None:
    said = [f"{module}: {name}" for module, source in sources().items() for name in unexplained(source)]
    assert said == []


@pytest.mark.parametrize(("comment", "missing"), [("# Many methods: a reason.\n", []), ("# A reason.\n", ["Big"])])
def test_a_large_class_without_a_word_is_found(comment: str, missing: list[str]) -> None:
    methods = "".join(f"    def m{i}(self): ...\n" for i in range(MAX_METHODS + 1))
    assert unexplained(f"{comment}@final\nclass Big(Base):\n{methods}") == missing


def test_a_function_of_many_parameters_is_found() -> None:
    names = ", ".join(f"p{i}" for i in range(MAX_PARAMETERS + 1))
    assert unexplained(f"def wide(self, {names}): ...\n") == ["wide"]
    assert unexplained(f"# Many parameters: why.\ndef wide({names}): ...\n") == []
