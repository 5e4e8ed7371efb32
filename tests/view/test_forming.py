"""Figures of forming: drawn from a made-up sheet, with and without what is optional."""

import numpy as np
import pytest

from shapemorph.config import RunConfig
from shapemorph.core.forming import LimitCurve
from shapemorph.core.measurement import Facets, Measurement
from shapemorph.io.quantities import QUANTITIES
from shapemorph.pipeline.forming import with_forming
from shapemorph.view.captions import CAPTIONS, caption_of, report_order
from shapemorph.view.figures import forming_figures
from shapemorph.view.measures import measures_in

CURVE = LimitCurve(np.array([-0.5, 0.0, 0.5]), np.array([0.6, 0.3, 0.5]), {"material": "A"})


def sheet():
    """Plate of 20 x 16 points that is stretched more and more along x."""
    y, x = np.mgrid[:16, :20] * 1.0
    count = x.size
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    number = np.arange(count).reshape(16, 20)
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    corners = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    major, minor = 0.03 * x.ravel(), -0.01 * x.ravel()
    scalars = {
        "hencky_1": major,
        "hencky_2": minor,
        "E1": np.expm1(2 * major) / 2,
        "E2": np.expm1(2 * minor) / 2,
        "thickness_strain": -(major + minor),
        "thinning": -np.expm1(-(major + minor)),
    }
    noise = {
        f"sigma_{name}": np.full(count, 0.001)
        for name in ("E1", "E2", "hencky_1", "hencky_2", "thickness_strain")
    }
    nothing = {
        q.name: np.zeros((count, q.components) if q.components > 1 else count)
        for q in QUANTITIES
        if not q.only_with
    }
    arrays = {
        **nothing,
        **scalars,
        **noise,
        "status": np.zeros(count, dtype=np.uint8),
        "displacement": points * [0.3, -0.1, 0.0],
        "deformed_position": points * [1.3, 0.9, 1.0],
        "sigma_uvw": np.full((count, 3), 0.01),
    }
    cells = np.stack([a, b, c, d], axis=1)
    return Measurement(points, cells, arrays, facets=Facets(corners, {}))


def drawn(forming, curve):
    settings = {"strain": {"thickness": 1.0}, "forming": forming}
    full, found = with_forming(sheet(), RunConfig.model_validate(settings), curve, 1.0)
    return full, dict(forming_figures(full, found)), found


@pytest.mark.parametrize("curve", [CURVE, None])
def test_a_diagram_is_drawn_with_and_without_a_curve(curve):
    full, figures, found = drawn({"diagram": True}, curve)
    assert list(figures) == ["forming_limits"]
    assert full.arrays["hencky_1"][found.critical] == full.arrays["hencky_1"].max()
    assert ("limit_margin" in {m.key for m in measures_in(full)}) == (curve is not None)
    ((axes,),) = [figures["forming_limits"].axes]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert ("limit curve" in labels) == (curve is not None)


def test_nothing_is_gathered_where_nothing_is_asked_for():
    full, figures, found = drawn({}, None)
    assert figures == found.figures == {}
    assert set(full.arrays) - set(sheet().arrays) == {"thickness", "sigma_thickness"}


def test_the_figures_of_sections_stand_with_those_of_forming():
    _, figures, _ = drawn({"sections": [{"name": "a-1", "angle": 20.0}]}, None)
    assert list(figures) == ["section_a-1"]
    assert len(figures["section_a-1"].axes) == 4
    assert caption_of("section_a-1").group == caption_of("thickness").group
    order = sorted(["displacement", "section_a-1", "E1", "forming_limits"], key=report_order)
    assert order == ["E1", "forming_limits", "section_a-1", "displacement"]
    assert "section_a-1" not in CAPTIONS
