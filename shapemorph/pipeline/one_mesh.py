"""Flatten one mesh: its calibrated image and what flattening did to it."""

import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.io.codec import take_apart
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Event, Listener
from shapemorph.pipeline.summary import flattening_figures, run_figures


def flatten_one(
    path: Path, folder: Path, config: RunConfig, *, listener: Listener
) -> PictureOutcome:
    """Read a mesh, flatten it, and write PNG, VTI, NPZ and the distortion as JSON.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.io.calibrated_files import write_calibrated
    from shapemorph.io.meshes import read_mesh
    from shapemorph.stages.flatten import flatten_mesh

    check_writable(folder)
    listener(Event("flatten", "started"))
    begin = time.perf_counter()
    mesh, report = read_mesh(path, unit=config.inputs.units)
    surface = flatten_mesh(mesh, config.flatten, _meridian(config))
    seconds = time.perf_counter() - begin
    listener(Event("flatten", "finished", seconds))
    sections: dict[str, Any] = {
        "inputs": asdict(report),
        "flatten": flattening_figures(surface),
        **run_figures({"flatten": seconds}),
    }
    with scratch_folder(folder) as scratch:
        write_calibrated(scratch / path.stem, mesh, surface.calibrated)
        _write_arrays(scratch / f"{path.stem}.npz", mesh, surface.calibrated)
        write_json(scratch / "summary.json", sections)
        return PictureOutcome(folder, tuple(move_files(scratch, folder)), sections)


def _meridian(config: RunConfig) -> Floats | None:
    """Read what ``flatten.profile`` names."""
    from shapemorph.io.meridian_files import read_meridian
    from shapemorph.io.meshes import MM_PER_UNIT

    path = config.flatten.profile
    scale = float(MM_PER_UNIT[config.inputs.units])
    return None if path is None else read_meridian(path, scale=scale)


def _write_arrays(path: Path, mesh: TexturedMesh, image: CalibratedImage) -> None:
    """Write grey, mask, triangle, barycentric, the chart, and X, Y, Z in mm by their names."""
    import numpy as np

    from shapemorph.methods.surface_lookup import pixel_positions

    arrays, _ = take_apart(image)
    named = {n.replace("image.", "").replace("chart.", "chart_"): a for n, a in arrays.items()}
    places = np.moveaxis(pixel_positions(mesh, image), -1, 0)
    named |= dict(zip("XYZ", places, strict=True))
    np.savez(path, px_per_mm=np.array(image.chart.px_per_mm), **named)  # type: ignore[arg-type]
