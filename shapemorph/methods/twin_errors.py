"""What was measured of a synthetic stereo experiment against what really happened."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Rig
from shapemorph.core.measurement import Measurement
from shapemorph.core.spline_map import SplineMap
from shapemorph.core.status import PointStatus
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.relative import compose
from shapemorph.methods.principal import principal
from shapemorph.methods.synthetic.membrane.smooth import map_points

NAMES = ("u", "v", "w")


@dataclass(frozen=True, slots=True, eq=False)
class TwinPoints:
    """Measured points with the truth about them, in the frame of the body.

    Attributes
    ----------
    material : (N, 2) float64
        mm.
    displacement, truth : (N, 3) float64
        Measured and true, mm.
    strain, true_strain : (N, 2) float64
        E1 and E2, Green-Lagrange.
    """

    material: Floats
    displacement: Floats
    truth: Floats
    strain: Floats
    true_strain: Floats

    @property
    def error(self) -> Floats:
        """Measured less true displacement (N, 3), mm."""
        return self.displacement - self.truth


def twin_points(twin: StereoTwin, measurement: Measurement, rig: Rig, state: int) -> TwinPoints:
    """Find the truth at every point that was measured.

    A measured point stands for the material point of the flat sheet nearest to its reference
    position.

    Parameters
    ----------
    twin : StereoTwin
    measurement : Measurement
        In the world of `rig`.
    rig : Rig
        Cameras that it was measured with; the first one is the first of the twin.
    state : int
        That was measured against the first one.
    """
    there, own = twin.rig.cameras[0].pose.inverse(), rig.cameras[0].pose
    return points_of_sheet((twin.maps[0], twin.maps[state]), measurement, compose(there, own))


def points_of_sheet(
    maps: tuple[SplineMap, SplineMap], measurement: Measurement, body_from_reference: RigidTransform
) -> TwinPoints:
    """Find the truth at every point that was measured of a sheet that was flat before.

    Parameters
    ----------
    maps : (SplineMap, SplineMap)
        Where the material was and is, in the frame of the body.
    measurement : Measurement
        See :func:`twin_points`.
    body_from_reference : RigidTransform
        From the frame of the reference positions.
    """
    ok = measurement.arrays["status"] == PointStatus.OK
    before = body_from_reference.apply(measurement.reference[ok])
    moved = body_from_reference.rotate(measurement.arrays["displacement"][ok])
    material = before[:, :2]
    first, _ = map_points(maps[0], material)
    last, slope = map_points(maps[1], material)
    green = (np.swapaxes(slope, 1, 2) @ slope - np.eye(2)) / 2
    strain = np.stack([measurement.arrays[name][ok] for name in ("E1", "E2")], axis=1)
    return TwinPoints(material, moved, last - first, strain, principal(green)[0])


def error_figures(points: TwinPoints) -> dict[str, dict[str, float]]:
    """Mean, standard deviation and largest of the errors of u, v, w (mm), E1 and E2."""
    strains = points.strain - points.true_strain
    columns = dict(zip(NAMES, points.error.T, strict=True))
    columns |= dict(zip(("E1", "E2"), strains.T, strict=True))
    return {name: spread_of(values) for name, values in columns.items()}


def between_methods(points: TwinPoints, benchmark: TwinPoints) -> dict[str, dict[str, float]]:
    """Figures of one method against another, where both measured: u, v, w, mm."""
    field = LinearNDInterpolator(benchmark.material, benchmark.displacement)
    off = points.displacement - field(points.material)
    return {name: spread_of(off[:, k]) for k, name in enumerate(NAMES)}


def spread_of(values: Floats) -> dict[str, float]:
    """Mean, standard deviation, their sum in size, and the largest of values, without NaN."""
    values = values[np.isfinite(values)]
    if not values.size:
        return dict.fromkeys(("mean", "std", "sum", "largest"), float("nan"))
    mean, std = float(values.mean()), float(values.std())
    return {
        "mean": mean,
        "std": std,
        "sum": abs(mean) + std,
        "largest": float(np.abs(values).max()),
    }
