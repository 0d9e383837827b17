"""The constants that modules of `estimation` have, and who has copies of them, as the sources say."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .constants import FOLDERS, ROOT

HERE = Path(__file__).parents[2]
PACKAGES = ("cartgrasp", "estimation", "planning")


def declared() -> set[tuple[str, str]]:
    """Module and name of every constant in capitals of both folders: of tables of numbers, each entry."""
    found = set()
    for folder in FOLDERS:
        for path in sorted((HERE / ROOT / folder).rglob("*.py")):
            module = ".".join(path.relative_to(HERE / ROOT).with_suffix("").parts)
            found |= {(module, name) for name in names_in(ast.parse(path.read_text(encoding="utf-8")))}
    return found


def names_in(tree: ast.Module) -> Iterator[str]:
    """Of the constants of a module."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if _is_annotated(node) else []
        for target in targets:
            for one in ast.walk(target):
                if isinstance(one, ast.Name) and one.id.isupper():
                    keys = _entries(node.value)
                    yield from (f"{one.id}[{key}]" for key in keys) if keys else (one.id,)


def _is_annotated(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and node.value is not None


def _entries(value: ast.expr) -> list[str]:
    """Keys of a table that is written out in numbers; none of anything else."""
    if not isinstance(value, ast.Dict):
        return []
    parts = [*value.keys, *value.values]
    if not all(isinstance(one, ast.Constant) for one in parts):
        return []
    numbers = all(isinstance(one.value, int | float) for one in value.values)
    return [str(key.value) for key in value.keys] if numbers else []


@cache
def copies(module: str, name: str) -> tuple[tuple[str, str], ...]:
    """Full names of modules, and the name there, of everything that `from module import name` makes the same when
    modules are loaded, itself first; of copies of copies, too."""
    found = [(module, name)]
    for there in found:
        found += [one for one in _imported().get(there, ()) if one not in found]
    return tuple(found)


@cache
def worked_out_from(module: str, name: str) -> bool:
    """Whether anything that a module does when it is loaded reads it: another constant, a default, a decorator."""
    return any(own in _read_on_loading(where) for where, own in copies(module, name))


@dataclass(frozen=True)
class Source:
    """Of one module."""

    tree: ast.Module
    is_package: bool


@cache
def _sources() -> dict[str, Source]:
    """By full name of the module."""
    found = {}
    for package in PACKAGES:
        for path in sorted((HERE / package).rglob("*.py")):
            parts = path.relative_to(HERE).with_suffix("").parts
            is_package = parts[-1] == "__init__"
            tree = ast.parse(path.read_text(encoding="utf-8"))
            found[".".join(parts[:-1] if is_package else parts)] = Source(tree, is_package)
    return found


@cache
def _imported() -> dict[tuple[str, str], list[tuple[str, str]]]:
    """Who imports a name of a module on being loaded, and as what."""
    found: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for importer, source in _sources().items():
        for node in source.tree.body:
            if isinstance(node, ast.ImportFrom):
                module = _absolute(importer, node, source.is_package)
                for alias in node.names:
                    found.setdefault((module, alias.name), []).append((importer, alias.asname or alias.name))
    return found


def _absolute(importer: str, node: ast.ImportFrom, is_package: bool) -> str:
    if not node.level:
        return node.module or ""
    parts = importer.split(".")
    base = parts[: len(parts) - node.level + is_package]
    return ".".join([*base, *([node.module] if node.module else [])])


@cache
def _read_on_loading(module: str) -> frozenset[str]:
    return frozenset(
        one.id
        for node in _loaded(_sources()[module].tree.body)
        for one in ast.walk(node)
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)
    )


def _loaded(body: list[ast.stmt]) -> Iterator[ast.AST]:
    """What is worked out: all but the inner parts of functions, and annotations."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from (*node.decorator_list, *node.args.defaults, *filter(None, node.args.kw_defaults))
        elif isinstance(node, ast.ClassDef):
            yield from (*node.decorator_list, *node.bases)
            yield from _loaded(node.body)
        elif isinstance(node, ast.AnnAssign):
            yield from [node.value] if node.value else []
        else:
            yield node
