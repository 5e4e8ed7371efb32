"""scipy.linalg is loaded by what needs it, and by nothing else."""

import subprocess
import sys

PROGRAM = """
import sys
import numpy as np
import shapemorph.kernels.components as components

components.connect(np.array([0]), np.array([1]), 2)
assert "scipy.linalg" not in sys.modules, "a kernel"
from numba import njit

@njit
def product(a, b):
    return np.dot(a, b)

@njit
def solution(a, b):
    return np.linalg.solve(a, b)

a = np.array([[2.0, 1.0], [0.0, 4.0]])
assert (product(a, a) == a @ a).all()
assert np.allclose(solution(a, a), np.eye(2))
assert "scipy.linalg" in sys.modules, "what calls BLAS"
"""


def test_blas_is_loaded_where_it_is_called():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
