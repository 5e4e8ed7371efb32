"""Grey levels from numbers in files whose full range nobody states."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.methods.colour_content import CHANNELS

_RANGES = (1.0, 255.0, 65535.0)


def grey_of(values: NDArray[Any], *, name: str, channel: str = "luma") -> Floats:
    """Turn stored grey (N,) or colour (N, 3) into grey (N,) in [0, 1].

    Bytes and 16-bit words count by their full range; other numbers by the smallest of 1, 255
    and 65535 that holds them all. Colour becomes grey by one of
    :data:`~shapemorph.methods.colour_content.CHANNELS`.

    Raises
    ------
    DataError
        If a value is negative, not finite or above 65535.
    """
    plain = values.astype(np.float64)
    if not np.isfinite(plain).all() or plain.min(initial=0.0) < -1e-9:
        raise DataError(
            f"{name}: expected grey or colour from 0 to 1, 255 or 65535, got a negative or "
            "infinite value: export them in one of these ranges"
        )
    largest = float(plain.max(initial=0.0))
    if values.dtype in (np.dtype(np.uint8), np.dtype(np.uint16)):
        full = float(np.iinfo(values.dtype).max)
    else:
        full = next((limit for limit in _RANGES if largest <= limit * (1 + 1e-6)), 0.0)
    if full == 0.0:
        raise DataError(
            f"{name}: expected grey or colour from 0 to 1, 255 or 65535, got {largest:.6g}: "
            "export them in one of these ranges"
        )
    grey: Floats = np.clip(
        (plain @ CHANNELS[channel] if plain.ndim == 2 else plain) / full, 0.0, 1.0
    )
    return grey
