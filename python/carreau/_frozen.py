"""Objects that do not change: what users are handed is safe to keep and to share between threads."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, NoReturn

__all__ = ["Frozen", "freeze", "thaw"]


class Frozen:
    """An object without assignable attributes; subclasses fill their slots by `_set`."""

    __slots__ = ()

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} is frozen: '{name}' cannot be set")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"{type(self).__name__} is frozen: '{name}' cannot be deleted")


def freeze(value: Any) -> Any:
    """A value of JSON with tuples for lists and read-only mappings for objects."""
    if isinstance(value, dict):
        return MappingProxyType({key: freeze(item) for key, item in value.items()})
    if isinstance(value, list):
        return tuple(freeze(item) for item in value)
    return value


def thaw(value: Any) -> Any:
    """The opposite of `freeze`."""
    if hasattr(value, "keys"):
        return {key: thaw(value[key]) for key in value}
    if isinstance(value, (list, tuple)):
        return [thaw(item) for item in value]
    return value
