"""What is still open in a table's map: guesses, whose values end with a question mark, and blanks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ruamel.yaml.comments import CommentedMap, CommentedSeq

from ...errors import FileError
from ...yaml_file import parse_yaml
from ..mapped.run_map import Location


def guesses(document: CommentedMap) -> list[tuple[Location, str]]:
    """Where values end with a question mark, and what stands there."""
    return [(where, node[key].strip()) for where, node, key in _scalars(document, ()) if _is_guess(node[key])]


def without_marks(document: CommentedMap, name: str) -> CommentedMap:
    """The same as if all guesses were right, and nothing for arms that are blank; places are kept."""
    for _, node, key in _scalars(document, ()):
        if _is_guess(node[key]):
            node[key] = value_of(node[key].rstrip().removesuffix("?"), name)
    if document.get("arms", 0) is None:
        document["arms"] = CommentedMap()
    return document


def value_of(text: str, name: str = "the answer") -> Any:
    """As YAML reads it, but words as they stand unless they are quoted: those of a column may hold `#` or `&`."""
    try:
        value = parse_yaml(f"value: {text}", name)["value"]
    except FileError:
        return text
    return value if text[:1] in ("'", '"') or not isinstance(value, str) else text


def put(document: CommentedMap, where: Location, value: Any) -> None:
    """Sets what stands at a place, and makes the mappings on the way to it."""
    node: Any = document
    for key in where[:-1]:
        if isinstance(node, CommentedSeq):
            node = node[int(key)]
            continue
        if not isinstance(node.get(key), CommentedMap | CommentedSeq):
            node[key] = CommentedMap()
        node = node[key]
    node[int(where[-1]) if isinstance(node, CommentedSeq) else where[-1]] = value


def _is_guess(value: Any) -> bool:
    return isinstance(value, str) and value.rstrip().endswith("?")


def _scalars(node: Any, where: Location) -> Iterator[tuple[Location, Any, Any]]:
    """Each with its place, and the mapping or list and the key that hold it."""
    inside = node.items() if isinstance(node, CommentedMap) else enumerate(node)
    for key, value in list(inside):
        if isinstance(value, CommentedMap | CommentedSeq):
            yield from _scalars(value, (*where, str(key)))
        else:
            yield (*where, str(key)), node, key
