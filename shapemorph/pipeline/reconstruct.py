"""From two pictures of one state, and calibrated cameras, to a textured mesh."""

from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Rig
from shapemorph.core.errors import DataError
from shapemorph.core.image import GreyImage
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.io.mesh_writers import write_mesh
from shapemorph.io.rig_files import read_rig, write_rig
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs
from shapemorph.pipeline.pictures import read_picture_pair
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.summary import point_figures, spread
from shapemorph.pipeline.unmatched import showing_failed_match
from shapemorph.pipeline.verdict import WARN
from shapemorph.stages.reconstruct import reconstruct

SUSPICIOUS = 0.3  # px
FEW = 0.8  # of the points on the mask
COLUMNS = (
    *("x_left_px", "y_left_px", "x_right_px", "y_right_px", "x_mm", "y_mm", "z_mm"),
    *("sigma_x_mm", "sigma_y_mm", "sigma_z_mm", "epipolar_px", "zncc", "status"),
)


def reconstruct_pictures(  # noqa: PLR0913 - two pictures, cameras and where to
    calibration: Path,
    left: Path,
    right: Path,
    folder: Path,
    config: RunConfig,
    *,
    mask: Path | None,
    listener: Listener,
) -> PictureOutcome:
    """Reconstruct what two calibrated cameras see.

    Parameters
    ----------
    calibration : Path
        Of the two cameras, in any of the formats that are read.
    left, right : Path
        Pictures of the first and of the second camera, taken at one moment.
    folder : Path
        Gets mesh.obj with its texture, points.csv and .npz, calibration.json, summary.json
        and figures.
    config : RunConfig
        Sections match, morph, correlate and reconstruct, and `inputs.region`.
    mask : Path or None
        Picture of the size of the left one, white = measured.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.methods.cameras.grid_surface import mesh_of

    check_writable(folder)
    inputs = picture_law_inputs(config)
    clock = Clock(listener)
    pair = clock.run("read", lambda: read_picture_pair(left, right, config, mask))
    first, second = pair.reference, pair.deformed
    rig = read_pair(calibration, (first, second), (left, right))
    with showing_failed_match(folder, lambda: (first, second)):
        grid = follow_pictures(first, second, config, inputs, clock).grid
    found = clock.run("triangulate", lambda: reconstruct(rig, grid, config.reconstruct))
    mesh = clock.run("texture", lambda: mesh_of(found, first, second))
    with scratch_folder(folder) as scratch:
        write_mesh(scratch / "mesh.obj", mesh)
        write_rig(scratch / "calibration.json", found.rig)
        clock.run("write", lambda: _write(scratch, found, first, config))
        figures = reconstruction_figures(found)
        sections = {
            "verdict": _judge(figures),
            "inputs": pair.figures(),
            **figures,
            "mesh": {"vertices": len(mesh.vertices), "faces": len(mesh.faces)},
            **run_figures(clock.seconds),
        }
        write_json(scratch / "summary.json", sections)
        kept = [calibration, left, right, *([mask] if mask else [])]
        files = move_files(scratch, folder, kept)
        return PictureOutcome(folder, tuple(files), sections)


def read_pair(
    calibration: Path, pictures: tuple[GreyImage, GreyImage], names: tuple[Path, Path]
) -> Rig:
    """Read the calibration of two cameras, and insist that it is of pictures of this size.

    Raises
    ------
    DataError
        If it is not.
    """
    sizes = [(picture.shape[1], picture.shape[0]) for picture in pictures]
    rig = read_rig(calibration, sizes[0])
    if len(rig.cameras) != 2:
        raise DataError(
            f"{calibration.name}: expected two cameras, got {len(rig.cameras)}: calibrate the pair"
        )
    for camera, name, size, path in zip(rig.cameras, rig.names, sizes, names, strict=True):
        if camera.size != size:
            raise DataError(
                f"{path.name}: the calibration of camera {name} is for pictures of "
                f"{camera.size[0]} x {camera.size[1]} px, got {size[0]} x {size[1]} px: give the "
                "calibration that was made with this size"
            )
    return rig


def reconstruction_figures(found: Reconstruction) -> dict[str, Any]:
    """Collect the figures of a reconstruction, JSON-able."""
    ok = found.status == PointStatus.OK
    off, rig = found.epipolar_px[ok], found.rig
    return {
        "points": point_figures(found.status),
        "rig": {
            "names": list(rig.names),
            "baseline_mm": rig.baseline(0, 1),
            "stereo_angle_deg": float(np.degrees(rig.stereo_angle(0, 1))),
        },
        "reconstruct": {
            "subset_size_px": found.subset_size,
            "spacing_px": found.spacing,
            "epipolar_px": {"rms": float(np.sqrt((off**2).mean())), **spread(off)},
            "sigma_mm": {
                axis: spread(found.sigma[ok][:, k]) for k, axis in enumerate(("x", "y", "z"))
            },
            "distance_mm": spread(found.points[ok][:, 2]),
            "smoothed_px": found.smoothed_px,
        },
    }


def _judge(figures: dict[str, Any]) -> dict[str, Any]:
    reasons = []
    off = figures["reconstruct"]["epipolar_px"]["rms"]
    if off > SUSPICIOUS:
        reasons.append(
            f"{WARN}: points lie {off:.2g} px rms off their epipolar lines: the calibration does "
            "not quite fit these pictures"
        )
    share = figures["points"]["ok_share"]
    if share < FEW:
        reasons.append(f"{WARN}: {share:.0%} of the points have a place: give a mask")
    return {"level": WARN if reasons else "PASS", "reasons": reasons}


def _write(scratch: Path, found: Reconstruction, first: GreyImage, config: RunConfig) -> None:
    table = _table(found)
    chosen = table[found.status.ravel() != PointStatus.OUTSIDE_MASK]
    np.savez_compressed(
        scratch / "points.npz",
        **{name: chosen[:, k] for k, name in enumerate(COLUMNS)},
    )
    line = ",".join(["%.10g"] * (len(COLUMNS) - 1) + ["%d"])
    header = ",".join(COLUMNS)
    np.savetxt(scratch / "points.csv", chosen, fmt=line, header=header, comments="")
    if config.report.figures:
        from shapemorph.view.reconstruction import write_reconstruction_figures

        write_reconstruction_figures(found, first, scratch / "figures")


def _table(found: Reconstruction) -> Floats:
    parts = [
        found.first_px.reshape(-1, 2),
        found.second_px.reshape(-1, 2),
        found.points.reshape(-1, 3),
        found.sigma.reshape(-1, 3),
        found.epipolar_px.reshape(-1, 1),
        found.zncc.reshape(-1, 1),
        found.status.reshape(-1, 1).astype(np.float64),
    ]
    return np.concatenate(parts, axis=1)
