"""Numbers out of the bytes of a text, exactly as the text says.

A decimal number of at most 2^53 times a power of ten up to 10^22 is one correctly rounded
product or quotient of two exact values. Whatever is longer or stranger is left to the caller.

References
----------
W. D. Clinger, How to read floating point numbers accurately, PLDI 1990,
doi 10.1145/93542.93557.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapemorph.core.arrays import Bools, Floats, Ints

Bytes = NDArray[np.uint8]

BLANK = 32  # bytes up to this one part tokens
PLUS, COMMA, MINUS, POINT, SLASH, ZERO, LARGE_E, SMALL_E = 43, 44, 45, 46, 47, 48, 69, 101
EXACT = 1 << 53
LARGEST_POWER = 22
POWERS = 10.0 ** np.arange(LARGEST_POWER + 1)
MOST_DIGITS = 18  # fit 64 bits
MOST_EXPONENT_DIGITS = 4


@njit(cache=True, nogil=True)
def lines_with(data: Bytes, start: Ints, end: Ints, keyword: Bytes) -> Ints:
    """Lines that begin with a keyword and a blank.

    Parameters
    ----------
    data : (B,)
    start, end : (L,)
        First byte of each line, and the one after its last.
    keyword : (K,)
    """
    rows = np.empty(len(start), np.int64)
    count, length = 0, len(keyword)
    for row in range(len(start)):
        begin = start[row]
        if end[row] - begin <= length or data[begin + length] > BLANK:
            continue
        same = True
        for k in range(length):
            same = same and data[begin + k] == keyword[k]
        if same:
            rows[count] = row
            count += 1
    return rows[:count].copy()


@njit(cache=True, nogil=True)
def count_tokens(data: Bytes, start: Ints, end: Ints, comment: int) -> Ints:
    """Count the tokens of each line up to a comment.

    Parameters
    ----------
    data : (B,)
    start, end : (L,)
    comment : int
        Byte that ends a line wherever it stands; 0 for none.
    """
    counts = np.zeros(len(start), np.int64)
    for row in range(len(start)):
        within = False
        for k in range(start[row], end[row]):
            if data[k] == comment and comment != 0:
                break
            solid = data[k] > BLANK
            if solid and not within:
                counts[row] += 1
            within = solid
    return counts


@njit(cache=True, nogil=True)
def read_decimals(
    data: Bytes, start: Ints, end: Ints, counts: Ints, comment: int
) -> tuple[Floats, Bools]:
    """Read the numbers of lines.

    Parameters
    ----------
    data : (B,)
    start, end : (L,)
    counts : (L,)
        From :func:`count_tokens`.
    comment : int

    Returns
    -------
    values : (N,)
        In reading order; of no meaning on lines that are left.
    left : (L,)
        Lines with a token that is long, strange, or no number.
    """
    values = np.zeros(counts.sum())
    left = np.zeros(len(start), np.bool_)
    place = 0
    for row in range(len(start)):
        k, stop = start[row], end[row]
        for n in range(place, place + counts[row]):
            while data[k] <= BLANK:
                k += 1
            negative = data[k] == MINUS
            if negative or data[k] == PLUS:
                k += 1
            mantissa, digits, decimals, beyond = np.int64(0), 0, 0, False
            while k < stop:
                digit = np.int64(data[k]) - ZERO
                if 0 <= digit <= 9:
                    mantissa = 10 * mantissa + digit
                    digits += 1
                    decimals += beyond
                elif data[k] == POINT and not beyond:
                    beyond = True
                else:
                    break
                k += 1
            exponent = np.int64(0)
            if k < stop and (data[k] == SMALL_E or data[k] == LARGE_E):
                k += 1
                down = k < stop and data[k] == MINUS
                if down or (k < stop and data[k] == PLUS):
                    k += 1
                begin = k
                while k < stop and 0 <= np.int64(data[k]) - ZERO <= 9:
                    exponent = 10 * exponent + np.int64(data[k]) - ZERO
                    k += 1
                if not 0 < k - begin <= MOST_EXPONENT_DIGITS:
                    digits = 0
                exponent = -exponent if down else exponent
            power = exponent - decimals
            if (
                not 0 < digits <= MOST_DIGITS
                or mantissa > EXACT
                or abs(power) > LARGEST_POWER
                or (k < stop and data[k] > BLANK and data[k] != comment)
            ):
                left[row] = True
                break
            value = np.float64(mantissa)
            value = value / POWERS[-power] if power < 0 else value * POWERS[power]
            values[n] = -value if negative else value
        place += counts[row]
    return values, left


@njit(cache=True, nogil=True)
def read_corners(
    data: Bytes, start: Ints, end: Ints, counts: Ints, comment: int
) -> tuple[Ints, Ints, Bools]:
    """Read corners ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``.

    Parameters
    ----------
    data : (B,)
    start, end : (L,)
    counts : (L,)
        From :func:`count_tokens`.
    comment : int

    Returns
    -------
    vertex, texture : (N,)
        As written; 0 where there is no vt.
    left : (L,)
        Lines that are written otherwise.
    """
    vertex = np.zeros(counts.sum(), np.int64)
    texture = np.zeros(counts.sum(), np.int64)
    left = np.zeros(len(start), np.bool_)
    place = 0
    for row in range(len(start)):
        k, stop = start[row], end[row]
        for n in range(place, place + counts[row]):
            while data[k] <= BLANK:
                k += 1
            field, value, digits, sign = 0, np.int64(0), 0, np.int64(0)
            while True:
                byte = np.int64(data[k]) if k < stop else np.int64(BLANK)
                if 0 <= byte - ZERO <= 9:
                    value = 10 * value + byte - ZERO
                    digits += 1
                elif byte in (PLUS, MINUS) and digits == 0 and sign == 0:
                    sign = COMMA - byte
                else:
                    missing = digits == 0 and (field == 0 or sign != 0)
                    if missing or digits > MOST_DIGITS or field > 2:
                        left[row] = True
                        break
                    if field == 0:
                        vertex[n] = -value if sign < 0 else value
                    elif field == 1:
                        texture[n] = -value if sign < 0 else value
                    if byte != SLASH:
                        left[row] = byte > BLANK and byte != comment
                        break
                    field, value, digits = field + 1, np.int64(0), 0
                    sign = np.int64(0)
                k += 1
            if left[row]:
                break
        place += counts[row]
    return vertex, texture, left
