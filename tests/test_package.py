"""The package itself: light, and with the names that it promises."""

import subprocess
import sys

import pytest

import shapemorph

HEAVY = {"numpy", "scipy", "numba", "cv2", "pyvista", "pydantic", "yaml", "distributed", "PIL"}


def test_import_loads_nothing_heavy():
    code = "import sys, shapemorph; dir(shapemorph); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(done.stdout.split())


def test_the_api_itself_loads_nothing_heavy_until_it_is_used():
    code = "import sys, shapemorph; shapemorph.measure, shapemorph.load; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(done.stdout.split())


def test_names_that_are_not_there_are_attribute_errors():
    assert {"measure", "load", "Result"} <= set(dir(shapemorph))
    with pytest.raises(AttributeError, match="no attribute 'mesure'"):
        _ = shapemorph.mesure
