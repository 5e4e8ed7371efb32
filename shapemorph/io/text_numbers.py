"""Numbers out of large text blocks, fast, with the line of whatever is not a number."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.number_text import Bytes, count_tokens, read_corners, read_decimals

NO_COMMENT = 0
_BLANKS = bytes(max(byte, ord(" ")) for byte in range(256))
_BLANKS = bytes(max(byte, ord(" ")) for byte in range(256))


class NotANumberError(ValueError):
    """A token that is not a number.

    Attributes
    ----------
    line : int
        Line among those that were read, from 0.
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
    data = np.frombuffer(block, dtype=np.uint8)
    end = np.flatnonzero(data == ord("\n"))
    if len(data) and (len(end) == 0 or end[-1] != len(data) - 1):
        end = np.append(end, len(data))
    return parse_lines(data, np.concatenate([[0], end[:-1] + 1])[: len(end)], end)


def parse_lines(
    data: Bytes, start: Ints, end: Ints, *, comment: int = NO_COMMENT
) -> tuple[Floats, Ints]:
    """Read the whitespace-separated numbers of some lines.

    Parameters
    ----------
    data : (B,)
    start, end : (L,)
        First byte of each line, and the one after its last.
    comment : int
        Byte that ends a line wherever it stands.

    Returns
    -------
    values : (N,)
    counts : (L,)

    Raises
    ------
    NotANumberError
        At the first token that is not a number.
    """
    counts = count_tokens(data, start, end, comment)
    values, left = read_decimals(data, start, end, counts, comment)
    first = np.cumsum(counts) - counts
    for row in np.flatnonzero(left):
        tokens = _tokens(data, int(start[row]), int(end[row]), comment)
        values[first[row] : first[row] + counts[row]] = _floats(tokens, int(row))
    return values, counts


def parse_corners(
    data: Bytes, start: Ints, end: Ints, *, comment: int = NO_COMMENT
) -> tuple[Ints, Ints, Ints]:
    """Read corners ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn`` of some lines.

    Returns
    -------
    vertex, texture : (N,)
        As written; 0 where there is no vt.
    counts : (L,)

    Raises
    ------
    NotANumberError
        At the first token that is written otherwise.
    """
    counts = count_tokens(data, start, end, comment)
    vertex, texture, left = read_corners(data, start, end, counts, comment)
    for row in np.flatnonzero(left)[:1]:
        tokens = _tokens(data, int(start[row]), int(end[row]), comment)
        raise NotANumberError(int(row), _misplaced(tokens))
    return vertex, texture, counts


def _tokens(data: Bytes, start: int, end: int, comment: int) -> list[bytes]:
    line = data[start:end].tobytes()
    if comment != NO_COMMENT:
        line = line.split(bytes([comment]), 1)[0]
    return line.translate(_BLANKS).split()


def _floats(tokens: list[bytes], line: int) -> list[float]:
    for token in tokens:
        if not _is_number(float, token):
            raise NotANumberError(line, token.decode("latin-1")[:40])
    return [float(token) for token in tokens]


def _is_number(kind: type[float], token: bytes) -> bool:
    try:
        kind(token)
    except ValueError:
        return False
    return b"_" not in token


def _misplaced(corners: list[bytes]) -> str:
    """Find what is wrong with some corner of a line."""
    for corner in corners:
        pieces = corner.split(b"/")
        if not pieces[0] or len(pieces) > 3:  # v, vt, vn
            return "a misplaced slash"
        for piece in pieces:
            if piece and not _is_number(int, piece):
                return piece.decode("latin-1")[:40]
    return b" ".join(corners).decode("latin-1")[:40]
