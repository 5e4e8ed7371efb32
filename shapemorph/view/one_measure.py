"""One array of a measurement on one of its two shapes."""

from typing import TYPE_CHECKING

from shapemorph.core.arrays import Floats, Ints
from shapemorph.view.camera import outer_view, second_view
from shapemorph.view.layout import Heading, views_figure
from shapemorph.view.render import Scene
from shapemorph.view.style import colour_scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT, _TILT = 620, 500, 0.85
_CAPTIONS = ("along the mean normal", "from one side")


def field_figure(
    points: Floats, cells: Ints, values: Floats, *, heading: Heading, label: str
) -> "Figure":
    """Draw a scalar on a surface, from two sides.

    Parameters
    ----------
    points : (N, 3)
        mm; only those of cells are shown and need be finite.
    cells : (M, 4)
        Quads as row numbers, at least one.
    values : (N,)
        Grey where NaN.
    heading : Heading
    label : str
        Of the colour bar.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    import numpy as np

    used, corners = np.unique(cells, return_inverse=True)
    shown, quads = points[used], corners.reshape(-1, 4)
    scale = colour_scale(values[used])
    view = outer_view(shown, quads)
    views = (view, second_view(view, shown, _TILT))
    with Scene() as scene:
        scene.clear("the measured field")
        scene.add_coloured(shown, quads).paint(values[used], scale)
        pictures = [
            scene.picture(view, scene.frame(view, width=_WIDTH, height=_HEIGHT)) for view in views
        ]
    return views_figure(pictures, _CAPTIONS, heading, scale=scale, label=label)
