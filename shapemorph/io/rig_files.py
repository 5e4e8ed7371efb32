"""Calibrated cameras from and to files: our own JSON, and the formats of other programs.

In all of them X2 = R X1 + T carries a point from the frame of camera 1 into that of camera 2,
and pixel centres are at integers.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.calibration import CameraUncertainty, View
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.io.foreign_rigs import (
    matchid_text,
    opencorr_text,
    opencv_text,
    parse_matchid,
    parse_opencorr,
    parse_opencv,
    parse_vic,
    vic_text,
)
from shapemorph.io.safe_files import write_json

FORMAT = "shapemorph calibration"
CONVENTIONS = (
    "x_camera = R x_world + T, mm; camera frames have x right, y down, z forward; the world is "
    "the frame of the first camera, so that X2 = R X1 + T",
    "x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), "
    "y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y, with x = X/Z, y = Y/Z",
    "u = fx x' + skew y' + cx, v = fy y' + cy; pixel centres are at integers",
    "views: x_world = R x_target + T",
    "sigma: one standard deviation of the random part; rotation: small turns about the axes of "
    "the camera, radians",
)
FILES: dict[str, Callable[[Rig], str]] = {
    "opencv.yml": opencv_text,
    "vic3d.xml": vic_text,
    "matchid.caldat": matchid_text,
    "opencorr.csv": opencorr_text,
}
"""What a stereo rig is exported as."""
READERS: dict[str, Callable[[str, tuple[int, int]], Rig]] = {
    ".yml": parse_opencv,
    ".yaml": parse_opencv,
    ".xml": parse_vic,
    ".caldat": parse_matchid,
    ".csv": parse_opencorr,
}


def read_rig(path: Path, size: tuple[int, int]) -> Rig:
    """Read calibrated cameras, of a format that the ending of the name tells.

    Parameters
    ----------
    path : Path
        JSON of our own, OpenCV YAML (.yml, .yaml), VIC-3D (.xml), MatchID (.caldat) or
        OpenCorr (.csv).
    size : (int, int)
        Width and height of the pictures, px, for formats that do not say it.

    Raises
    ------
    DataError
        If the file is missing or not of that format.
    """
    suffix = path.suffix.lower()
    if suffix != ".json" and suffix not in READERS:
        known = ", ".join([".json", *READERS])
        raise DataError(f"calibration {path}: expected a file that ends in {known}")
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        raise DataError(f"calibration file {path} does not exist: check the path") from None
    except OSError as error:
        raise DataError(f"calibration file {path} cannot be read ({error.strerror})") from None
    try:
        return _own(text) if suffix == ".json" else READERS[suffix](text, size)
    except DataError as error:
        raise DataError(f"{path.name}: {error}") from None
    except (KeyError, ValueError, TypeError, IndexError) as error:
        raise DataError(
            f"{path.name}: is no calibration of the kind {suffix} ({error!r})"
        ) from None


def write_rig(
    path: Path,
    rig: Rig,
    uncertainty: tuple[CameraUncertainty, ...] = (),
    views: Sequence[tuple[View, RigidTransform]] = (),
) -> None:
    """Write our own JSON, with the places of the targets (world_from_target) if given."""
    cameras = [
        _camera_fields(name, camera) for name, camera in zip(rig.names, rig.cameras, strict=True)
    ]
    for fields, sigma in zip(cameras, uncertainty, strict=False):
        fields["sigma"] = _sigma_fields(sigma)
    content = {"format": FORMAT, "version": 1, "conventions": list(CONVENTIONS)}
    places = [
        {
            "view": view.name,
            "target": view.target.name,
            "rotation": pose.rotation.tolist(),
            "translation_mm": pose.translation.tolist(),
        }
        for view, pose in views
    ]
    write_json(path, {**content, "cameras": cameras, **({"views": places} if places else {})})


def write_exports(folder: Path, rig: Rig) -> None:
    """Write a stereo rig in the formats of other programs."""
    for name, text in FILES.items():
        (folder / name).write_text(text(rig), encoding="utf-8")


def read_uncertainty(path: Path) -> tuple[CameraUncertainty, ...]:
    """Read the standard deviations of our own JSON; empty where it has none."""
    cameras = json.loads(path.read_text(encoding="utf-8"))["cameras"]
    sigmas = [camera["sigma"] for camera in cameras if "sigma" in camera]
    return tuple(
        CameraUncertainty(
            focal=np.array([sigma["fx"], sigma["fy"]]),
            centre=np.array([sigma["cx"], sigma["cy"]]),
            radial=np.array([sigma["k1"], sigma["k2"], sigma["k3"]]),
            tangential=np.array([sigma["p1"], sigma["p2"]]),
            skew=float(sigma["skew"]),
            rotation=np.array(sigma["rotation_rad"]),
            translation=np.array(sigma["translation_mm"]),
        )
        for sigma in sigmas
    )


def read_poses(path: Path, target: str) -> dict[str, RigidTransform]:
    """Read world_from_target of each view of a target, by the name of the view.

    Raises
    ------
    DataError
        If the file has none.
    """
    read_rig(path, (1, 1))
    document = json.loads(path.read_text(encoding="utf-8"))
    poses = {
        str(view["view"]).removeprefix(target).strip(): RigidTransform(
            np.array(view["rotation"], dtype=np.float64),
            np.array(view["translation_mm"], dtype=np.float64),
        )
        for view in document.get("views", [])
        if view["target"] == target
    }
    if not poses:
        raise DataError(
            f"{path.name}: expected views of target {target!r}, got none: calibrate with pictures "
            "of it"
        )
    return poses


def lens_fields(camera: Camera | CameraUncertainty) -> dict[str, float]:
    """Name the ten unknowns of a lens."""
    names = ("fx", "fy", "cx", "cy", "skew", "k1", "k2", "k3", "p1", "p2")
    values = [*camera.focal, *camera.centre, camera.skew, *camera.radial, *camera.tangential]
    return {name: float(value) for name, value in zip(names, values, strict=True)}


def _camera_fields(name: str, camera: Camera) -> dict[str, Any]:
    return {
        "name": name,
        "size_px": list(camera.size),
        **lens_fields(camera),
        "rotation": camera.pose.rotation.tolist(),
        "translation_mm": camera.pose.translation.tolist(),
    }


def _sigma_fields(sigma: CameraUncertainty) -> dict[str, Any]:
    return {
        **lens_fields(sigma),
        "rotation_rad": sigma.rotation.tolist(),
        "translation_mm": sigma.translation.tolist(),
    }


def _own(text: str) -> Rig:
    document = json.loads(text)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise DataError(f'expected "format": "{FORMAT}" in it')
    fields = document["cameras"]
    return Rig(
        tuple(_camera(camera) for camera in fields), tuple(str(one["name"]) for one in fields)
    )


def _camera(fields: dict[str, Any]) -> Camera:
    def numbers(*names: str) -> Floats:
        return np.array([float(fields[name]) for name in names])

    width, height = fields["size_px"]
    return Camera(
        (int(width), int(height)),
        numbers("fx", "fy"),
        numbers("cx", "cy"),
        numbers("k1", "k2", "k3"),
        numbers("p1", "p2"),
        float(fields["skew"]),
        RigidTransform(
            np.array(fields["rotation"], dtype=np.float64),
            np.array(fields["translation_mm"], dtype=np.float64),
        ),
    )
