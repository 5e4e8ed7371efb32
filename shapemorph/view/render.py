"""Pictures of shapes, rendered off screen."""

import ctypes
import ctypes.util
import os
import sys
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.mesh import TexturedMesh
from shapemorph.view.camera import Frame, View, fit_frame
from shapemorph.view.style import BARE, PAPER, ColourScale, reduced

Pixels = np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]

_WINDOW, _EGL = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"
MAX_TEXTURE = 2048
"""Larger textures are reduced to this width: pictures of shapes are smaller still."""
FINEST = 1200
"""Texels along the size of a shape that a picture of it can show; more are averaged."""
LIFT_SHARE = 0.01
"""The bare surface lies this share of its size behind the measured one, so that they do not
shimmer through each other; in parallel projection that moves nothing sideways."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A rendered view.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
    mm_per_px : float
    """

    pixels: Pixels
    mm_per_px: float


ADVICE = "run `shapemorph doctor` to see what is missing, or set report.figures to false"


def import_pyvista() -> Any:
    """Import pyvista such that it asks for no screen.

    VTK reads the variable when it opens a window: through EGL it renders in software
    and does not complain about a missing X server.
    """
    if sys.platform.startswith("linux"):
        os.environ.setdefault(_WINDOW, _EGL)
    import pyvista

    return pyvista


def open_window() -> Any:
    """Open a pyvista plotter off screen, unless rendering in it would end the process.

    Where EGL or its driver is missing, VTK falls back to OSMesa and crashes at the first
    picture when that is missing too.

    Raises
    ------
    StageError
        There is no OpenGL to draw with.
    """
    pyvista = import_pyvista()
    wants_egl = os.environ.get(_WINDOW) == _EGL
    if wants_egl and not _loads("libEGL.so.1"):
        raise StageError(f"expected OpenGL to draw pictures, found no libEGL.so.1: {ADVICE}")
    plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64), lighting="none")
    kind = plotter.render_window.GetClassName()
    if kind == "vtkOSOpenGLRenderWindow" and ctypes.util.find_library("OSMesa") is None:
        raise StageError(f"expected OpenGL to draw pictures, found no driver: {ADVICE}")
    return plotter


