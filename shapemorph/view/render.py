"""Pictures of shapes, rendered off screen by VTK itself: pyvista takes a second to load."""

from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.mesh import TexturedMesh
from shapemorph.view.camera import Frame, View, fit_frame
from shapemorph.view.style import BARE, PAPER, ColourScale, reduced, rgb_of
from shapemorph.view.window import Pixels, open_window, read_pixels, require_picture

MAX_TEXTURE = 2048
"""Larger textures are reduced to this width: pictures of shapes are smaller still."""
SAMPLE = 10_000
"""Faces that tell how densely a texture lies on a mesh."""
FINEST = 800
"""Texels along the size of a shape that a picture of it can show; more are averaged, so that
none need be skipped: drawing from a pyramid of textures takes twice the time."""
LIFT_SHARE = 0.01
"""The bare surface lies this share of its size behind the measured one, so that they do not
shimmer through each other; in parallel projection that moves nothing sideways."""
AMBIENT, DIFFUSE = 0.75, 0.25
"""Light shows the form of a surface and changes its colours little."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A rendered view.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
    mm_per_px : float
        Of the layout.
    pixel_ratio : int
        Pixels for each pixel of the layout.
    """

    pixels: Pixels
    mm_per_px: float
    pixel_ratio: int

    @property
    def height(self) -> int:
        """In the layout, px."""
        return self.pixels.shape[0] // self.pixel_ratio

    @property
    def width(self) -> int:
        """In the layout, px."""
        return self.pixels.shape[1] // self.pixel_ratio


class Scene:
    """A shape in front of a camera; use it in a ``with`` block, which closes the window.

    One window serves many pictures: opening it takes most of the time.

    Parameters
    ----------
    pixel_ratio : int
        Pixels rendered for each pixel of a frame.
    """

    def __init__(self, pixel_ratio: int = 1) -> None:
        self._ratio = pixel_ratio
        self._window = open_window()
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer

        self._name = "nothing"
        self._bare: Any = None
        self._corners: list[Floats] = []
        self._renderer = vtkRenderer()
        self._renderer.SetBackground(*rgb_of(PAPER))
        self._renderer.GetActiveCamera().ParallelProjectionOn()
        light = vtkLight()
        light.SetLightTypeToHeadlight()
        self._renderer.AddLight(light)
        self._window.AddRenderer(self._renderer)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._window.Finalize()

    def clear(self, name: str) -> None:
        """Take everything out to make room for what messages then call `name`."""
        self._renderer.RemoveAllViewProps()
        self._name, self._bare, self._corners = name, None, []

    def add_coloured(self, points: Floats, cells: Ints) -> "Painter":
        """Add a surface of triangles or quads with a colour per point, to be painted."""
        surface = _with_normals(_polydata(points, cells))
        colours = np.zeros((len(points), 3), dtype=np.uint8)
        surface.GetPointData().SetScalars(_array(colours))
        self._add(surface)
        self._corners.append(points[np.unique(cells)])
        return Painter(surface, colours)

    def add_bare(self, points: Floats, faces: Ints) -> None:
        """Add a surface of triangles in plain grey, behind everything else and not framed."""
        self._bare = self._add(_with_normals(_polydata(points, faces)))
        self._bare.GetProperty().SetColor(*rgb_of(BARE))

    def add_textured(self, mesh: TexturedMesh) -> None:
        """Add a mesh with its own grey pattern."""
        self._corners.append(mesh.vertices)
        if not mesh.has_texture:
            corners = mesh.vertices[mesh.faces].reshape(-1, 3)
            surface = _polydata(corners, np.arange(len(corners)).reshape(-1, 3))
            grey = (255 * mesh.corner_grey.reshape(-1, 1)).astype(np.uint8)
            surface.GetPointData().SetScalars(_array(np.repeat(grey, 3, axis=1)))
            self._add(surface).GetProperty().SetInterpolationToFlat()
            return
        for chosen, texture in _parts(mesh):
            points, uv, faces = joined_corners(mesh, chosen)
            surface = _polydata(points, faces)
            surface.GetPointData().SetTCoords(_array(uv))
            actor = self._add(surface)
            finest = self._ratio * FINEST
            longest = _longest(mesh, chosen, texture, finest)
            actor.SetTexture(_texture(reduced(texture, longest)))
            actor.GetProperty().SetInterpolationToFlat()

    def _add(self, surface: Any) -> Any:
        """Add a surface to the scene."""
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputData(surface)
        actor.SetMapper(mapper)
        actor.GetProperty().SetAmbient(AMBIENT)
        actor.GetProperty().SetDiffuse(DIFFUSE)
        self._renderer.AddActor(actor)
        return actor

    def frame(self, view: View, *, width: int, height: int) -> Frame:
        """Choose the window of at most the given size, px, that all but the bare surface fills."""
        return fit_frame(np.concatenate(self._corners), view, width=width, height=height)

    def picture(self, view: View, frame: Frame) -> Picture:
        """Render what was added.

        Raises
        ------
        StageError
            The picture is blank.
        """
        extent = float(np.ptp(np.concatenate(self._corners), axis=0).max())
        if self._bare is not None:
            self._bare.SetPosition(*(-LIFT_SHARE * extent * view.toward))
        self._window.SetSize(self._ratio * frame.width, self._ratio * frame.height)
        camera = self._renderer.GetActiveCamera()
        camera.SetFocalPoint(*frame.centre)
        camera.SetPosition(*(frame.centre + 4 * extent * view.toward))
        camera.SetViewUp(*view.up)
        camera.SetParallelScale(0.5 * frame.height * frame.mm_per_px)
        camera.SetClippingRange(extent, 7 * extent)
        self._window.Render()
        pixels = require_picture(read_pixels(self._window), self._name)
        return Picture(pixels, frame.mm_per_px, self._ratio)


