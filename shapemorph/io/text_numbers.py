"""Numbers out of large text blocks, fast, with the line of whatever is not a number."""

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats, Ints

Bytes = NDArray[np.uint8]


class NotANumberError(ValueError):
    """A token that is not a number.

    Attributes
    ----------
    line : int
        Line of the block, from 0.
    token : str
    """

    def __init__(self, line: int, token: str) -> None:
        super().__init__(f"line {line}: {token!r} is not a number")
        self.line = line
        self.token = token


def parse_floats(block: bytes) -> tuple[Floats, Ints]:
    """Read whitespace-separated numbers.

    Returns
    -------
    values : (N,)
        In reading order.
    counts : (L,)
        Numbers on each line; the block's last line break does not begin another line.

    Raises
    ------
    NotANumberError
        At the first token that is not a number.
    """
    counts = tokens_per_line(block)
    return parse_values(block, np.float64, int(counts.sum())), counts


def parse_values(block: bytes, dtype: type[Any], expected: int) -> NDArray[Any]:
    """Read exactly `expected` numbers of one type, or name the token that is none."""
    if expected == 0:
        return np.zeros(0, dtype=dtype)
    try:
        with warnings.catch_warnings():  # numpy 1 warns where numpy 2 raises
            warnings.simplefilter("error", DeprecationWarning)
            values: NDArray[Any] = np.fromstring(block, dtype=dtype, sep=" ")
    except (ValueError, DeprecationWarning):
        raise _first_offender(block, dtype) from None
    if len(values) != expected:
        raise _first_offender(block, dtype)
    return values


def tokens_per_line(block: bytes) -> Ints:
    """Count whitespace-separated tokens on each line."""
    if not block:
        return np.zeros(0, dtype=np.int64)
    data = np.frombuffer(block, dtype=np.uint8)
    starts = np.flatnonzero(token_starts(data))
    breaks = np.flatnonzero(data == ord("\n"))
    if len(breaks) == 0 or breaks[-1] != len(data) - 1:
        breaks = np.append(breaks, len(data))
    before = np.searchsorted(starts, breaks)
    return np.diff(before, prepend=0).astype(np.int64)


def token_starts(data: Bytes) -> NDArray[np.bool_]:
    """Mark the first byte of every token."""
    solid = data > ord(" ")
    first = solid.copy()
    first[1:] &= ~solid[:-1]
    return first


def _first_offender(block: bytes, dtype: type[Any]) -> NotANumberError:
    convert = int if np.issubdtype(dtype, np.integer) else float
    for number, line in enumerate(block.split(b"\n")):
        for token in line.split():
            try:
                convert(token)
            except ValueError:
                return NotANumberError(number, token.decode("latin-1")[:40])
    return NotANumberError(0, block[:40].decode("latin-1"))
