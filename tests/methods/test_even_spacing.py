import numpy as np
import pytest

from shapemorph.core.flattened import Distortion
from shapemorph.methods.even_spacing import even_spacing


def _two_scales(small, share):
    """A surface of which a share of the area is shown at `small`, the rest at 4 px per mm."""
    scale = np.array([small, 4.0])
    return Distortion(scale, scale, np.array([share, 1.0 - share]))


@pytest.mark.parametrize(
    ("small", "share", "expected"),
    [
        (4.0, 0.5, 8),  # one scale
        (3.4, 0.2, 8),  # 1.18 times as far apart is nothing
        (2.4, 0.2, 6),  # 8 px x 1.25 x 2.4 / 4
        (0.4, 0.2, 4),  # never finer than half
        (0.4, 0.02, 8),  # too little of it
    ],
)
def test_spacing_is_finer_where_much_of_the_surface_is_shown_small(small, share, expected):
    assert even_spacing(8, _two_scales(small, share)) == expected


def test_flipped_triangles_have_no_say():
    distortion = Distortion(np.array([0.1, 4.0]), np.array([-0.1, 4.0]), np.array([0.4, 0.6]))
    assert even_spacing(8, distortion) == 8
