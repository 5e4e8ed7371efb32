"""Nouns survive being taken apart; nothing else is ever made from a file."""

import dataclasses
import json

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.meshreport import MeshReport
from shapemorph.core.morphed import Morphed
from shapemorph.core.region import Region
from shapemorph.io.codec import put_together, take_apart


def _warp(seed):
    coefficients = np.random.default_rng(seed).normal(size=(4, 5, 2))
    return Warp(coefficients, np.array([-3.0, 1.5]), 12.5)


def _same(left, right):
    if dataclasses.is_dataclass(left):
        fields = dataclasses.fields(left)
        return type(left) is type(right) and all(
            _same(getattr(left, f.name), getattr(right, f.name)) for f in fields
        )
    if isinstance(left, np.ndarray):
        return left.dtype == right.dtype and np.array_equal(
            left, right, equal_nan=left.dtype.kind == "f"
        )
    if isinstance(left, tuple):
        return type(right) is tuple and all(_same(a, b) for a, b in zip(left, right, strict=True))
    return type(left) is type(right) and (left == right or repr(left) == repr(right))


def _nouns():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(7, 2))
    yield Matches(points, points + 1, _warp(1), _warp(2), {"matched": 9}, float("nan"), 0.2, 0.0)
    yield Morphed(GreyImage(rng.random((3, 5), dtype="f4"), rng.random((3, 5)) > 0.5), _warp(3))
    yield Region(centre=np.array([1.0, 2.0, 3.0]), radius=4.0)
    yield TexturedMesh(
        rng.normal(size=(4, 3)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        rng.random((2, 3, 2)),
        np.array([0, 1]),
        (rng.random((4, 6), dtype="f4"), rng.random((2, 2), dtype="f4")),
        np.zeros((0, 3)),
        name="zweite Prüfung",
    )
    yield MeshReport("a", "OBJ", "m", *range(12), ((3, 4), (5, 6)), "texture", "mm", ("note",))
    status = np.zeros((2, 3), "u1")
    yield CorrelationGrid(
        *(np.zeros((2, 3, 2)), np.zeros((2, 3, 2)), np.zeros((2, 3, 2, 2)), np.ones((2, 3))),
        *(np.ones((2, 3), int), np.ones((2, 3, 2)), status, 5, 21, 0.25),
    )


@pytest.mark.parametrize("noun", list(_nouns()), ids=lambda noun: type(noun).__name__)
def test_every_kind_of_field_comes_back_as_it_was(noun):
    arrays, tree = take_apart(noun)
    back = put_together(arrays, json.loads(json.dumps(tree, allow_nan=False)))
    assert _same(noun, back)


def test_arrays_are_named_by_their_path():
    arrays, _ = take_apart(
        Morphed(GreyImage(np.zeros((1, 1), "f4"), np.ones((1, 1), bool)), _warp(0))
    )
    assert set(arrays) == {"image.grey", "image.mask", "warp.coefficients", "warp.origin"}


@dataclasses.dataclass(frozen=True)
class Stranger:
    value: int


@pytest.mark.parametrize("value", [Stranger(1), {1: "x"}, object(), np.array([object()])])
def test_what_is_no_noun_is_refused(value):
    with pytest.raises(TypeError):
        take_apart(value)


@pytest.mark.parametrize(
    "name", ["subprocess.Popen", "shapemorph.core.errors.DataError", "os.system"]
)
def test_a_file_cannot_name_what_is_made(name):
    with pytest.raises(DataError, match="stored result"):
        put_together({}, {"noun": name, "fields": {}})


def test_a_missing_array_is_an_error():
    arrays, tree = take_apart(_warp(0))
    del arrays["origin"]
    with pytest.raises(DataError, match="origin"):
        put_together(arrays, tree)
