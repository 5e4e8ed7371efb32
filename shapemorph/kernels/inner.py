"""Functions that only other compiled functions call.

Nothing is compiled for calls from Python, which saves a third of the time of a first run.
"""

from functools import partial

from numba import njit

inner = partial(njit, no_cpython_wrapper=True, no_cfunc_wrapper=True, error_model="numpy")
