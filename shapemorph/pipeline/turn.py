"""From many photographs of a part that turned, in known poses, to one textured mesh."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import RunConfig, TurnConfig
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.mesh import TexturedMesh, coloured_mesh
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.io.images import read_grey_image, read_white
from shapemorph.io.picture_sets import named_pictures
from shapemorph.io.rig_files import read_poses, read_rig
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.methods.cameras.averaged_grey import Photograph
from shapemorph.methods.cameras.glare import without_glare
from shapemorph.methods.cameras.relative import compose
from shapemorph.methods.cameras.turn import Merged
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.verdict import WARN
from shapemorph.stages.reconstruct import reconstruct

GAP = 0.5  # of a pixel: patches that lie farther apart are doubted


@dataclass(frozen=True, slots=True, eq=False)
class _Shot:
    """A photograph that was taken: its name, its files and its camera, placed."""

    name: str
    path: Path
    mask: Path | None
    camera: Camera


def reconstruct_turn(
    config: TurnConfig, base: Path, folder: Path, *, listener: Listener
) -> PictureOutcome:
    """Reconstruct a part from photographs all around it.

    Pairs of neighbouring views are matched and triangulated, all points go into one cloud and
    one mesh, and its texture is averaged over the photographs of these pairs; others are not
    read.

    Parameters
    ----------
    config : TurnConfig
    base : Path
        Folder that the names of pictures are relative to.
    folder : Path
        Gets mesh.obj with its texture, summary.json.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.io.mesh_writers import write_mesh
    from shapemorph.methods.cameras.chart_texture import texture_from
    from shapemorph.methods.cameras.turn import merge, pair_up

    check_writable(folder)
    clock = Clock(listener)
    shots = _list_shots(config, base)
    cameras = [shot.camera for shot in shots]
    pairs = pair_up(cameras, angle=float(np.radians(config.angle)), patches=config.patches)
    if not pairs:
        raise DataError(
            f"no two of {len(shots)} views are about {config.angle:g} degrees apart: change angle"
        )
    used = sorted({number for pair in pairs for number in pair})
    read = clock.run("read", lambda: {number: _photograph(shots[number]) for number in used})
    rows: list[dict[str, Any]] = []
    patches = [
        _patch({shots[number].name: read[number] for number in pair}, config, clock, rows)
        for pair in pairs
    ]
    found = [patch for patch in patches if patch is not None]
    if not found:
        raise StageError(f"nothing was found in any of {len(pairs)} pairs: {rows[-1]['reason']}")
    merged = clock.run("merge", lambda: merge(found))
    photographs = list(read.values())
    with scratch_folder(folder) as scratch:
        surface = clock.run("mesh", lambda: _surface(merged, photographs, scratch))
        scale = config.px_per_mm or _scale(found)
        mesh = clock.run("texture", lambda: texture_from(surface, photographs, px_per_mm=scale))
        write_mesh(scratch / "mesh.obj", mesh)
        gap = merged.overlap_rms
        doubted = [f"{WARN}: patches lie {gap:.2g} mm rms apart: are the poses right?"]
        doubted = doubted if gap * _scale(found) > GAP else []
        summary = {
            "verdict": {"level": WARN if doubted else "PASS", "reasons": doubted},
            "views": len(used),
            "patches": rows,
            "points": len(merged.points),
            "overlap_rms_mm": gap,
            "mesh": {"vertices": len(mesh.vertices), "faces": len(mesh.faces)},
            "texture_px_per_mm": scale,
            **run_figures(clock.seconds),
        }
        write_json(scratch / "summary.json", summary)
        files = move_files(scratch, folder, [config.calibration, *(s.path for s in shots)])
        return PictureOutcome(folder, tuple(files), summary)