def _loads(library: str) -> bool:
    """Whether the system has a shared library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def require_picture(pixels: Pixels | None, name: str) -> Pixels:
    """Return the pixels of a screenshot, unless there is nothing to see.

    Raises
    ------
    StageError
        Off-screen rendering gave nothing or one colour only: VTK does so, without an
        error, where the system has no OpenGL.
    """
    if pixels is None or pixels.size == 0:
        raise StageError(f"expected a rendered picture of {name}, got none: {ADVICE}")
    if (pixels == pixels[0, 0]).all():
        raise StageError(f"expected a rendered picture of {name}, got a blank one: {ADVICE}")
    return pixels


class Scene:
    """A shape in front of a camera; use it in a ``with`` block, which closes the window.

    One window serves many pictures: opening it takes most of the time.
    """

    def __init__(self) -> None:
        self._name = "nothing"
        self._bare: Any = None
        self._corners: list[Floats] = []
        self._plotter = open_window()
        self._plotter.background_color = PAPER
        self._plotter.render_window.SetMultiSamples(0)  # three times faster in software
        self._plotter.add_light(import_pyvista().Light(light_type="headlight"))
        self._plotter.enable_parallel_projection()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._plotter.close()

    def clear(self, name: str) -> None:
        """Take everything out to make room for what messages then call `name`."""
        self._plotter.clear_actors()
        self._name, self._bare, self._corners = name, None, []

    def add_coloured(self, points: Floats, cells: Ints) -> "Painter":
        """Add a surface of triangles or quads with a colour per point, to be painted."""
        surface = _polydata(points, cells)
        surface["colour"] = np.zeros((len(points), 3), dtype=np.uint8)
        self._add_mesh(surface, scalars="colour", rgb=True, smooth_shading=True)
        self._corners.append(points[np.unique(cells)])
        return Painter(surface)

    def add_bare(self, points: Floats, faces: Ints) -> None:
        """Add a surface of triangles in plain grey, behind everything else and not framed."""
        surface = _polydata(points, faces)
        self._bare = self._add_mesh(surface, color=BARE, smooth_shading=True)

    def add_textured(self, mesh: TexturedMesh) -> None:
        """Add a mesh with its own grey pattern."""
        corners = mesh.vertices[mesh.faces].reshape(-1, 3)
        triangles = np.arange(len(corners)).reshape(-1, 3)
        self._corners.append(mesh.vertices)
        if not mesh.has_texture:
            surface = _polydata(corners, triangles)
            surface["grey"] = np.repeat((255 * mesh.corner_grey.reshape(-1, 1)), 3, axis=1).astype(
                np.uint8
            )
            self._add_mesh(surface, scalars="grey", rgb=True)
            return
        for index, texture in enumerate(mesh.textures):
            chosen = mesh.face_texture == index
            if chosen.any():
                surface = _polydata(
                    mesh.vertices[mesh.faces[chosen]].reshape(-1, 3),
                    triangles[: np.count_nonzero(chosen)],
                )
                surface.active_texture_coordinates = mesh.wedge_uv[chosen].reshape(-1, 2)
                shown = reduced(texture, _longest(mesh, chosen, texture))
                self._add_mesh(surface, texture=_texture(shown))

    def _add_mesh(self, surface: Any, **look: Any) -> Any:
        """Add a surface to the scene; light shows its form and changes colours little."""
        light = {"ambient": 0.75, "diffuse": 0.25, "specular": 0.0, "smooth_shading": False}
        return self._plotter.add_mesh(
            surface, show_scalar_bar=False, render=False, **(light | look)
        )

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
            self._bare.position = tuple(-LIFT_SHARE * extent * view.toward)
        plotter, camera = self._plotter, self._plotter.camera
        plotter.render_window.SetSize(frame.width, frame.height)  # the setter would render
        camera.focal_point = tuple(frame.centre)
        camera.position = tuple(frame.centre + 4 * extent * view.toward)
        camera.up = tuple(view.up)
        camera.parallel_scale = 0.5 * frame.height * frame.mm_per_px
        camera.clipping_range = (extent, 7 * extent)
        plotter.render()
        pixels = plotter.screenshot(return_img=True)
        return Picture(require_picture(pixels, self._name), frame.mm_per_px)


class Painter:
    """Gives a surface that stands in a scene its colours."""

    def __init__(self, surface: Any) -> None:
        self._surface = surface

    def paint(self, values: Floats, scale: ColourScale) -> None:
        """Colour the points by values (N,); grey where NaN."""
        self._surface["colour"][:] = scale.colours(values)
        self._surface.Modified()


def _longest(mesh: TexturedMesh, chosen: Bools, texture: Greys) -> int:
    """Width, px, to which a texture may be reduced before a picture of the mesh shows it."""
    corners, uv = mesh.vertices[mesh.faces[chosen]], mesh.wedge_uv[chosen]
    sides, flat = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
    share = 0.5 * np.abs(np.linalg.det(flat)).sum()
    if not (area > 0 and share > 0):
        return MAX_TEXTURE
    texels_across = mesh.size * np.sqrt(share * texture.size / area)
    return min(MAX_TEXTURE, int(np.ceil(max(texture.shape) * FINEST / texels_across)))


def _polydata(points: Floats, cells: Ints) -> Any:
    """Make the VTK surface of triangles (M, 3) or quads (M, 4)."""
    pyvista = import_pyvista()
    return pyvista.PolyData.from_regular_faces(points, cells)


def _texture(grey: Greys) -> Any:
    """Make the VTK texture of a grey picture, smooth where it is drawn smaller."""
    pyvista = import_pyvista()
    levels = np.clip(255 * grey + 0.5, 0, 255).astype(np.uint8)
    texture = pyvista.Texture(np.repeat(levels[..., None], 3, axis=2))
    texture.interpolate = True
    texture.mipmap = True
    return texture
