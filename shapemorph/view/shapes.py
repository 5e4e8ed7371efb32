"""Figures of the shapes: their pattern, and every measure on the deformed one."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.measurement import Measurement
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.results import RunResults
from shapemorph.core.surface import Alignment
from shapemorph.methods.covered_faces import covered_faces
from shapemorph.view.camera import View, outer_view, second_view
from shapemorph.view.layout import Heading, views_figure
from shapemorph.view.measures import Measure, measure_values, measures_in
from shapemorph.view.render import MAX_TEXTURE, Painter, Picture, Scene
from shapemorph.view.style import colour_scale, reduced

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 620, 500
"""Largest size of a rendered view, px."""
TILT = 0.85
"""Angle between the two views of a shape, radians."""
CAPTIONS = ("along the mean normal", "from one side")


@dataclass(frozen=True, slots=True, eq=False)
class Shapes:
    """What the figures of the measures on the deformed shape show.

    Attributes
    ----------
    measurement : Measurement
    vertices : (V, 3) float64
        Of the deformed mesh in the frame of the reference file, mm.
    bare : (F, 3) int64
        Its faces that nothing measured covers.
    """

    measurement: Measurement
    vertices: Floats
    bare: Ints


def shapes_of(results: RunResults) -> Shapes:
    """Take from a measurement what the figures of its measures show."""
    mesh, measured = carried(results.deformed_mesh, results.alignment), results.measurement
    points = measured.reference + measured.arrays["displacement"]
    covered = covered_faces(mesh.vertices, mesh.faces, points, measured.cells)
    return Shapes(measured, mesh.vertices, mesh.faces[~covered])


def carried(mesh: TexturedMesh, alignment: Alignment) -> TexturedMesh:
    """Carry the deformed mesh into the frame of the reference file."""
    vertices = mesh.vertices @ alignment.rotation.T + alignment.translation
    return replace(mesh, vertices=vertices)


def with_small_textures(mesh: TexturedMesh) -> TexturedMesh:
    """Shrink the textures of a mesh as far as no picture of it shows, to pass it on quickly."""
    textures = tuple(reduced(texture, MAX_TEXTURE) for texture in mesh.textures)
    return replace(mesh, textures=textures)


def reference_figures(mesh: TexturedMesh, scene: Scene) -> Iterator[tuple[str, "Figure"]]:
    """Draw the reference shape with its pattern.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    yield "shape_reference", _shape_figure(scene, mesh, "reference")


def deformed_figures(mesh: TexturedMesh, scene: Scene) -> Iterator[tuple[str, "Figure"]]:
    """Draw the deformed shape, in the frame of the reference file, with its pattern.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    yield "shape_deformed", _shape_figure(scene, mesh, "deformed")


def shape_figures(shapes: Shapes, scene: Scene) -> Iterator[tuple[str, "Figure"]]:
    """Draw every measure on the deformed shape.

    Yields one after the other, by name, so that only one is held at a time; nothing where
    no cell was measured.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing.
    """
    measurement = shapes.measurement
    if not len(measurement.cells):
        return
    deformed = measurement.reference + measurement.arrays["displacement"]
    after = outer_view(deformed, measurement.cells)
    scene.clear("the measured field")
    used, cells = np.unique(measurement.cells, return_inverse=True)
    painter = scene.add_coloured(deformed[used], cells.reshape(-1, 4))
    scene.add_bare(shapes.vertices, shapes.bare)
    views = (after, second_view(after, deformed[used], TILT))
    for measure in measures_in(measurement):
        values = measure_values(measurement, measure)[used]
        yield measure.key, _measure_figure(scene, painter, measure, values, views)


def _shape_figure(scene: Scene, mesh: TexturedMesh, key: str) -> "Figure":
    """Draw a mesh with its own pattern."""
    view = outer_view(mesh.vertices, mesh.faces)
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