def _list_shots(config: TurnConfig, base: Path) -> list[_Shot]:
    """List all photographs; each camera is placed in the frame of the part."""
    calibration = base / config.calibration
    rig = read_rig(calibration, (1, 1))
    poses = read_poses(calibration, config.target)
    shots = []
    for name, pattern in config.pictures.items():
        if name not in rig.names:
            raise DataError(
                f"camera {name!r} is not in {calibration.name}: expected {', '.join(rig.names)}"
            )
        camera = rig.cameras[rig.names.index(name)]
        masks = named_pictures(base, config.masks[name]) if name in config.masks else {}
        for key, path in named_pictures(base, pattern).items():
            if key in poses:
                mask = masks.get(key, masks.get(""))
                placed = camera.placed(compose(camera.pose, poses[key]))
                shots.append(_Shot(f"{name} {key}", path, mask, placed))
    if len(shots) < 2:
        raise DataError(
            f"expected pictures of at least 2 views with a pose in {calibration.name}, got "
            f"{len(shots)}: the star of `pictures` must stand for the name of a view "
            f"({', '.join(list(poses)[:3])}, ...)"
        )
    return shots


def _photograph(shot: _Shot) -> Photograph:
    picture = _masked(shot.path, shot.mask)
    _require_size(shot.camera, picture, shot.path)
    return Photograph(shot.camera, picture)


def _masked(path: Path, mask: Path | None) -> GreyImage:
    picture = read_grey_image(path)
    if mask is None:
        return picture
    white = read_white(mask)
    if white.shape != picture.shape:
        raise DataError(f"mask {mask.name}: expected the size of {path.name}")
    return GreyImage(picture.grey, picture.mask & white)


def _require_size(camera: Camera, picture: GreyImage, path: Path) -> None:
    height, width = picture.shape
    if camera.size != (width, height):
        raise DataError(
            f"{path.name}: the calibration is for pictures of {camera.size[0]} x "
            f"{camera.size[1]} px, got {width} x {height} px"
        )


def _patch(
    pair: dict[str, Photograph], config: TurnConfig, clock: Clock, rows: list[dict[str, Any]]
) -> Reconstruction | None:
    """Match and triangulate one pair; a pair without a result is a row with its reason."""
    run = RunConfig(match=config.match, morph=config.morph, correlate=config.correlate)
    rig = Rig(tuple(photograph.camera for photograph in pair.values()), tuple(pair))
    row: dict[str, Any] = {"pair": list(pair), "reason": ""}
    rows.append(row)
    try:
        left, right = (without_glare(photograph.picture) for photograph in pair.values())
        grid = follow_pictures(left, right, run, picture_law_inputs(run), clock).grid
        found = clock.run("triangulate", lambda: reconstruct(rig, grid, config.reconstruct))
    except (StageError, DataError) as error:
        row["reason"] = str(error)
        return None
    ok = found.status == PointStatus.OK
    row["points"] = int(ok.sum())
    row["epipolar_px"] = float(np.sqrt((found.epipolar_px[ok] ** 2).mean()))
    return found


def _scale(patches: list[Reconstruction]) -> float:
    """Pixels of the photographs in a mm, median."""
    scales = [
        patch.rig.cameras[0].focal.mean()
        / np.nanmedian(patch.rig.cameras[0].pose.apply(patch.points)[..., 2])
        for patch in patches
    ]
    return float(np.median(scales))


def _surface(merged: Merged, photographs: list[Photograph], scratch: Path) -> TexturedMesh:
    """Mesh the cloud as a file of points would be; faces look at the cameras."""
    from scipy.spatial import cKDTree

    from shapemorph.io.meshes import read_mesh
    from shapemorph.methods.cameras.averaged_grey import average_grey

    grey, _ = average_grey(merged.points, merged.towards, photographs)
    seen = np.isfinite(grey)
    cloud = scratch / "points.csv"
    table = np.column_stack([merged.points[seen], grey[seen]])
    np.savetxt(cloud, table, fmt="%.6f", delimiter=",", header="x,y,z,grey", comments="")
    mesh, _ = read_mesh(cloud, unit="mm")
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    near = np.asarray(cKDTree(merged.points).query(corners.mean(axis=1))[1])
    outward = float((normals * merged.towards[near]).sum())
    faces, colours = mesh.faces, mesh.corner_grey
    if outward < 0:
        faces, colours = faces[:, ::-1].copy(), colours[:, ::-1].copy()
    return coloured_mesh(mesh.vertices, faces, colours, name="mesh")
