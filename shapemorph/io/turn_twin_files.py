"""The truth of a part on a turntable made by computer: `truth.npz`, and what a hand would note."""

from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.laws import RadialProfile
from shapemorph.core.transform import RigidTransform
from shapemorph.core.turn_twin import TurnTwin
from shapemorph.io.landmarks import COLUMNS


def write_turn_twin(path: Path, twin: TurnTwin) -> Path:
    """Write the maps of both states, the true camera and how everything stood.

    Arrays: `radius` of the die and `edge` of the sheet, mm; `coefficients` (2, R, C, 3) of the
    bicubic B-splines from material coordinates to positions, mm, `origin` (2, 2) and `spacing`
    (2,) of their coefficients; `part_from_die` (2, 4, 4); `camera_from_part` (P, 4, 4) of each
    picture; `size` (px), `focal`, `centre`, `radial`, `tangential`, `skew` of the camera.
    """
    camera = twin.camera
    np.savez_compressed(
        path,
        radius=np.array(twin.radius),
        edge=np.array(twin.edge),
        coefficients=np.stack([mapped.coefficients for mapped in twin.maps]),
        origin=np.stack([mapped.origin for mapped in twin.maps]),
        spacing=np.array([mapped.spacing for mapped in twin.maps]),
        part_from_die=np.stack([_matrix(pose) for pose in twin.placed]),
        camera_from_part=np.stack([_matrix(pose) for pose in twin.poses]),
        size=np.array(camera.size),
        focal=camera.focal,
        centre=camera.centre,
        radial=camera.radial,
        tangential=camera.tangential,
        skew=np.array(camera.skew),
    )
    return path


def write_marks(path: Path, before: Floats, after: Floats) -> None:
    """Write pairs of points (K, 3) as landmarks."""
    lines = [
        f"mark {number + 1}," + ",".join(f"{value:.6f}" for value in row)
        for number, row in enumerate(np.column_stack([before, after]).tolist())
    ]
    path.write_text("\n".join([",".join(COLUMNS), *lines]) + "\n", encoding="utf-8")


def write_radial_law(path: Path, profile: RadialProfile) -> None:
    """Write a profile as the law `fe` reads it."""
    table = np.column_stack([profile.material, profile.radius, profile.height])
    np.savetxt(path, table, fmt="%.6f", delimiter=",", header="r0,r,z", comments="")


def _matrix(pose: RigidTransform) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
    return matrix