class Painter:
    """Gives a surface that stands in a scene its colours."""

    def __init__(
        self, surface: Any, colours: np.ndarray[tuple[int, int], np.dtype[np.uint8]]
    ) -> None:
        self._surface = surface
        self._colours = colours

    def paint(self, values: Floats, scale: ColourScale) -> None:
        """Colour the points by values (N,); grey where NaN."""
        self._colours[:] = scale.colours(values)
        self._surface.GetPointData().GetScalars().Modified()


def joined_corners(mesh: TexturedMesh, chosen: Bools) -> tuple[Floats, Floats, Ints]:
    """Make one point of the corners of some faces where vertex and place in the texture agree.

    Returns
    -------
    points : (N, 3)
        Those of all vertices first.
    uv : (N, 2)
    faces : (M, 3)
    """
    vertex, wedges = mesh.faces[chosen].ravel(), mesh.wedge_uv[chosen].reshape(-1, 2)
    uv = np.zeros((len(mesh.vertices), 2))
    uv[vertex] = wedges  # of several the last
    apart = np.flatnonzero((uv[vertex] != wedges).any(axis=1))
    corner = vertex.copy()
    corner[apart] = len(uv) + np.arange(len(apart))
    points = np.concatenate([mesh.vertices, mesh.vertices[vertex[apart]]])
    return points, np.concatenate([uv, wedges[apart]]), corner.reshape(-1, 3)


def _parts(mesh: TexturedMesh) -> Iterator[tuple[Bools, Greys]]:
    """Yield the faces under each texture that is in use, and the texture."""
    for index, texture in enumerate(mesh.textures):
        chosen: Bools = mesh.face_texture == index
        if chosen.any():
            yield chosen, texture


def _longest(mesh: TexturedMesh, chosen: Bools, texture: Greys, finest: int) -> int:
    """Width, px, of a texture that has `finest` texels along the size of the mesh."""
    some = np.flatnonzero(chosen)
    some = some[:: 1 + len(some) // SAMPLE]
    corners, uv = mesh.vertices[mesh.faces[some]], mesh.wedge_uv[some]
    sides, flat = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
    share = 0.5 * np.abs(flat[:, 0, 0] * flat[:, 1, 1] - flat[:, 0, 1] * flat[:, 1, 0]).sum()
    if not (area > 0 and share > 0):
        return MAX_TEXTURE
    texels_across = mesh.size * np.sqrt(share * texture.size / area)
    return min(MAX_TEXTURE, int(np.ceil(max(texture.shape) * finest / texels_across)))


def _array(values: np.ndarray) -> Any:
    """Make the VTK array that shares the memory of values (N, C)."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    return numpy_to_vtk(values)


def _polydata(points: Floats, cells: Ints) -> Any:
    """Make the VTK surface of triangles (M, 3) or quads (M, 4)."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    places, polygons, surface = vtkPoints(), vtkCellArray(), vtkPolyData()
    places.SetData(_array(np.ascontiguousarray(points)))
    corners = np.ascontiguousarray(cells.ravel(), dtype=np.int64)
    polygons.SetData(cells.shape[1], numpy_to_vtkIdTypeArray(corners))
    surface.SetPoints(places)
    surface.SetPolys(polygons)
    return surface


def _with_normals(surface: Any) -> Any:
    """Give a surface a normal per point, so that it is shaded as a smooth one."""
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    normals = vtkPolyDataNormals()
    normals.SetInputData(surface)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    return normals.GetOutput()


def _texture(grey: Greys) -> Any:
    """Make the VTK texture of a grey picture."""
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    levels = np.clip(255 * grey[::-1] + 0.5, 0, 255).astype(np.uint8)
    image, texture = vtkImageData(), vtkTexture()
    image.SetDimensions(levels.shape[1], levels.shape[0], 1)
    image.GetPointData().SetScalars(_array(levels.ravel()))
    texture.SetInputData(image)
    texture.InterpolateOn()
    return texture
