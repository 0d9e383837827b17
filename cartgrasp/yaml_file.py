"""Strict YAML 1.2 with exact places: what can't be accepted is refused as `file:line:column: key: why`."""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError, YAMLWarning
from ruamel.yaml.scalarbool import ScalarBoolean

from .checks import check_kind
from .checks import did_you_mean as did_you_mean
from .errors import FileError, Place


class StrictModel(BaseModel):
    """Unknown keys, wrong types and non-finite numbers are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


Model = TypeVar("Model", bound=BaseModel)

NOT_YAML = {
    "'\\t'": "a tab; indent with blanks",
    "cannot start any token": "text that begins so must stand in quotes",
    "mapping values are not allowed": "a colon where none may stand; indent alike, and quote text with colons",
    "expected ',' or": "no comma before this, or a bracket that is not closed",
    "end of stream": "a quote that is not closed",
    "expected the node content": "no value, or a bracket that is not closed",
    "<block end>": "indented otherwise than what it belongs to",
    "another document": "a second document; keep one, without `---`",
}
"""By words of the parser's, which know no cure, ours."""
MAX_YAML_VALUES = 100_000
MAX_YAML_DEPTH = 50


def read_yaml(path: str | os.PathLike[str]) -> CommentedMap:
    """The document of a file, with comments and places kept."""
    check_kind("file", path, (str, os.PathLike), "name it by its path")
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise FileError(Place(str(path)), "", f"is not UTF-8 text ({error.reason} at byte {error.start})") from error
    except OSError as error:
        raise FileError(Place(str(path)), "", f"can't be read: {error.strerror or error}") from error
    except ValueError as error:  # a name that no file can have, such as one with a NUL
        raise FileError(Place(str(path)), "", f"can't be read: {error}") from error
    return parse_yaml(text, str(path))


def parse_yaml(text: str, name: str) -> CommentedMap:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", YAMLWarning)  # an anchor may be used again in YAML 1.2
            document = YAML(typ="rt").load(text)
    except DuplicateKeyError as error:
        mark = error.problem_mark
        why = "stands twice in this mapping; keep one"
        raise FileError(_mark_place(name, mark), _quoted(error.problem), why) from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        said = str(error.problem or error.context)
        why = f"not valid YAML: {next((ours for theirs, ours in NOT_YAML.items() if theirs in said), said)}"
        raise FileError(_mark_place(name, mark), "", why) from error
    except (YAMLError, ValueError, LookupError, TypeError, AttributeError, RuntimeError) as error:
        # beside its own errors, what ruamel stumbles over: tags (`!!set 3`), odd comments, depth
        why = f"not valid YAML: {str(error).splitlines()[0] if str(error) else type(error).__name__}"
        raise FileError(Place(name), "", why) from error
    if not isinstance(document, CommentedMap):
        raise FileError(Place(name, 1, 1), "", "a mapping `key: value` is needed at the top of the file")
    _refuse_odd_shapes(document, name)
    return document


def validate(model: type[Model], document: CommentedMap, name: str, prefix: Sequence[str | int] = ()) -> Model:
    """The document as a pydantic model; the first mistake is raised with its place."""
    try:
        return model.model_validate(plain(document))
    except ValidationError as error:
        first = _first(document, error.errors(include_url=False))
        location = _keys(document, first["loc"], is_missing=first["type"] == "missing")
        why = _why(first)
        if first["type"] == "extra_forbidden":
            why = f"unknown key{did_you_mean(str(location[-1]), _known_keys(model, location))}"
        raise file_error(document, name, location, why, prefix) from error


def file_error(
    document: Any, name: str, location: Sequence[str | int], why: str, prefix: Sequence[str | int] = ()
) -> FileError:
    """An error at the deepest part of `location` that the document has."""
    key = ".".join(str(part) for part in (*prefix, *location))
    return FileError(_place(document, name, location), key, why)


