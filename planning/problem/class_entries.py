"""Parts of `PROBLEM.yaml` that are made of classes: whatever limits the cart, or adds to an objective, has its key by
standing in its folder, and its numbers as keys of that."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, TypeVar, get_origin, get_type_hints

from pydantic import Field as EntryField
from pydantic import create_model

from cartgrasp.yaml_file import StrictModel

from ..objectives.objective import ABOVE_ZERO
from .values import NotNegative, Positive, Triple

T = TypeVar("T")


def classes_in(package: ModuleType, kind: type[T]) -> dict[str, type[T]]:
    """By key, `side_force` of `SideForce`, all of a kind that can be made, of the modules in a package."""
    found = {}
    for module in iter_modules(package.__path__):
        for name, one in vars(import_module(f"{package.__name__}.{module.name}")).items():
            if isinstance(one, type) and issubclass(one, kind) and not inspect.isabstract(one) and one is not kind:
                found[re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()] = one
    return found


def entry_of(name: str, classes: Mapping[str, type], base: type[StrictModel] = StrictModel) -> type[StrictModel]:
    """The entry with all keys of `base`, and one for each class."""
    keys: dict[str, Any] = {key: (_entry(key, kind) | None, None) for key, kind in classes.items()}
    return create_model(name, __base__=base, **keys)


def _entry(key: str, kind: type) -> type[StrictModel]:
    """Its keys are the fields of a dataclass, but for an objective's base."""
    types = get_type_hints(kind)
    keys: dict[str, Any] = {
        one.name: (_value(one, types[one.name]), _default(one)) for one in fields(kind) if one.name != "base"
    }
    return create_model(key, __base__=StrictModel, **keys)


def _value(field: Field[Any], of: Any) -> Any:
    if of is float:
        return Positive if field.metadata == ABOVE_ZERO else NotNegative
    return Triple if get_origin(of) is tuple else of


def _default(field: Field[Any]) -> Any:
    if field.default_factory is not MISSING:
        return EntryField(default_factory=field.default_factory)
    return EntryField() if field.default is MISSING else field.default
