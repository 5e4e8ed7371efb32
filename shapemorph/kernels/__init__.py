"""Compiled inner loops: arrays and scalars in, arrays out.

Contract of every kernel: C-contiguous arrays and scalars, no Python objects, no
exceptions, no defaults; out of range is NaN (or -1 for an index), never a number
that could be a measurement.

numba's disk cache watches only the file of the function that is called, so a change
in a helper elsewhere would go unnoticed. The cache is therefore keyed by the text of
all kernels together, and of the status codes that they take for constants, also in a
folder that NUMBA_CACHE_DIR names.
"""

import hashlib
import os
from pathlib import Path

import numba
from platformdirs import user_cache_dir

from shapemorph.kernels.cache_files import guard_cache
from shapemorph.kernels.late_blas import load_array_functions

load_array_functions()
guard_cache()
_here = Path(__file__).parent
_read = [*sorted(_here.glob("*.py")), _here.parent / "core" / "status.py"]
_key = hashlib.sha256(b"".join(path.read_bytes() for path in _read)).hexdigest()[:12]
_folder = Path(os.environ.get("NUMBA_CACHE_DIR") or user_cache_dir("shapemorph"))
numba.config.CACHE_DIR = str(_folder / f"numba-{_key}")
