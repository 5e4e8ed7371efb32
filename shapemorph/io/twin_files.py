"""The truth of a stereo experiment made by computer, as `truth.npz`."""

from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError
from shapemorph.core.spline_map import SplineMap
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.core.transform import RigidTransform

TRUTH = "truth.npz"


def write_twin(path: Path, twin: StereoTwin) -> Path:
    """Write the maps of all states and the true cameras.

    Arrays: `kind`; `radius` (mm) of the sheet; `travel` (S,) mm; `coefficients` (S, R, C, 3)
    of the bicubic B-splines from material coordinates to positions, mm, `origin` (S, 2) and
    `spacing` (S,) of their coefficients; for each camera, by `names`: `size` (px), `focal`,
    `centre`, `radial`, `tangential`, `skew`, and `camera_from_body` (4, 4).
    """
    cameras = twin.rig.cameras
    np.savez_compressed(
        path,
        kind=np.array(twin.kind),
        radius=np.array(twin.radius),
        travel=twin.travel,
        coefficients=np.stack([mapped.coefficients for mapped in twin.maps]),
        origin=np.stack([mapped.origin for mapped in twin.maps]),
        spacing=np.array([mapped.spacing for mapped in twin.maps]),
        names=np.array(twin.rig.names),
        size=np.array([camera.size for camera in cameras]),
        focal=np.stack([camera.focal for camera in cameras]),
        centre=np.stack([camera.centre for camera in cameras]),
        radial=np.stack([camera.radial for camera in cameras]),
        tangential=np.stack([camera.tangential for camera in cameras]),
        skew=np.array([camera.skew for camera in cameras]),
        camera_from_body=np.stack([_matrix(camera.pose) for camera in cameras]),
    )
    return path


def read_twin(path: Path) -> StereoTwin:
    """Read a truth that :func:`write_twin` has written.

    Raises
    ------
    DataError
        If the file cannot be read or is none.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        rig = Rig(_cameras(found), tuple(str(name) for name in found["names"]))
        parts = zip(found["coefficients"], found["origin"], found["spacing"], strict=True)
        maps = tuple(SplineMap(values, origin, float(space)) for values, origin, space in parts)
        return StereoTwin(str(found["kind"]), rig, float(found["radius"]), maps, found["travel"])
    except (OSError, KeyError, ValueError) as error:
        raise DataError(
            f"{path}: expected the truth.npz of a stereo experiment, got something else "
            f"({type(error).__name__}: {error}): make one with shapemorph synthesize stereo"
        ) from error


def _cameras(found: dict[str, Any]) -> tuple[Camera, ...]:
    return tuple(
        Camera(
            size=(int(found["size"][k][0]), int(found["size"][k][1])),
            focal=found["focal"][k],
            centre=found["centre"][k],
            radial=found["radial"][k],
            tangential=found["tangential"][k],
            skew=float(found["skew"][k]),
            pose=RigidTransform(found["camera_from_body"][k][:3, :3], pose[:3, 3]),
        )
        for k, pose in enumerate(found["camera_from_body"])
    )


def _matrix(pose: RigidTransform) -> Any:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
    return matrix
