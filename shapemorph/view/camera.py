"""From where a shape is looked at: parallel projection, so that lengths can be read off."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints

MARGIN = 1.06
"""Room around the shape, so that it does not touch the edge of its picture."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A direction to look along.

    Attributes
    ----------
    toward : (3,) float64
        Unit vector from the shape to the camera.
    up : (3,) float64
        Unit vector that points up in the picture, perpendicular to `toward`.
    """

    toward: Floats
    up: Floats

    @property
    def right(self) -> Floats:
        """(3,) unit vector that points right in the picture."""
        return np.cross(self.up, self.toward)

    def project(self, points: Floats) -> Floats:
        """(N, 2) mm right and up of points (N, 3)."""
        return points @ np.stack([self.right, self.up], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The window on the shape.

    Attributes
    ----------
    centre : (3,) float64
        Point in the middle of the picture, mm.
    width, height : int
        px.
    mm_per_px : float
    """

    centre: Floats
    width: int
    height: int
    mm_per_px: float


def outer_view(points: Floats, cells: Ints) -> View:
    """Look at a surface from its outer side, along its mean normal.

    Parameters
    ----------
    points : (N, 3)
        mm.
    cells : (M, 3) or (M, 4)
        Row numbers, counter-clockwise seen from the outer side.

    Returns
    -------
    View
        The y axis of the file points up, or z where y points at the camera. A surface
        that goes around (a tube) has no mean normal: it is seen from its broad side.
    """
    corners = points[cells]
    if cells.shape[1] == 4:
        normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    else:
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = normals.sum(axis=0)
    if np.linalg.norm(total) <= 0.1 * np.linalg.norm(normals, axis=1).sum():
        total = _broad_side(corners.reshape(-1, 3))
    return _upright(total / np.linalg.norm(total))


def _broad_side(points: Floats) -> Floats:
    """Direction (3,) in which a cloud of points extends least, largest component positive."""
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    axis: Floats = axes[2] * np.sign(axes[2][np.abs(axes[2]).argmax()])
    return axis


def _upright(toward: Floats) -> View:
    """Choose what points up for a camera in the given direction."""
    axis = np.array([0.0, 1.0, 0.0]) if abs(toward[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    up = axis - (axis @ toward) * toward
    return View(toward, up / np.linalg.norm(up))


def second_view(view: View, points: Floats, angle: float) -> View:
    """Move the camera by an angle in radians to where it shows the form.

    Parameters
    ----------
    points : (N, 3)
        The shape. One that is taller than wide is seen from the right, as a face in
        half profile; others from below, as a bulge that rises from a table.
    """
    across, along = np.ptp(view.project(points), axis=0)
    cos, sin = np.cos(angle), np.sin(angle)
    if along > 1.15 * across:
        return View(cos * view.toward + sin * view.right, view.up)
    return View(cos * view.toward - sin * view.up, sin * view.toward + cos * view.up)


def fit_frame(points: Floats, view: View, *, width: int, height: int) -> Frame:
    """Choose the window of at most the given size in px that a shape fills.

    Parameters
    ----------
    points : (N, 3)
        All that has to be in the picture, mm.
    """
    flat = view.project(points)
    low, high = flat.min(axis=0), flat.max(axis=0)
    across, along = np.maximum(high - low, 1e-9 * max(1.0, float((high - low).max()))) * MARGIN
    mm_per_px = float(max(across / width, along / height))
    middle = (low + high) / 2
    depth = float((points @ view.toward).mean())
    centre = middle[0] * view.right + middle[1] * view.up + depth * view.toward
    narrow = [max(64, int(np.ceil(extent / mm_per_px))) for extent in (across, along)]
    return Frame(centre, min(width, narrow[0]), min(height, narrow[1]), mm_per_px)
