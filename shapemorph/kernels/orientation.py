"""On which side of a line a point lies: the sign is exact, ties are broken one way for all.

The fast formula decides nearly always; where round-off could change its sign the six
products are summed without error (expansions of doubles, J. R. Shewchuk, Discrete Comput.
Geom. 18 (1997), doi 10.1007/PL00009321).

A point on an edge or a vertex is given to exactly one of the triangles around it: it is
judged as if it lay at (x + e, y + e^2) for an infinitely small e, the same for every
triangle.
"""

import numpy as np
from numba import njit

SPLITTER = 134217729.0  # 2^27 + 1 halves the digits of a double
ROUND_OFF = 3.3306690738754716e-16  # (3 + 16 u) u with u = 2^-53, of the fast formula


@njit(cache=True)
def _exact_side(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> float:
    """Sum the six products without error; the largest part has the sign of the sum."""
    left = np.array((ax, -ax, -px, -ay, ay, py))
    right = np.array((by, py, by, bx, px, bx))
    parts = np.zeros(12)
    for k in range(6):
        a, b = left[k], right[k]
        a_high, b_high = SPLITTER * a, SPLITTER * b
        a_high, b_high = a_high - (a_high - a), b_high - (b_high - b)
        a_low, b_low = a - a_high, b - b_high
        product = a * b
        rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
        for term in range(2):
            carry = rest if term == 0 else product
            for i in range(2 * k + term):
                total = carry + parts[i]
                virtual = total - carry
                parts[i] = (carry - (total - virtual)) + (parts[i] - virtual)
                carry = total
            parts[2 * k + term] = carry
    for i in range(11, -1, -1):
        if parts[i] != 0.0:
            return float(parts[i])
    return 0.0


@njit(cache=True)
def side(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> float:
    """Twice the signed area of the triangle a, b, p; its sign is exact.

    Positive where ``(b - a) x (p - a)`` is.
    """
    left, right = (ax - px) * (by - py), (ay - py) * (bx - px)
    value = left - right
    if abs(value) > ROUND_OFF * (abs(left) + abs(right)) or (left == 0.0 and right == 0.0):
        return value
    return float(_exact_side(ax, ay, bx, by, px, py))


@njit(cache=True)
def takes_ties(sign: float, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether points exactly on edge a -> b of a triangle lie on its inner side."""
    return bool((ay - by if ay != by else bx - ax) * sign > 0.0)


@njit(cache=True)
def owns(sign: float, ax: float, ay: float, bx: float, by: float, px: float, py: float) -> bool:
    """Whether p lies on the inner side of edge a -> b of a triangle.

    `sign` is +1 for triangles of positive signed area, -1 for the others.
    """
    value = side(ax, ay, bx, by, px, py) * sign
    return bool(value > 0.0 or (value == 0.0 and takes_ties(sign, ax, ay, bx, by)))
