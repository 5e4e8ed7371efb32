"""Compiled inner loops: arrays and scalars in, arrays out.

Contract of every kernel: C-contiguous arrays and scalars, no Python objects, no
exceptions, no defaults; out of range is NaN (or -1 for an index), never a number
that could be a measurement.

numba's disk cache watches only the file of the function that is called, so a change
in a helper elsewhere would go unnoticed. The cache is therefore keyed by the text of
all kernels together.
"""

import hashlib
import os
from pathlib import Path

import numba
from platformdirs import user_cache_dir

from shapemorph.kernels.cache_files import guard_cache

guard_cache()
_sources = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
_key = hashlib.sha256(_sources).hexdigest()[:12]
if "NUMBA_CACHE_DIR" not in os.environ:
    numba.config.CACHE_DIR = str(Path(user_cache_dir("shapemorph")) / f"numba-{_key}")
