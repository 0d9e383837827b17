"""A cached property that does not depend on numbers: objects of one structure share its value, whichever asks first."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, Self, TypeVar, overload

T = TypeVar("T")


class Structured(Protocol):
    @property
    def structure(self) -> dict[str, Any]: ...


class SharedProperty(Generic[T]):
    """Its value stands in the owner's `structure` under its name."""

    def __init__(self, function: Callable[[Any], T]) -> None:
        self._function, self._name, self.__doc__ = function, function.__name__, function.__doc__

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...

    @overload
    def __get__(self, owner: Structured, kind: type) -> T: ...

    def __get__(self, owner: Structured | None, kind: type) -> Self | T:
        if owner is None:
            return self
        shared = owner.structure
        if self._name not in shared:
            shared[self._name] = self._function(owner)
        value: T = owner.__dict__.setdefault(self._name, shared[self._name])  # found there first from now on
        return value
