"""Nouns taken apart into named arrays and a tree of plain values, and put together again.

The tree is JSON. It names the class of every noun; only dataclasses of
``shapemorph.core`` are ever made from it, so a file from elsewhere runs no code.
"""

import dataclasses
import importlib
import math
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from shapemorph.core.errors import DataError

Tree: TypeAlias = Any
Arrays: TypeAlias = dict[str, np.ndarray[Any, Any]]

_HOME = "shapemorph.core."


def take_apart(noun: object) -> tuple[Arrays, Tree]:
    """Split a noun into its arrays, by dotted path, and the rest as JSON values.

    Parameters
    ----------
    noun : object
        A dataclass of ``shapemorph.core`` made of arrays, numbers, strings, None, tuples,
        lists, dicts with string keys and further dataclasses.

    Raises
    ------
    TypeError
        Anything else, arrays of objects included.
    """
    arrays: Arrays = {}
    tree = _encode(noun, "", arrays)
    return arrays, tree


def put_together(arrays: Mapping[str, np.ndarray[Any, Any]], tree: Tree) -> Any:
    """Make the noun that :func:`take_apart` split; its own checks run again.

    Raises
    ------
    DataError
        If an array is missing or the tree is not one of ours.
    """
    try:
        return _decode(tree, arrays)
    except (KeyError, TypeError, AttributeError, ImportError) as error:
        raise DataError(f"a stored result does not fit this version: {error}") from error


def _encode(value: object, path: str, arrays: Arrays) -> Tree:
    if isinstance(value, np.ndarray):
        return {"array": _keep(value, path, arrays)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _encode_noun(value, path, arrays)
    if isinstance(value, tuple | list):
        kind = "tuple" if isinstance(value, tuple) else "list"
        return {kind: [_encode(v, _below(path, str(i)), arrays) for i, v in enumerate(value)]}
    if isinstance(value, dict):
        return {"dict": {_key(k): _encode(v, _below(path, k), arrays) for k, v in value.items()}}
    return _encode_plain(value, path)


def _encode_noun(value: Any, path: str, arrays: Arrays) -> Tree:
    kind = type(value)
    name = f"{kind.__module__}.{kind.__qualname__}"
    if not name.startswith(_HOME):
        raise TypeError(f"only nouns of {_HOME}* are stored, got {name}")
    fields = {
        field.name: _encode(getattr(value, field.name), _below(path, field.name), arrays)
        for field in dataclasses.fields(value)
    }
    return {"noun": name, "fields": fields}


def _encode_plain(value: object, path: str) -> Tree:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return {"float": repr(value)}
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"{path} cannot be stored: {type(value).__name__}")


def _keep(array: np.ndarray[Any, Any], path: str, arrays: Arrays) -> str:
    if array.dtype.hasobject:
        raise TypeError(f"{path} is an array of objects: not stored")
    arrays[path or "value"] = array
    return path or "value"


def _key(key: object) -> str:
    if not isinstance(key, str):
        raise TypeError(f"only string keys are stored, got {key!r}")
    return key


def _below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _decode(tree: Tree, arrays: Mapping[str, np.ndarray[Any, Any]]) -> Any:
    if not isinstance(tree, dict):
        return tree
    if "noun" in tree:
        fields = {name: _decode(value, arrays) for name, value in tree["fields"].items()}
        return _noun_class(tree["noun"])(**fields)
    ((kind, content),) = tree.items()
    if kind == "array":
        return arrays[content]
    if kind == "float":
        return float(content)
    if kind == "dict":
        return {name: _decode(value, arrays) for name, value in content.items()}
    members = [_decode(value, arrays) for value in content]
    return tuple(members) if kind == "tuple" else members


def _noun_class(name: str) -> type:
    if not name.startswith(_HOME):
        raise TypeError(f"{name} is not a noun of {_HOME}*")
    module, _, kind = name.rpartition(".")
    found = getattr(importlib.import_module(module), kind)
    if not (isinstance(found, type) and dataclasses.is_dataclass(found)):
        raise TypeError(f"{name} is not a noun")
    return found
