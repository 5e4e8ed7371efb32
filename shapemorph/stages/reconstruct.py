"""Stage `reconstruct`: two views of one state to a surface in space."""

import numpy as np

from shapemorph.config import ReconstructConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Rig
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.methods.cameras.grid_surface import place_grid, smooth_disparities
from shapemorph.methods.cameras.orientation import epipolar_distance, orient
from shapemorph.methods.cameras.relative import compose
from shapemorph.methods.cameras.triangulation import triangulate

CONTRADICTS = 3.0  # px: with a median so far off, the calibration is not of these pictures
_SAMPLE = 500


def reconstruct(rig: Rig, grid: CorrelationGrid, config: ReconstructConfig) -> Reconstruction:
    """Triangulate the points that two cameras see.

    Parameters
    ----------
    rig : Rig
        Of two cameras.
    grid : CorrelationGrid
        From the picture of the first camera into that of the second.
    config : ReconstructConfig
        Section ``reconstruct``.

    Raises
    ------
    DataError
        If the calibration contradicts the pictures.
    StageError
        If no point has a place.
    """
    if len(rig.cameras) != 2:
        raise DataError(f"expected a calibration of two cameras, got {len(rig.cameras)}")
    if config.orient:
        rig = oriented(rig, grid)
    refuse_contradiction(rig, grid)
    smoothed = None
    if config.smooth:
        grid, smoothed = smooth_disparities(grid)
    found = place_grid(rig, grid, limit=config.max_epipolar, smoothed=smoothed)
    if not (found.status == PointStatus.OK).any():
        raise StageError(
            "no matched point lies before both cameras and near its epipolar line: check the "
            "calibration, or raise reconstruct.max_epipolar"
        )
    return found


def oriented(rig: Rig, grid: CorrelationGrid) -> Rig:
    """Find anew how the second camera stands to the first."""
    ok = grid.status == PointStatus.OK
    first, second = rig.cameras
    motion = orient(first, second, grid.reference_px[ok], grid.deformed_px[ok])
    return Rig((first, second.placed(compose(motion, first.pose))), rig.names)


def refuse_contradiction(rig: Rig, grid: CorrelationGrid) -> None:
    """Raise if what both cameras see cannot be so with this calibration.

    Raises
    ------
    DataError
        Saying whether the cameras are swapped.
    """
    ok = grid.status == PointStatus.OK
    seen, matched = grid.reference_px[ok], grid.deformed_px[ok]
    step = max(1, len(seen) // _SAMPLE)
    seen, matched = seen[::step], matched[::step]
    off = _typical(rig, seen, matched)
    swapped = _typical(Rig(rig.cameras[::-1], rig.names), seen, matched)
    if off > CONTRADICTS and swapped < off / CONTRADICTS:
        raise DataError(
            f"the pictures fit the calibration with its cameras swapped ({swapped:.2g} px off "
            f"their epipolar lines instead of {off:.2g}): name the picture of {rig.names[0]} first"
        )
    if off > CONTRADICTS:
        raise DataError(
            f"the calibration contradicts the pictures: points lie {off:.2g} px off their epipolar "
            "lines: was the rig moved, or is it another? calibrate again, or set "
            "reconstruct.orient=true"
        )


def _typical(rig: Rig, seen: Floats, matched: Floats) -> float:
    """Median distance from the epipolar lines, px; infinite if points lie behind the cameras."""
    points = triangulate(rig.cameras, np.stack([seen, matched]), np.ones((2, *seen.shape))).points
    if np.isfinite(points).all(axis=1).mean() < 0.5:
        return float("inf")
    return float(np.nanmedian(epipolar_distance(rig, seen, matched)))
