"""Errors of a measurement against the truth of a synthetic pair."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.synthetic import Truth, TruthPoints
from shapemorph.methods.rigid import fit_rigid
from shapemorph.methods.synthetic.truth import (
    random_material,
    true_tensor,
    truth_at,
    truth_of_material,
)


@dataclass(frozen=True, slots=True)
class Yardstick:
    """What counts as wrong, near and covered.

    Attributes
    ----------
    wrong : float
        A deformed position farther off than this is wrong, mm.
    wrong_fixed : float
        The same without regard to the size of the object; only counted, mm.
    kink_margin : float
        Strains nearer than this to a kink are left out, mm of the reference.
    rim_margin : float
        Material nearer than this to the rim need not be covered, mm.
    reach : float
        Material is covered by a right point as near as this, mm.
    samples : int
        Random material points for the coverage.
    seed : int
        Of those.
    """

    wrong: float
    wrong_fixed: float
    kink_margin: float
    rim_margin: float
    reach: float
    samples: int
    seed: int


def compare_with_truth(
    measurement: Measurement, truth: Truth, *, yardstick: Yardstick
) -> dict[str, Any]:
    """Compare measured points with what really happened to them.

    Every measured point stands for the material point of the true reference surface nearest
    to its measured reference position; its error is the distance of its measured deformed
    position from the true one, both in the frame of the deformed file, so that no alignment
    enters. The displacement is judged after removing the alignment, which is a gauge: the
    rigid motion that best lays the true deformed positions of the right points onto the
    measured reference + displacement (least squares) is taken out first.

    Parameters
    ----------
    measurement : Measurement
    truth : Truth
    yardstick : Yardstick

    Returns
    -------
    dict
        Counts, errors in mm, strain errors, coverage; see the keys. Plain numbers.

    Raises
    ------
    DataError
        If no point is OK, or the points do not lie on the surface of this truth.
    """
    good = measurement.arrays["status"] == PointStatus.OK
    if not good.any():
        raise DataError(f"none of {len(good)} points is OK: there is nothing to compare")
    exact = truth_at(truth, measurement.reference[good])
    _refuse_another_object(measurement.reference[good], exact, truth.size)
    deformed = measurement.arrays["deformed_position"][good]
    error = np.linalg.norm(deformed - exact.deformed, axis=1)
    wrong = ~(error <= yardstick.wrong)
    away = exact.kink_distance > yardstick.kink_margin
    return {
        "shape": truth.shape,
        "size_mm": truth.size,
        "points": len(good),
        "ok_points": int(good.sum()),
        "error_mm": _spread(error),
        "wrong_limit_mm": yardstick.wrong,
        "wrong_points": int(wrong.sum()),
        "wrong_share": float(wrong.mean()),
        "wrong_fixed_limit_mm": yardstick.wrong_fixed,
        "wrong_points_fixed": int((~(error <= yardstick.wrong_fixed)).sum()),
        "wrong_visible_points": int((wrong & exact.visible).sum()),
        "kink_margin_mm": yardstick.kink_margin,
        "dE1": _spread(np.abs(measurement.arrays["E1"][good] - exact.e1)[away]),
        "dE2": _spread(np.abs(measurement.arrays["E2"][good] - exact.e2)[away]),
        "displacement_error_mm": _spread(
            np.linalg.norm(_displacement_error(measurement, good, exact, ~wrong), axis=1)
        ),
        "within_sigma": within_sigma(measurement, truth, exact, away),
        **_coverage(truth, measurement.reference[good][~wrong], yardstick),
    }


def _refuse_another_object(reference: Floats, exact: TruthPoints, size: float) -> None:
    """Raise where the measured points are not on the true reference surface."""
    off = float(np.median(np.linalg.norm(reference - exact.reference, axis=1)))
    outside = float(np.mean(exact.rim_distance < -0.02 * size))
    if off > 0.02 * size or outside > 0.5:
        raise DataError(
            f"the measured points lie {off:.3g} mm off the surface of this truth (median) and "
            f"{100 * outside:.0f} % outside its rim: give the truth.npz of the measured pair"
        )


def _spread(values: Floats) -> dict[str, float | None]:
    """Median, 95th percentile and maximum; None where nothing is left."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return {"median": None, "p95": None, "max": None}
    return {
        "median": float(np.median(finite)),
        "p95": float(np.percentile(finite, 95)),
        "max": float(finite.max()),
    }