def plain(value: Any) -> Any:
    """ruamel's decorated values as plain Python ones."""
    if isinstance(value, Mapping):
        return {plain(k): plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    if isinstance(value, ScalarBoolean):
        return bool(value)
    for kind in (bool, int, float, str):
        if isinstance(value, kind):
            return kind(value)
    return value


def dump_yaml(document: CommentedMap) -> str:
    yaml = YAML(typ="rt")
    yaml.width = 160
    yaml.indent(mapping=2, sequence=4, offset=2)
    stream = io.StringIO()
    yaml.dump(document, stream)
    return stream.getvalue()


def _refuse_odd_shapes(document: CommentedMap, name: str) -> None:
    """An alias may hold itself, or multiply without end; and a key may be nothing, or a mapping."""
    waiting: list[tuple[Any, int]] = [(document, 0)]
    seen = 0
    while waiting:
        node, depth = waiting.pop()
        seen += 1
        if depth > MAX_YAML_DEPTH or seen > MAX_YAML_VALUES:
            why = f"is nested more than {MAX_YAML_DEPTH} deep, or holds more than {MAX_YAML_VALUES} values"
            raise file_error(node, name, [], why)
        if isinstance(node, Mapping):
            if any(key is None or isinstance(key, Mapping | tuple) for key in node):
                raise file_error(node, name, [], "a key must be a word, not nothing, a list or a mapping")
            waiting.extend((value, depth + 1) for value in node.values())
        elif isinstance(node, list):
            waiting.extend((value, depth + 1) for value in node)


def _keys(document: Any, location: Sequence[str | int], is_missing: bool) -> list[str | int]:
    """The parts of pydantic's location that stand in the document, and the last one where it is missing
    there; pydantic puts names of union branches between them."""
    found: list[str | int] = []
    node = document
    for part in location:
        inside = range(len(node)) if isinstance(node, CommentedSeq) else node
        if isinstance(inside, CommentedMap | range) and part in inside:
            found.append(part)
            node = node[part]
    return [*found, location[-1]] if is_missing else found


def _known_keys(model: type[BaseModel], location: Sequence[str | int]) -> list[str]:
    """What may stand where the last of `location` does; items of lists and of mappings are steps within a field."""
    models = [model]
    for part in location[:-1]:
        fields = [one.model_fields[part] for one in models if part in one.model_fields]
        models = [inner for field in fields for inner in _models(field.annotation)] if fields else models
    return [name for one in models for name in one.model_fields]


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Those in a type, whatever lists and unions are around them."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


def _place(document: Any, name: str, location: Sequence[str | int]) -> Place:
    line = column = 0
    if isinstance(document, CommentedMap | CommentedSeq):
        line, column = int(document.lc.line or 0), int(document.lc.col or 0)
    node = document
    for part in location:
        try:
            if isinstance(node, CommentedMap):
                line, column = node.lc.key(part)
            elif isinstance(node, CommentedSeq):
                line, column = node.lc.item(part)
            else:
                break
            node = node[part]
        except (KeyError, IndexError, TypeError, AttributeError):
            break
    return Place(name, line + 1, column + 1)


def _mark_place(name: str, mark: Any) -> Place:
    return Place(name) if mark is None else Place(name, mark.line + 1, mark.column + 1)


def _quoted(problem: str | None) -> str:
    parts = (problem or "").split('"')
    return parts[1] if len(parts) > 1 else ""


def _first(document: Any, errors: Sequence[Any]) -> Any:
    """An unknown key, else the first; of a value that may be of several types, what is wrong with the one it has."""
    first = min(errors, key=lambda e: e["type"] != "extra_forbidden")
    *place, kind = first["loc"]
    alike = [e for e in errors if list(e["loc"][: len(place)]) == place and e is not first]
    if isinstance(first["input"], Mapping) and (inside := [e for e in alike if len(e["loc"]) > len(place) + 1]):
        return inside[0]
    if first["type"] == "float_type" and any(
        e["type"].startswith("model") and e["loc"][:-1] == first["loc"][:-1] for e in alike
    ):
        return {**first, "type": "number_or_mapping"}
    if not first["type"].endswith("_type") or _keys(document, first["loc"], is_missing=False)[-1:] == [kind]:
        return first
    others = [e for e in alike if not e["type"].endswith("_type")]
    return others[0] if others else first


def _why(error: Any) -> str:
    given, context = error.get("input"), error.get("ctx", {}).get
    many = f"{context('actual_length')} given, but at"
    is_key = isinstance(given, str) and given.isidentifier()
    no_mapping = f"{given!r} is not a mapping `key: value`" + (
        f"; write `{given}: {{}}` if it has none" if is_key else ""
    )
    reasons = {
        "missing": "is missing; add it",
        "finite_number": f"{given} is not a finite number",
        "float_type": f"{given!r} is not a number",
        "number_or_mapping": f"{given!r} is neither a number nor a mapping `{{key: value}}`",
        "int_type": f"{given!r} is not a whole number",
        "string_type": f"{given!r} is not text",
        "list_type": f"{given!r} is not a list `[a, b]`",
        "tuple_type": f"{given!r} is not a list",
        "dict_type": no_mapping,
        "model_type": no_mapping,
        "model_attributes_type": no_mapping,
        "bool_type": f"{given!r} is neither true nor false",
        "too_short": f"{many} least {context('min_length')} are needed",
        "too_long": f"{many} most {context('max_length')} are allowed",
        "greater_than": f"{given} is not > {context('gt')}",
        "greater_than_equal": f"{given} is not >= {context('ge')}",
        "less_than": f"{given} is not < {context('lt')}",
        "less_than_equal": f"{given} is not <= {context('le')}",
        "literal_error": f"{given!r} is not one of {context('expected')}",
        "string_too_short": "is empty; a word is needed",
    }
    message = str(error.get("msg", "")).removeprefix("Value error, ")
    return reasons.get(error["type"], message[:1].lower() + message[1:])
