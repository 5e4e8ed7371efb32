"""Flags that are gathered in one step against those that are read one by one."""

from numba.core.compiler import Flags

import shapemorph.kernels  # noqa: F401 - makes flags quick


def _one_by_one(flags):
    return {name: getattr(flags, name) for name in flags.options}


def test_values_are_those_of_the_properties():
    flags = Flags()
    assert flags.values() == _one_by_one(flags)
    flags.nrt = True
    flags.error_model = "numpy"
    assert flags.values() == _one_by_one(flags)
    assert list(flags.values()) == list(flags.options)


def test_equal_flags_are_one_key_and_others_another():
    plain, other, again = Flags(), Flags(), Flags()
    other.nrt = again.nrt = True
    assert hash(other) == hash(again)
    assert {other: 1, plain: 2}[again] == 1
    assert plain != other
    assert hash(plain) == hash(tuple(sorted(plain.values())))
