"""Noise floor and bias of a measurement of two scans of one state."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.methods.rigid import fit_rigid

_NORMAL = 1.4826  # median of absolute deviations to standard deviation, normal distribution


def noise_figures(measurement: Measurement, *, remove_motion: bool) -> dict[str, Any]:
    """Judge a measurement whose true displacement and strain are known to be none.

    Parameters
    ----------
    measurement : Measurement
        Of two scans of one state.
    remove_motion : bool
        Take the rigid motion that best fits all OK points (least squares) out of the
        displacement first: for scans that were moved between. Their mean displacement is
        then zero by construction. False: both files have one frame and nothing moved.

    Returns
    -------
    dict
        ``points`` and for each of u, v, w (mm), E1, E2 (Green-Lagrange) ``mean``,
        ``std``, ``robust_std``, ``predicted`` (rms of the sigma of the points) and
        ``ratio`` (std over predicted). Plain numbers.

    Raises
    ------
    DataError
        If fewer than three points are OK.
    """
    ok = measurement.arrays["status"] == PointStatus.OK
    if np.count_nonzero(ok) < 3:
        raise DataError(f"expected at least 3 OK points, got {np.count_nonzero(ok)} of {len(ok)}")
    arrays = {name: values[ok] for name, values in measurement.arrays.items()}
    moved = arrays["deformed_position"]
    if remove_motion:
        reference_from_deformed = fit_rigid(moved, measurement.reference[ok], np.ones(len(moved)))
        moved = reference_from_deformed.apply(moved)
    displacement = moved - measurement.reference[ok]
    sigma = arrays["sigma_displacement"]
    return {
        "points": int(np.count_nonzero(ok)),
        **{name: _figures(displacement[:, k], sigma) for k, name in enumerate("uvw")},
        **{name: _figures(arrays[name], arrays[f"sigma_{name}"]) for name in ("E1", "E2")},
    }


def _figures(values: Floats, sigma: Floats) -> dict[str, float]:
    """Mean and spread of values whose truth is zero, beside what was predicted."""
    finite, expected = values[np.isfinite(values)], sigma[np.isfinite(sigma)]
    if len(finite) == 0:
        return dict.fromkeys(("mean", "std", "robust_std", "predicted", "ratio"), float("nan"))
    deviation = np.abs(finite - np.median(finite))
    predicted = float(np.sqrt(np.mean(expected**2))) if len(expected) else float("nan")
    spread = float(finite.std())
    return {
        "mean": float(finite.mean()),
        "std": spread,
        "robust_std": float(_NORMAL * np.median(deviation)),
        "predicted": predicted,
        "ratio": spread / predicted if predicted > 0 else float("nan"),
    }
