"""The figures of a run, as files."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.results import RunResults
from shapemorph.core.surface import Alignment
from shapemorph.view.camera import View, outer_view, second_view
from shapemorph.view.layout import Heading, views_figure
from shapemorph.view.maps import correlation_figure, distortion_figure
from shapemorph.view.measures import MEASURES, Measure, measure_values
from shapemorph.view.plots import histograms_figure, matches_figure, morph_figure
from shapemorph.view.render import Painter, Picture, Scene
from shapemorph.view.style import DPI, colour_scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 620, 500
"""Largest size of a rendered view, px."""
TILT = 0.85
"""Angle between the two views of a shape, radians."""
CAPTIONS = ("along the mean normal", "from one side")

Named = Iterator[tuple[str, "Figure"]]


def write_figures(results: RunResults, folder: Path) -> list[Path]:
    """Draw all figures of a measurement.

    Parameters
    ----------
    results : RunResults
    folder : Path
        Made where it is missing.

    Returns
    -------
    list of Path
        PNG files in the order of the report: shapes, measures, maps, checks.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    return _save_all(_all_figures(results), folder)


def write_planar_figures(grid: CorrelationGrid, reference: GreyImage, folder: Path) -> list[Path]:
    """Draw the figures of a correlation of two images; needs no OpenGL.

    Returns
    -------
    list of Path
        PNG files.
    """
    figures: Named = iter([("correlation", correlation_figure(grid, reference))])
    return _save_all(figures, folder)


def _save_all(figures: Named, folder: Path) -> list[Path]:
    """Save each figure as soon as it is drawn, under its name."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, figure in figures:
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=DPI, pil_kwargs={"compress_level": 2})
        paths.append(path)
    return paths


def _all_figures(results: RunResults) -> Named:
    """Draw one after the other, so that only one is held at a time."""
    pair, reference = results.pair, results.pair.reference.calibrated.image
    if len(results.measurement.cells):
        yield from _rendered(results)
    yield "histograms", histograms_figure(results.measurement)
    yield (
        "matches",
        matches_figure(results.matches, reference, pair.deformed.calibrated.image),
    )
    both = reference.mask & results.morphed.image.mask
    yield "morph", morph_figure(reference, results.morphed.image, both)
    yield "correlation", correlation_figure(results.grid, reference)
    yield "flattening", distortion_figure(pair)


def _rendered(results: RunResults) -> Named:
    """Draw the shapes with their pattern, then every measure on the deformed shape."""
    measurement = results.measurement
    deformed = measurement.reference + measurement.arrays["displacement"]
    before = outer_view(measurement.reference, measurement.cells)
    after = outer_view(deformed, measurement.cells)
    carried = _carried(results.deformed_mesh, results.alignment)
    with Scene() as scene:
        for key, mesh, view in (
            ("reference", results.reference_mesh, before),
            ("deformed", carried, after),
        ):
            yield f"shape_{key}", _shape_figure(scene, mesh, view, key)
        scene.clear("the measured field")
        used, cells = np.unique(measurement.cells, return_inverse=True)
        painter = scene.add_coloured(deformed[used], cells.reshape(-1, 4))
        scene.add_bare(carried.vertices, carried.faces)
        views = (after, second_view(after, deformed[used], TILT))
        for measure in MEASURES:
            values = measure_values(measurement, measure)[used]
            yield measure.key, _measure_figure(scene, painter, measure, values, views)


def _carried(mesh: TexturedMesh, alignment: Alignment) -> TexturedMesh:
    """Carry the deformed mesh into the frame of the reference file."""
    vertices = mesh.vertices @ alignment.rotation.T + alignment.translation
    return TexturedMesh(
        vertices,
        mesh.faces,
        mesh.wedge_uv,
        mesh.face_texture,
        mesh.textures,
        mesh.corner_grey,
        name=mesh.name,
    )


def _shape_figure(scene: Scene, mesh: TexturedMesh, view: View, key: str) -> "Figure":
    """Draw a mesh with its own pattern."""
    scene.clear(mesh.name)
    scene.add_textured(mesh)
    heading = Heading(
        f"{key.capitalize()} shape: {mesh.name}",
        f"{len(mesh.vertices)} vertices, {len(mesh.faces)} faces, {mesh.size:.4g} mm across; "
        "grey as stored",
    )
    pictures = _pictures(scene, (view, second_view(view, mesh.vertices, TILT)))
    return views_figure(pictures, CAPTIONS, heading, scale=None, label="")


def _measure_figure(
    scene: Scene, painter: Painter, measure: Measure, values: Floats, views: tuple[View, View]
) -> "Figure":
    """Draw a measure on the deformed shape, from one or both views."""
    scale = colour_scale(values)
    painter.paint(values, scale)
    chosen = views if measure.two_views else views[:1]
    heading = Heading(f"{measure.title} on the deformed shape", f"{measure.note} Grey: no value.")
    captions = CAPTIONS[: len(chosen)]
    return views_figure(
        _pictures(scene, chosen), captions, heading, scale=scale, label=measure.label
    )


def _pictures(scene: Scene, views: tuple[View, ...]) -> list[Picture]:
    """Render what stands in the scene from each view, filling the frame."""
    return [scene.picture(view, scene.frame(view, width=WIDTH, height=HEIGHT)) for view in views]
