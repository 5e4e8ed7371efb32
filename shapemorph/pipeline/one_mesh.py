"""Flatten one mesh: its calibrated image and what flattening did to it."""

import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.flattened import FlattenedSurface
from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.meshreport import MeshReport
from shapemorph.io.codec import take_apart
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Event, Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.summary import flattening_figures

QUANTILES = (("p1", 0.01), ("p5", 0.05), ("median", 0.5), ("p95", 0.95), ("p99", 0.99))


def flatten_one(
    path: Path, folder: Path, config: RunConfig, *, listener: Listener
) -> PictureOutcome:
    """Read a mesh, flatten it, and write the picture and what flattening did.

    The folder gets PNG, VTI and NPZ of the picture, an OBJ of the surface in the unit of
    its file with the picture for its texture (``<name>_uv.obj``), and the distortion as
    numbers (``distortion.json``) and, where figures are wanted, as ``distortion.png``.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.io.calibrated_files import write_calibrated
    from shapemorph.io.mesh_sources import mesh_sources
    from shapemorph.io.mesh_writers import write_mesh
    from shapemorph.methods.picture_texture import wear_picture
    from shapemorph.stages.flatten import flatten_mesh
    from shapemorph.view.figures import write_distortion_figure

    check_writable(folder)
    listener(Event("flatten", "started"))
    begin = time.perf_counter()
    sources = mesh_sources(path)
    mesh, report = _read(path, config)
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
        worn = wear_picture(mesh, surface.calibrated)
        write_mesh(scratch / f"{path.stem}_uv.obj", worn, unit=config.inputs.units)
        write_json(scratch / "distortion.json", distortion_figures(surface))
        if config.report.figures:
            write_distortion_figure(path.stem, surface, scratch, config.report.theme)
        write_json(scratch / "summary.json", sections)
        return PictureOutcome(folder, tuple(move_files(scratch, folder, sources)), sections)


def distortion_figures(surface: FlattenedSurface) -> dict[str, Any]:
    """Describe how a flattening stretches a surface, by shares of its area.

    Returns
    -------
    dict
        Quantiles of the local scale (px/mm), of the anisotropy (sigma_1 / sigma_2) and of
        the larger and smaller stretch (px/mm); flipped triangles and their share.
    """
    import numpy as np

    from shapemorph.methods.distortion import local_scale, weighted_quantile

    distortion = surface.distortion
    upright = distortion.sigma_2 > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(upright, distortion.sigma_1 / distortion.sigma_2, np.nan)
    measures = {
        "local_px_per_mm": local_scale(distortion),
        "anisotropy": ratio,
        "sigma_1_px_per_mm": distortion.sigma_1,
        "sigma_2_px_per_mm": distortion.sigma_2,
    }
    return {
        "method": surface.method,
        "reason": surface.reason,
        "px_per_mm": surface.calibrated.chart.px_per_mm,
        "triangles": len(distortion.area),
        "area_mm2": float(distortion.area.sum()),
        "flipped_triangles": distortion.flips,
        "flipped_share_of_area": float(distortion.area[~upright].sum() / distortion.area.sum()),
        **{
            name: {key: weighted_quantile(values, distortion.area, q) for key, q in QUANTILES}
            for name, values in measures.items()
        },
    }


def _read(path: Path, config: RunConfig) -> tuple[TexturedMesh, MeshReport]:
    """Read a mesh in the channel that shows its pattern best, or in that of the config."""
    from shapemorph.io.meshes import read_mesh
    from shapemorph.methods.colour_content import best_channel

    unit, channel = config.inputs.units, config.inputs.channel
    if channel != "auto":
        return read_mesh(path, unit=unit, channel=channel)
    mesh, report = read_mesh(path, unit=unit)
    best, _ = best_channel([report.content])
    return (mesh, report) if best == "luma" else read_mesh(path, unit=unit, channel=best)


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
