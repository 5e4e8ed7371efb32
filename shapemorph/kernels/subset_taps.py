"""Grey of a block of pixels from spline coefficients, as vectors.

The spline is cubic, or quintic where `wide` is not None: that is settled when a loop is
compiled, so that neither pays for the other. Grey comes out too large by the factor that
:func:`scale_of` takes off again.
"""

from shapemorph.kernels.inner import inner
from shapemorph.kernels.vectors import choose, fused, gather, load, spread, whole


@inner(forceinline=True)
def scale_of(wide) -> float:  # type: ignore[no-untyped-def]
    """Factor that the weights of both directions leave out."""
    return 1.0 / 36.0 if wide is None else 1.0 / 14400.0


@inner(forceinline=True)
def _cubic(t):  # type: ignore[no-untyped-def]
    """Weights of the four knots around offset t, times 6."""
    s = spread(1.0) - t
    tt, ss = t * t, s * s
    left = fused(tt, fused(t, spread(3.0), spread(-6.0)), spread(4.0))
    right = fused(ss, fused(s, spread(3.0), spread(-6.0)), spread(4.0))
    return ss * s, left, right, tt * t


@inner(forceinline=True)
def _inner_quintic(t, tt, t5):  # type: ignore[no-untyped-def]
    """Weights of the knots two before and one before offset t in a quintic spline, times 120."""
    far = fused(fused(spread(5.0), tt, spread(10.0)), tt, spread(1.0))
    far = fused(fused(spread(10.0), tt, spread(5.0)), t, far) - spread(5.0) * t5
    near = fused(fused(spread(-20.0), tt, spread(20.0)), tt, spread(26.0))
    near = fused(fused(spread(-20.0), tt, spread(50.0)), t, near)
    return far, fused(spread(10.0), t5, near)


@inner(forceinline=True)
def _quintic(t):  # type: ignore[no-untyped-def]
    """Weights of the six knots around offset t, times 120."""
    s = spread(1.0) - t
    tt, ss = t * t, s * s
    t5, s5 = tt * tt * t, ss * ss * s
    q4, q3 = _inner_quintic(t, tt, t5)
    q1, q2 = _inner_quintic(s, ss, s5)
    return s5, q1, q2, q3, q4, t5


@inner(forceinline=True)
def _weights_across(t, wide):  # type: ignore[no-untyped-def]
    """Weights of one knot more, for an offset t in [0, 2)."""
    zero, one = spread(0.0), spread(1.0)
    t0 = choose(t, one, t - one, t)
    if wide is None:
        a, b, c, d = _cubic(t0)
        return (
            choose(t, one, zero, a),
            choose(t, one, a, b),
            choose(t, one, b, c),
            choose(t, one, c, d),
            choose(t, one, d, zero),
        )
    a, b, c, d, e, f = _quintic(t0)
    return (
        choose(t, one, zero, a),
        choose(t, one, a, b),
        choose(t, one, b, c),
        choose(t, one, c, d),
        choose(t, one, d, e),
        choose(t, one, e, f),
        choose(t, one, f, zero),
    )


@inner(forceinline=True)
def _along_four(c, at, p0, p1, p2, p3):  # type: ignore[no-untyped-def]
    """Weighted sum of four neighbours in a row."""
    left = fused(p1, load(c, at + 1), p0 * load(c, at))
    return left + fused(p3, load(c, at + 3), p2 * load(c, at + 2))


