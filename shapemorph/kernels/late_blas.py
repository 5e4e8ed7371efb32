"""numba without SciPy's linear algebra as long as no kernel calls it.

When numba loads its array functions it asks whether SciPy's BLAS is there, and loads all of
``scipy.linalg`` to know. SciPy is a requirement of this package, so the answer is known. A
function that does call BLAS has it loaded when it is compiled.
"""

from importlib import import_module

from numba.np import linalg


def load_array_functions() -> None:
    """Load numba's array functions without asking for BLAS, where that is how numba asks."""
    ask = getattr(linalg, "ensure_blas", None)
    if ask is None:
        return
    linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ask
