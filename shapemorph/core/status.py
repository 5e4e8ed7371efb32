"""Why a point has no value."""

from enum import IntEnum

import numpy as np

from shapemorph.core.arrays import Codes


class PointStatus(IntEnum):
    """Fate of one point; 0 is the only one that carries numbers."""

    OK = 0
    OUTSIDE_MASK = 1
    NOT_SEEDED = 2
    LEFT_IMAGE = 3
    LOW_CONTRAST = 4
    NOT_CONVERGED = 5
    LOW_ZNCC = 6
    OUTLIER = 7
    DEGENERATE_FACET = 8


def count_statuses(status: Codes) -> dict[str, int]:
    """Count the points of each status, by name, in the order of the codes."""
    counts = np.bincount(status.ravel(), minlength=len(PointStatus))
    return {code.name: int(counts[code]) for code in PointStatus if counts[code]}
