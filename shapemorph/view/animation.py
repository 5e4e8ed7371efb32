"""The shape on its way from the reference to the deformed state, coloured by strain."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.measurement import Measurement
from shapemorph.view.camera import fit_frame, outer_view, second_view
from shapemorph.view.layout import EDGE, HEAD, Heading, views_figure
from shapemorph.view.measures import MEASURES, measure_values
from shapemorph.view.render import Scene
from shapemorph.view.style import colour_scale
from shapemorph.view.theme import THEMES, drawn

Film: TypeAlias = NDArray[np.uint8]

COUNT = 31
WIDTH, HEIGHT = 560, 440
"""Largest size of the shape in a picture, px."""
TILT = 0.85
"""Angle from the mean normal, radians."""


def strain_film(measurement: Measurement) -> Film | None:
    """Render the measured surface in equal steps along its displacement.

    Every point keeps the colour of its E1 in the deformed state; points go straight.

    Returns
    -------
    (N, H, W, 3) uint8 or None
        Of even height and width; None where no cell was measured.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    if not len(measurement.cells):
        return None
    used, corners = np.unique(measurement.cells, return_inverse=True)
    cells = corners.reshape(-1, 4)
    start = measurement.reference[used]
    way = measurement.arrays["displacement"][used]
    measure = next(one for one in MEASURES if one.key == "E1")
    values = measure_values(measurement, measure)[used]
    scale = colour_scale(values)
    view = second_view(outer_view(start + way, cells), start + way, TILT)
    frame = fit_frame(np.concatenate([start, start + way]), view, width=WIDTH, height=HEIGHT)
    pictures = []
    with Scene() as scene:
        for share in np.linspace(0.0, 1.0, COUNT):
            scene.clear("the measured field")
            scene.add_coloured(start + share * way, cells).paint(values, scale)
            pictures.append(scene.picture(view, frame))
    heading = Heading(
        "From the reference to the deformed shape",
        f"Colours: {measure.title}, as it is in the end.",
    )
    figure = views_figure(pictures[-1:], ("",), heading, scale=scale, label=measure.label)
    around = drawn(figure, THEMES["light"])
    height, width = (length // 2 * 2 for length in around.shape[:2])
    film = np.repeat(around[None, :height, :width], COUNT, axis=0)
    for sheet, picture in zip(film, pictures, strict=True):
        sheet[HEAD : HEAD + picture.height, EDGE : EDGE + picture.width] = picture.pixels
    return film
