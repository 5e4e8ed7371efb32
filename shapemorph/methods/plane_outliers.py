"""Pairs of two views of one surface: outliers by the direction that has no parallax."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats

ROUNDS = 10
KEPT = 4.0  # robust standard deviations


def near_plane(reference_px: Floats, deformed_px: Floats, *, least_px: float) -> Bools:
    """Tell which pairs lie near the plane through dv = y_deformed - y_reference.

    Where two cameras stand side by side, parallax moves points along rows; what it does
    across them is nearly a plane over the picture, so that a pair far from it is wrong.

    Parameters
    ----------
    reference_px, deformed_px : (N, 2)
    least_px : float
        Pairs so near are kept in any case.

    Returns
    -------
    (N,) bool

    References
    ----------
    .. [1] Genovese, K. and Sorgente, D. (2017). A morphing-based scheme for large
       deformation analysis with stereo-DIC, method (ii), step 4.
       :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    design = np.column_stack([np.ones(len(reference_px)), reference_px])
    shift = deformed_px[:, 1] - reference_px[:, 1]
    kept = np.ones(len(shift), dtype=np.bool_)
    for _ in range(ROUNDS):
        if kept.sum() < 3:
            break
        plane, *_ = np.linalg.lstsq(design[kept], shift[kept], rcond=None)
        off = np.abs(shift - design @ plane)
        limit = max(least_px, KEPT * 1.4826 * float(np.median(off[kept])))
        now = off <= limit
        if np.array_equal(now, kept):
            break
        kept = now
    return kept