def within_sigma(
    measurement: Measurement, truth: Truth, exact: TruthPoints, away: Bools
) -> dict[str, float]:
    """Share of good points whose error is at most the standard deviation that they state.

    Parameters
    ----------
    measurement : Measurement
    truth : Truth
    exact : TruthPoints
        Of its OK points.
    away : (N,) bool
        OK points that are judged.

    Returns
    -------
    dict of str to float
        For u, v, w, for the components of the tensor in its tangent basis, and for E1 and
        E2 where they differ by more than 3 sigma; 0.683 for normal errors without bias. Empty
        where the measurement does not state them.
    """
    if not {"sigma_uvw", "E_tangent", "tangent_1"} <= measurement.arrays.keys():
        return {}
    good = measurement.arrays["status"] == PointStatus.OK
    arrays = {name: values[good] for name, values in measurement.arrays.items()}
    error = _displacement_error(measurement, good, exact, np.ones(len(away), dtype=bool))
    error = error + exact.reference - measurement.reference[good]
    basis = np.stack([arrays["tangent_1"], arrays["tangent_2"]], axis=1)
    tensor = true_tensor(truth, measurement.reference[good], basis)
    components = np.stack([tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1]], axis=1)
    clear = away & np.isfinite(arrays["direction_1"][:, 0])
    judged = {
        **{n: (error[:, k], arrays["sigma_uvw"][:, k], away) for k, n in enumerate("uvw")},
        **{
            f"E_{n}": (
                (arrays["E_tangent"] - components)[:, k],
                arrays["sigma_E_tangent"][:, k],
                away,
            )
            for k, n in enumerate(("11", "22", "12"))
        },
        "E1": (arrays["E1"] - exact.e1, arrays["sigma_E1"], clear),
        "E2": (arrays["E2"] - exact.e2, arrays["sigma_E2"], clear),
    }
    return {
        name: float(np.mean(np.abs(off[where]) <= sigma[where]))
        for name, (off, sigma, where) in judged.items()
        if where.any()
    }


def _displacement_error(
    measurement: Measurement, good: Bools, exact: TruthPoints, right: Bools
) -> Floats:
    """Error (N, 3) of the displacement after the best rigid motion of the right points, mm."""
    moved = measurement.reference[good] + measurement.arrays["displacement"][good]
    if np.count_nonzero(right) < 3:
        return np.full_like(moved, np.nan)
    gauge = fit_rigid(exact.deformed[right], moved[right], np.ones(np.count_nonzero(right)))
    error: Floats = moved - gauge.apply(exact.deformed)
    return error


def _coverage(truth: Truth, right: Floats, yardstick: Yardstick) -> dict[str, Any]:
    """Share of random material, even in area, with a right point (N, 3) near it."""
    from scipy.spatial import cKDTree

    material = random_material(
        truth, yardstick.samples, inset=yardstick.rim_margin, seed=yardstick.seed
    )
    exact = truth_of_material(truth, material)
    covered = np.zeros(len(material), dtype=bool)
    if len(right):
        distance, _ = cKDTree(right).query(exact.reference)
        covered = np.asarray(distance <= yardstick.reach)
    return {
        "rim_margin_mm": yardstick.rim_margin,
        "reach_mm": yardstick.reach,
        "coverage": float(covered.mean()),
        "visible_coverage": float(covered[exact.visible].mean()),
    }
