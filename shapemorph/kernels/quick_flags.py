"""Flags of numba's compiler that are compared without reading every one of them.

numba looks up each call of a library function by the flags that it is compiled with. It
reads all forty, one property at a time, which takes a twentieth of the time of a first run.
"""

from functools import cache
from typing import Any

from numba.core.targetconfig import TargetConfig


def quicken_flags() -> None:
    """Let flags be gathered and hashed in one step; what they are compared by stays."""
    TargetConfig.values = _values
    TargetConfig.__hash__ = _hash


@cache
def _defaults(kind: type[Any]) -> dict[str, Any]:
    return {name: option.default for name, option in kind.options.items()}


@cache
def _hash_of(kind: type[Any]) -> int:
    return hash(tuple(sorted(kind.options)))


def _values(self: Any) -> dict[str, Any]:
    return {**_defaults(self.__class__), **self._values}


def _hash(self: Any) -> int:
    return _hash_of(self.__class__)
