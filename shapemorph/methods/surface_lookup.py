"""From places in a flattened picture to places on the mesh, exactly."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.image import CalibratedImage, Chart, SurfacePoints
from shapemorph.core.mesh import TexturedMesh
from shapemorph.kernels import locate as locate_kernel
from shapemorph.kernels.blend import blend_corners
from shapemorph.methods.chart_index import index_chart
from shapemorph.methods.shading import map_under_image, prepare_shader


def locate(image: CalibratedImage, points_px: Floats) -> SurfacePoints:
    """Find the place on the mesh under points of a calibrated image.

    Parameters
    ----------
    image : CalibratedImage
    points_px : (N, 2)
        (x, y) in px, anywhere; NaN is off the surface.

    Returns
    -------
    SurfacePoints
        Face -1 and NaN weights off the surface.
    """
    chart = image.chart
    points = np.ascontiguousarray(points_px, dtype=np.float64)
    triangle, pair = locate_kernel.locate(*index_chart(chart).arguments, points)
    return SurfacePoints(_mesh_faces(chart, triangle), _three_weights(pair))


def pixel_points(image: CalibratedImage) -> SurfacePoints:
    """Give the place on the mesh of every pixel, row by row (H * W points)."""
    triangle = image.triangle.ravel().astype(np.int64)
    return SurfacePoints(
        _mesh_faces(image.chart, triangle), _three_weights(image.barycentric.reshape(-1, 2))
    )


def _mesh_faces(chart: Chart, triangle: Ints) -> Ints:
    faces: Ints = np.where(triangle >= 0, chart.face_ids[triangle], -1)
    return faces


def _three_weights(pair: Floats) -> Floats:
    return np.stack([1.0 - pair[:, 0] - pair[:, 1], pair[:, 0], pair[:, 1]], axis=1)


def positions(mesh: TexturedMesh, points: SurfacePoints) -> Floats:
    """Give the positions of points on a mesh.

    Returns
    -------
    (N, 3)
        mm, in the frame of the mesh; NaN off the surface.
    """
    corners = mesh.vertices[mesh.faces[points.face]]
    own = np.where(points.face >= 0, np.arange(len(points.face)), -1).astype(np.int32)
    pair = np.ascontiguousarray(points.barycentric[:, 1:])
    placed: Floats = blend_corners(corners, own, pair)
    return placed


def project(image: CalibratedImage, points: SurfacePoints) -> Floats:
    """Give the place in a calibrated image of points on its mesh.

    Returns
    -------
    (N, 2)
        px; NaN for points whose face the chart does not hold.
    """
    chart = image.chart
    of_face = np.full(max(int(chart.face_ids.max()), int(points.face.max())) + 2, -1)
    of_face[chart.face_ids] = np.arange(len(chart.face_ids))
    triangle = of_face[points.face]
    placed: Floats = np.einsum("nk,nkd->nd", points.barycentric, chart.corner_px[triangle])
    placed[triangle < 0] = np.nan
    return placed


def pixel_positions(mesh: TexturedMesh, image: CalibratedImage) -> Floats:
    """Give the position of every pixel of a calibrated image.

    Returns
    -------
    (H, W, 3)
        mm, in the frame of the mesh; NaN outside the mask.
    """
    corners = mesh.vertices[mesh.faces[image.chart.face_ids]]
    pair = image.barycentric.reshape(-1, 2)
    placed: Floats = blend_corners(corners, image.triangle.ravel(), pair)
    return placed.reshape(*image.triangle.shape, 3)


def grey_at(mesh: TexturedMesh, image: CalibratedImage, points_px: Floats) -> tuple[Greys, Bools]:
    """Read the grey under points of a calibrated image straight from the texture.

    One interpolation, averaged over a square of 1 px around each point: at a pixel
    centre it is the grey of that pixel.

    Parameters
    ----------
    mesh : TexturedMesh
    image : CalibratedImage
        Of that mesh.
    points_px : (N, 2)

    Returns
    -------
    grey : (N,)
        NaN off the surface.
    inside : (N,)
    """
    points = np.ascontiguousarray(points_px, dtype=np.float64)
    shader = prepare_shader(mesh, image.chart, map_under_image(mesh, image))
    grey, triangle = shader.shade(points, np.eye(2)[None])
    return grey, triangle >= 0