@inner(forceinline=True)
def _four(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    p0, p1, p2, p3 = _cubic(t)
    q0, q1, q2, q3 = _cubic(u)
    upper = q0 * _along_four(c, at, p0, p1, p2, p3)
    upper = fused(q1, _along_four(c, at + stride, p0, p1, p2, p3), upper)
    lower = q2 * _along_four(c, at + 2 * stride, p0, p1, p2, p3)
    return upper + fused(q3, _along_four(c, at + 3 * stride, p0, p1, p2, p3), lower)


@inner(forceinline=True)
def _along_five(c, at, p0, p1, p2, p3, p4):  # type: ignore[no-untyped-def]
    """Weighted sum of five neighbours in a row."""
    return fused(p4, load(c, at + 4), _along_four(c, at, p0, p1, p2, p3))


@inner(forceinline=True)
def _five(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    p0, p1, p2, p3, p4 = _weights_across(t, None)
    q0, q1, q2, q3, q4 = _weights_across(u, None)
    grey = q0 * _along_five(c, at, p0, p1, p2, p3, p4)
    grey = fused(q1, _along_five(c, at + stride, p0, p1, p2, p3, p4), grey)
    grey = fused(q2, _along_five(c, at + 2 * stride, p0, p1, p2, p3, p4), grey)
    grey = fused(q3, _along_five(c, at + 3 * stride, p0, p1, p2, p3, p4), grey)
    return fused(q4, _along_five(c, at + 4 * stride, p0, p1, p2, p3, p4), grey)


@inner(forceinline=True)
def _along_six(c, at, p):  # type: ignore[no-untyped-def]
    """Weighted sum of six neighbours in a row."""
    right = fused(p[5], load(c, at + 5), p[4] * load(c, at + 4))
    return right + _along_four(c, at, p[0], p[1], p[2], p[3])


@inner(forceinline=True)
def _six(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    p = _quintic(t)
    q0, q1, q2, q3, q4, q5 = _quintic(u)
    upper = q0 * _along_six(c, at, p)
    upper = fused(q1, _along_six(c, at + stride, p), upper)
    upper = fused(q2, _along_six(c, at + 2 * stride, p), upper)
    lower = q3 * _along_six(c, at + 3 * stride, p)
    lower = fused(q4, _along_six(c, at + 4 * stride, p), lower)
    return upper + fused(q5, _along_six(c, at + 5 * stride, p), lower)


@inner(forceinline=True)
def _along_seven(c, at, p):  # type: ignore[no-untyped-def]
    """Weighted sum of seven neighbours in a row."""
    return fused(p[6], load(c, at + 6), _along_six(c, at, p))


@inner(forceinline=True)
def _seven(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    p = _weights_across(t, 1)
    q0, q1, q2, q3, q4, q5, q6 = _weights_across(u, 1)
    grey = q0 * _along_seven(c, at, p)
    grey = fused(q1, _along_seven(c, at + stride, p), grey)
    grey = fused(q2, _along_seven(c, at + 2 * stride, p), grey)
    grey = fused(q3, _along_seven(c, at + 3 * stride, p), grey)
    grey = fused(q4, _along_seven(c, at + 4 * stride, p), grey)
    grey = fused(q5, _along_seven(c, at + 5 * stride, p), grey)
    return fused(q6, _along_seven(c, at + 6 * stride, p), grey)


@inner(forceinline=True)
def _gather_four(c, stride, at, row, col, used, p0, p1, p2, p3):  # type: ignore[no-untyped-def]
    sum_ = p0 * gather(c, at, stride, row, col, used)
    sum_ = fused(p1, gather(c, at + 1, stride, row, col, used), sum_)
    sum_ = fused(p2, gather(c, at + 2, stride, row, col, used), sum_)
    return fused(p3, gather(c, at + 3, stride, row, col, used), sum_)


@inner(forceinline=True)
def _gather_six(c, stride, at, row, col, used, p):  # type: ignore[no-untyped-def]
    sum_ = _gather_four(c, stride, at, row, col, used, p[0], p[1], p[2], p[3])
    sum_ = fused(p[4], gather(c, at + 4, stride, row, col, used), sum_)
    return fused(p[5], gather(c, at + 5, stride, row, col, used), sum_)


@inner()
def _gathered_cubic(c, stride, at, x, y, used):  # type: ignore[no-untyped-def]
    col, row = whole(x), whole(y)
    p0, p1, p2, p3 = _cubic(x - col)
    q0, q1, q2, q3 = _cubic(y - row)
    grey = q0 * _gather_four(c, stride, at, row, col, used, p0, p1, p2, p3)
    grey = fused(q1, _gather_four(c, stride, at + stride, row, col, used, p0, p1, p2, p3), grey)
    grey = fused(q2, _gather_four(c, stride, at + 2 * stride, row, col, used, p0, p1, p2, p3), grey)
    return fused(q3, _gather_four(c, stride, at + 3 * stride, row, col, used, p0, p1, p2, p3), grey)


@inner()
def _gathered_quintic(c, stride, at, x, y, used):  # type: ignore[no-untyped-def]
    col, row = whole(x), whole(y)
    p = _quintic(x - col)
    q0, q1, q2, q3, q4, q5 = _quintic(y - row)
    grey = q0 * _gather_six(c, stride, at, row, col, used, p)
    grey = fused(q1, _gather_six(c, stride, at + stride, row, col, used, p), grey)
    grey = fused(q2, _gather_six(c, stride, at + 2 * stride, row, col, used, p), grey)
    grey = fused(q3, _gather_six(c, stride, at + 3 * stride, row, col, used, p), grey)
    grey = fused(q4, _gather_six(c, stride, at + 4 * stride, row, col, used, p), grey)
    return fused(q5, _gather_six(c, stride, at + 5 * stride, row, col, used, p), grey)


@inner(forceinline=True)
def grey_in_step(c, stride, at, t, u, wide):  # type: ignore[no-untyped-def]
    """Grey of pixels whose supports advance by one column each.

    `at` is the flat place of the knot at or before the first pixel; t and u are the
    offsets from the knots, 0 to 1.
    """
    if wide is None:
        return _four(c, stride, at - stride - 1, t, u)
    return _six(c, stride, at - 2 * stride - 2, t, u)


@inner(forceinline=True)
def grey_with_jump(c, stride, at, t, u, wide):  # type: ignore[no-untyped-def]
    """Grey of pixels whose supports jump by one column or row at most once: t, u to 2."""
    if wide is None:
        return _five(c, stride, at - stride - 1, t, u)
    return _seven(c, stride, at - 2 * stride - 2, t, u)


@inner(forceinline=True)
def grey_gathered(c, stride, at, x, y, used, wide):  # type: ignore[no-untyped-def]
    """Grey of pixels that each have a support of their own, at offsets x, y of any size."""
    if wide is None:
        return _gathered_cubic(c, stride, at - stride - 1, x, y, used)
    return _gathered_quintic(c, stride, at - 2 * stride - 2, x, y, used)
