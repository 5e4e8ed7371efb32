"""Windows off screen: what comes of a machine that cannot draw."""

import sys

import numpy as np
import pytest

from shapemorph.core.errors import StageError
from shapemorph.view import window
from shapemorph.view.window import open_window, require_picture


def test_no_pixels_at_all_are_an_error_that_names_the_doctor():
    with pytest.raises(StageError, match="got none: run `shapemorph doctor`"):
        require_picture(np.zeros((0, 0, 3), np.uint8), "a plate")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is of Linux")
def test_a_machine_without_egl_gets_a_message_not_a_crash(monkeypatch):
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    monkeypatch.setattr(window, "_loads", lambda library: library != "libEGL.so.1")
    with pytest.raises(StageError, match=r"found no libEGL\.so\.1: run `shapemorph doctor`"):
        open_window()
