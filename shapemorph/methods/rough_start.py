"""A first warp from what is known beforehand: marks, or a model of the deformation."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import Dots, NodalField
from shapemorph.core.matching import Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.closest_point import closest_points
from shapemorph.methods.densify import grid_points
from shapemorph.methods.laws.finite_elements import place_field
from shapemorph.methods.laws.settling import settle_warp
from shapemorph.methods.surface_lookup import locate, positions, project
from shapemorph.methods.warp_fit import fit_warp

STIFFNESS = 1e-3  # of a warp through marks
ENOUGH_DOTS = 3
LEAST_SPREAD = 0.02  # of their length: marks on a thinner line fix no warp
NODES = 12  # of the warp along the longer side of the picture
POINTS = 900  # that a model is asked about
NEAR = 0.1  # of the size of the object: farther from its surface a model is in another frame

SurfacePicture = tuple[TexturedMesh, CalibratedImage]


def place_in_picture(surface: SurfacePicture, points: Floats) -> Floats:
    """(N, 2) places in a picture, px, of the points of its surface nearest to some in space."""
    mesh, image = surface
    return project(image, closest_points(mesh, points, np.unique(image.chart.face_ids)))


def dots_of_landmarks(
    landmarks: Landmarks, reference: SurfacePicture, deformed: SurfacePicture
) -> Dots:
    """Find landmarks of two shapes in their pictures."""
    return Dots(
        place_in_picture(reference, landmarks.reference),
        place_in_picture(deformed, landmarks.deformed),
    )


def dots_of_field(field: NodalField, reference: SurfacePicture, deformed: SurfacePicture) -> Dots:
    """Ask a model where a grid of the reference picture goes.

    Both files are taken to have one frame, since nothing is matched yet; where the model
    then misses the deformed surface it says nothing.
    """
    mesh, image = reference
    mask = image.image.mask
    pixels = grid_points(mask, float(np.sqrt(mask.sum() / POINTS)))
    places = positions(mesh, locate(image, pixels))
    on = np.isfinite(places).all(axis=1)
    moved = place_field(field, np.zeros((0, 3)), np.zeros((0, 3)))(places[on])
    found = closest_points(deformed[0], moved, np.unique(deformed[1].chart.face_ids))
    off = np.linalg.norm(positions(deformed[0], found) - moved, axis=1)
    near = off < NEAR * deformed[0].size
    return Dots(pixels[on][near], project(deformed[1], found)[near])


def settled_dots(reference: GreyImage, deformed: GreyImage, dots: Dots) -> Dots | None:
    """Search a grid of the reference through a warp that some known pairs describe.

    Parameters
    ----------
    reference, deformed : GreyImage
    dots : Dots
        Roughly right; rows with a NaN are left out.

    Returns
    -------
    Dots or None
        Many pairs that the pictures agree with; None where the known ones lead nowhere.
    """
    warp = _warp_through(dots, reference.shape)
    if warp is None:
        return None
    nothing = np.zeros((0, 2)), np.zeros((0, 2))
    for near in (True, False):
        try:
            settled = settle_warp(reference, deformed, warp, nothing, near=near)
        except StageError:
            continue
        return Dots(settled.source, settled.target)
    return None


def _warp_through(dots: Dots, shape: tuple[int, int]) -> Warp | None:
    """Smooth warp of a whole picture through known pairs; None where they fix none."""
    source, target = dots.reference_px, dots.deformed_px
    good = np.isfinite(source).all(axis=1) & np.isfinite(target).all(axis=1)
    source, target = source[good], target[good]
    if len(source) < ENOUGH_DOTS:
        return None
    extent = np.linalg.svd(source - source.mean(axis=0), compute_uv=False)
    if extent[1] < LEAST_SPREAD * extent[0]:
        return None
    spacing = max(shape) / NODES
    high = np.array(shape[::-1]) - 1.0
    return fit_warp(
        source,
        target,
        extent=(-np.full(2, spacing), high + spacing),
        spacing=spacing,
        smoothing=STIFFNESS,
    )
