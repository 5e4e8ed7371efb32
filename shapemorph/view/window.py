"""A window of VTK off screen: opened where that can work, and read back."""

import ctypes
import ctypes.util
import os
import sys
from typing import Any

import numpy as np

from shapemorph.core.errors import StageError

Pixels = np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]

ADVICE = "run `shapemorph doctor` to see what is missing, or set report.figures to false"
_WINDOW, _EGL = "VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow"


def open_window() -> Any:
    """Open a VTK window off screen, unless rendering in it would end the process.

    VTK reads a variable when it opens a window: through EGL it renders in software and does
    not complain about a missing X server. Where EGL or its driver is missing, it falls back
    to OSMesa and crashes at the first picture when that is missing too.

    Raises
    ------
    StageError
        There is no OpenGL to draw with.
    """
    if sys.platform.startswith("linux"):
        os.environ.setdefault(_WINDOW, _EGL)
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (what the factory of windows makes)
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    if os.environ.get(_WINDOW) == _EGL and not _loads("libEGL.so.1"):
        raise StageError(f"expected OpenGL to draw pictures, found no libEGL.so.1: {ADVICE}")
    window = vtkRenderWindow()
    window.OffScreenRenderingOn()
    window.ShowWindowOff()
    window.SetMultiSamples(0)  # three times faster in software
    kind = window.GetClassName()
    if kind == "vtkOSOpenGLRenderWindow" and ctypes.util.find_library("OSMesa") is None:
        raise StageError(f"expected OpenGL to draw pictures, found no driver: {ADVICE}")
    return window


def _loads(library: str) -> bool:
    """Whether the system has a shared library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def read_pixels(window: Any) -> Pixels:
    """Pixels of a window that has been rendered, first row on top; empty where there are none."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    width, height = window.GetSize()
    content = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 0, content, 0)
    values = vtk_to_numpy(content)
    if values.size != 3 * width * height:
        return np.zeros((0, 0, 3), np.uint8)
    upright: Pixels = values.reshape(height, width, 3)[::-1].copy()
    return upright


def require_picture(pixels: Pixels, name: str) -> Pixels:
    """Return the pixels of a picture, unless there is nothing to see.

    Raises
    ------
    StageError
        Off-screen rendering gave nothing or one colour only: VTK does so, without an
        error, where the system has no OpenGL.
    """
    if pixels.size == 0:
        raise StageError(f"expected a rendered picture of {name}, got none: {ADVICE}")
    if (pixels == pixels[0, 0]).all():
        raise StageError(f"expected a rendered picture of {name}, got a blank one: {ADVICE}")
    return pixels
