"""One camera by itself: closed form, then all its pictures together."""

from collections.abc import Sequence

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.calibration import Sighting, View
from shapemorph.core.camera import Camera
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.bundle import adjust, free_lens
from shapemorph.methods.cameras.bundle_model import Arrangement, observations_of
from shapemorph.methods.cameras.closed_form import (
    decompose_projection,
    fit_homography,
    fit_projection,
    pose_of_plane,
    pose_of_points,
    zhang_matrix,
)

_ENOUGH_VIEWS = 3  # of a plane, for the principal point


def calibrate_one(
    sightings: Sequence[Sighting], views: Sequence[View], size: tuple[int, int], lens: Bools
) -> tuple[Camera, list[RigidTransform], list[Floats]]:
    """Calibrate a camera from all its sightings, each with a place of its own.

    Parameters
    ----------
    sightings : sequence of Sighting
        Of this camera.
    views : sequence of View
    size : (int, int)
        Width and height of its pictures, px.
    lens : (10,) bool
        Which unknowns of the lens are sought.

    Returns
    -------
    camera : Camera
        In its own frame.
    poses : list of RigidTransform
        camera_from_target for each sighting.
    residuals : list of (N, 2)
        Seen minus predicted, px.

    Raises
    ------
    DataError
        If there is too little to start from.
    StageError
        If the pictures do not settle the unknowns.
    """
    own = [Sighting(0, number, seen.ids, seen.pixels) for number, seen in enumerate(sightings)]
    places = [views[seen.view] for seen in sightings]
    matrix = _first_matrix(own, places, size)
    camera = Camera(size, np.array([matrix[0, 0], matrix[1, 1]]), matrix[:2, 2].copy())
    poses = [place_target(camera, seen, view) for seen, view in zip(own, places, strict=True)]
    start = Arrangement((camera,), tuple(poses))
    seen = observations_of(own, places)
    rough = lens & free_lens(radial=1, tangential=False, skew=False)
    start = adjust(seen, start, lens=rough, fixed=0, cauchy=None).arrangement
    found = adjust(seen, start, lens=lens, fixed=0, cauchy=None)
    ends = np.cumsum([len(one.ids) for one in own])[:-1]
    return (
        found.arrangement.cameras[0],
        list(found.arrangement.poses),
        np.split(found.residuals, ends),
    )


def _first_matrix(
    sightings: Sequence[Sighting], views: Sequence[View], size: tuple[int, int]
) -> Floats:
    flat, solid = [], []
    for seen, view in zip(sightings, views, strict=True):
        points = view.target.points[seen.ids]
        if view.target.is_flat:
            flat.append(fit_homography(points[:, :2], seen.pixels))
        else:
            solid.append(fit_projection(points, seen.pixels))
    if solid and len(flat) < _ENOUGH_VIEWS:
        return decompose_projection(solid[0])[0]
    return zhang_matrix(flat, size)


def place_target(camera: Camera, seen: Sighting, view: View) -> RigidTransform:
    """Find camera_from_target in closed form.

    Raises
    ------
    DataError
        With too few points.
    """
    points = view.target.points[seen.ids]
    flat = camera.normalised(seen.pixels)
    known = np.isfinite(flat).all(axis=1)
    points, flat = points[known], flat[known]
    try:
        if view.target.is_flat:
            return pose_of_plane(fit_homography(points[:, :2], flat), np.eye(3))
        return pose_of_points(points, flat)
    except DataError as error:
        raise DataError(f"{view.name}: {error}") from error
