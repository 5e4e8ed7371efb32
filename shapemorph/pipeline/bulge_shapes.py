"""From the photographs of the bulge on its turntable to the shapes that are measured."""

import shutil
from pathlib import Path

import numpy as np

from shapemorph.config import BulgeConfig, RigConfig, RunConfig, TurnConfig
from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.turn_twin import TurnTwin
from shapemorph.io.config_files import read_config
from shapemorph.pipeline.reproduce_limits import silent
from shapemorph.pipeline.turntable import RIG, STATES, TURN

_FACING = 0.2  # cosine: what is more slanted is not looked at for glare
_WHITE = 0.97  # grey of glare


def calibrate_state(pictures: Path) -> None:
    """Find the lens and all poses of one state from its cone, as calibration/ beside them."""
    from shapemorph.pipeline.calibrate import calibrate_cameras

    rig = read_config(pictures / RIG, RigConfig, [])
    calibrate_cameras(rig, pictures, pictures / "calibration", listener=silent)


def shape_of_state(config: BulgeConfig, pictures: Path, state: str, folder: Path) -> Path:
    """Reconstruct one state; give its mesh."""
    from shapemorph.pipeline.turn import reconstruct_turn

    sizes = {"subset_size": config.subset_size, "spacing": config.spacing}
    settings = [f"correlate.{name}={value}" for name, value in sizes.items()]
    turn = read_config(pictures / state / TURN, TurnConfig, settings)
    turn = turn.model_copy(update={"patches": config.patches})
    reconstruct_turn(turn, pictures / state, folder, listener=silent)
    return folder / "mesh.obj"


def noisy_frames(pictures: Path, folder: Path, level: float, seed: int) -> Path:
    """Copy all frames with noise, with masks and calibrations as they are."""
    from shapemorph.io.images import read_grey_image, write_grey_png
    from shapemorph.methods.synthetic.painting import record_grey

    rng = np.random.default_rng([seed, round(1000 * level)])
    for state in STATES:
        place = folder / "pictures" / state
        if place.exists():
            shutil.rmtree(place)
        (place / "calibration").mkdir(parents=True)
        for name in (TURN, "calibration/calibration.json"):
            shutil.copyfile(pictures / state / name, place / name)
        for mask in sorted((pictures / state).glob("mask_*.png")):
            (place / mask.name).symlink_to(mask.absolute())
        for path in sorted((pictures / state).glob("frame_*.png")):
            image = read_grey_image(path)
            grey = record_grey(image.grey, noise=level, rng=rng)
            write_grey_png(place / path.name, grey, np.ones_like(image.mask))
    return folder / "pictures"


def dots_in_pictures(run: RunConfig, marks: Path, folder: Path) -> Path:
    """Find marks of both shapes in their flattened pictures, as dots.csv for the law landmarks."""
    from shapemorph.io.landmarks import read_landmarks
    from shapemorph.io.store import RunStore
    from shapemorph.methods.rough_start import dots_of_landmarks
    from shapemorph.pipeline.inputs import Inputs
    from shapemorph.pipeline.measure import measure
    from shapemorph.pipeline.run import Results
    from shapemorph.pipeline.stagelist import STAGES

    place = folder / "flat"
    plain = run.model_copy(
        update={"morph": run.morph.model_copy(update={"law": "warp", "laws": ()})}
    )
    measure(plain, place, until="flatten", listener=silent)
    results = Results(Inputs(plain), RunStore(place), STAGES)
    pair = results.load("flatten")
    dots = dots_of_landmarks(
        read_landmarks(marks, reference_scale=1.0, deformed_scale=1.0),
        (results.load("reference"), pair.reference.calibrated),
        (results.load("deformed"), pair.deformed.calibrated),
    )
    table = np.column_stack([dots.reference_px, dots.deformed_px])
    header = "x_ref_px,y_ref_px,x_def_px,y_def_px"
    np.savetxt(folder / "dots.csv", table, fmt="%.4f", delimiter=",", header=header, comments="")
    return folder / "dots.csv"


def glare_on(twin: TurnTwin, pictures: Path, material: Floats) -> Bools:
    """Tell which material points (N, 2) lie under glare in any photograph that faces them."""
    from shapemorph.io.images import read_grey_image, read_white
    from shapemorph.methods.cameras.relative import compose
    from shapemorph.methods.synthetic.membrane.smooth import map_points

    points, slope = map_points(twin.maps[1], material)
    normals = np.cross(slope[..., 0], slope[..., 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    covered: Bools = np.zeros(len(material), dtype=np.bool_)
    for number, pose in enumerate(twin.poses):
        camera = twin.camera.placed(compose(pose, twin.placed[1]))
        away = camera.position - points
        facing = (away * normals).sum(axis=1) > _FACING * np.linalg.norm(away, axis=1)
        grey = read_grey_image(pictures / f"frame_{number:03d}.png").grey
        white = (grey >= _WHITE) & read_white(pictures / f"mask_{number:03d}.png")
        x, y = np.nan_to_num(np.rint(camera.project(points))).astype(np.int64).T
        inside = facing & (x >= 0) & (y >= 0) & (x < grey.shape[1]) & (y < grey.shape[0])
        covered[inside] |= white[y[inside], x[inside]]
    return covered
