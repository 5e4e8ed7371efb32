"""Stereo rigs as other programs write them.

- OpenCV: YAML with cameraMatrix1/2, distCoeffs1/2 (k1, k2, p1, p2, k3), R, T.
- VIC-3D, which DICe reads as cal.xml: ``<camera>`` cx cy fx fy skew k1 k2 k3 ``<orientation>``
  alpha beta gamma tx ty tz: x_camera = Rz(gamma) Ry(beta) Rx(alpha) x_world + t, degrees, mm.
- MatchID .caldat: Theta, Phi, Psi in degrees, R = Rz(Psi) Ry(Phi) Rx(Theta).
- OpenCorr .csv: a line of titles, then thirteen lines of the lens and six of the place, in this
  order, each with a name, the left and the right value; rotation as a vector (axis times angle),
  radians.
"""

import csv
import io
import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform

NAMES = "left", "right"


def _stereo(left: Camera, right: Camera, rotation: Floats, translation: Floats) -> Rig:
    left_u, _, right_u = np.linalg.svd(rotation)
    if np.abs(left_u @ right_u - rotation).max() > 1e-3:
        raise DataError("its rotation is no rotation: expected an orthonormal matrix")
    return Rig((left, right.placed(RigidTransform(left_u @ right_u, translation))), NAMES)


def _two(rig: Rig) -> tuple[Camera, Camera, RigidTransform]:
    if len(rig.cameras) != 2:
        raise DataError(f"expected a rig of two cameras, got {len(rig.cameras)}")
    return rig.cameras[0], rig.cameras[1], rig.between(0, 1)


# --- OpenCV --------------------------------------------------------------------------


def opencv_text(rig: Rig) -> str:
    """Write as OpenCV's FileStorage does; skew has no place there but in the matrix."""
    left, right, motion = _two(rig)
    width, height = left.size
    parts = ["%YAML:1.0", "---", f"imageSize: [ {width}, {height} ]"]
    for number, camera in enumerate((left, right), start=1):
        (k1, k2, k3), (p1, p2) = camera.radial, camera.tangential
        parts.append(_matrix_text(f"cameraMatrix{number}", camera.matrix))
        parts.append(_matrix_text(f"distCoeffs{number}", np.array([[k1, k2, p1, p2, k3]])))
    parts.append(_matrix_text("R", motion.rotation))
    parts.append(_matrix_text("T", motion.translation[:, None]))
    return "\n".join(parts) + "\n"


def _matrix_text(name: str, matrix: Floats) -> str:
    rows, columns = matrix.shape
    data = ", ".join(repr(float(value)) for value in matrix.ravel())
    return (
        f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n"
        f"   data: [ {data} ]"
    )


def parse_opencv(text: str, size: tuple[int, int]) -> Rig:
    """Read what :func:`opencv_text` and OpenCV write."""
    matrices = {
        match[1]: np.array([float(word) for word in match[2].replace(",", " ").split()])
        for match in re.finditer(
            r"^(\w+):\s*!!opencv-matrix.*?data:\s*\[(.*?)\]", text, re.S | re.M
        )
    }
    missing = [n for n in ("cameraMatrix1", "cameraMatrix2", "R", "T") if n not in matrices]
    if missing:
        raise DataError(f"expected cameraMatrix1, cameraMatrix2, R and T, {missing[0]} is missing")
    given = re.search(r"^imageSize:\s*\[\s*(\d+)\s*,\s*(\d+)\s*\]", text, re.M)
    own = (int(given[1]), int(given[2])) if given else size
    cameras = []
    for number in "12":
        matrix = matrices[f"cameraMatrix{number}"].reshape(3, 3)
        lens = matrices.get(f"distCoeffs{number}", np.zeros(5))
        if len(lens) > 5 and lens[5:].any():
            raise DataError("expected distortion k1, k2, p1, p2, k3, got further terms")
        k1, k2, p1, p2, k3 = np.concatenate([lens[:5], np.zeros(max(5 - len(lens), 0))])
        cameras.append(
            Camera(
                own,
                np.array([matrix[0, 0], matrix[1, 1]]),
                matrix[:2, 2].copy(),
                np.array([k1, k2, k3]),
                np.array([p1, p2]),
                float(matrix[0, 1]),
            )
        )
    return _stereo(cameras[0], cameras[1], matrices["R"].reshape(3, 3), matrices["T"])


# --- VIC-3D --------------------------------------------------------------------------


def vic_text(rig: Rig) -> str:
    """Write the part of a VIC-3D project that holds the calibration; tangential terms are left out.

    Raises
    ------
    DataError
        For another number of cameras than two.
    """
    left, right, motion = _two(rig)
    still = RigidTransform.identity()
    lines = []
    for number, (camera, pose) in enumerate(((left, still), (right, motion))):
        lens = [*camera.centre, *camera.focal, camera.skew, *camera.radial]
        place = [*_angles(pose.rotation), *pose.translation]
        lines.append(
            f'  <camera id="{number}">{_words(lens)}<orientation>{_words(place)}</orientation>\n'
            "  </camera>"
        )
    head = '<?xml version="1.0" encoding="ISO-8859-1"?>\n<!DOCTYPE vpml>\n<project>\n'
    body = "\n".join(lines)
    return f'{head} <calibration lri="calibration">\n{body}\n </calibration>\n</project>\n'


def parse_vic(text: str, size: tuple[int, int]) -> Rig:
    """Read the calibration of a VIC-3D project, which DICe calls cal.xml."""
    if "<!ENTITY" in text:
        raise DataError("expected a plain XML file, got one with entities")
    try:
        root = ET.fromstring(text.encode("utf-8").replace(b"ISO-8859-1", b"UTF-8", 1))
    except ET.ParseError as error:
        raise DataError(f"is not XML ({error})") from None
    found = root.findall("./calibration/camera")
    if len(found) != 2:
        raise DataError(f"expected <calibration> with two <camera>, got {len(found)}")
    cameras = [_vic_camera(camera, size) for camera in found]
    motion = Rig((cameras[0], cameras[1]), NAMES).between(0, 1)
    still = cameras[0].placed(RigidTransform.identity())
    return _stereo(still, cameras[1], motion.rotation, motion.translation)


def _vic_camera(element: "ET.Element", size: tuple[int, int]) -> Camera:
    lens = [float(word) for word in (element.text or "").split()]
    place = [float(word) for word in (element.findtext("orientation") or "").split()]
    if len(lens) != 8 or len(place) != 6:
        raise DataError(
            "expected 8 numbers for each camera and 6 for its orientation, got "
            f"{len(lens)} and {len(place)}"
        )
    cx, cy, fx, fy, skew, *radial = lens
    pose = RigidTransform(_rotation(place[:3]), np.array(place[3:]))
    return Camera(
        size, np.array([fx, fy]), np.array([cx, cy]), np.array(radial), skew=skew, pose=pose
    )


def _angles(rotation: Floats) -> list[float]:
    """Give the turns about the fixed axes x, y, z one after the other, degrees."""
    return [float(a) for a in Rotation.from_matrix(rotation).as_euler("xyz", degrees=True)]


def _rotation(angles: Sequence[float]) -> Floats:
    matrix: Floats = Rotation.from_euler("xyz", list(angles), degrees=True).as_matrix()
    return matrix


def _words(values: Sequence[float]) -> str:
    return " ".join(f"{value:.12e}" for value in values)


# --- MatchID -------------------------------------------------------------------------

_MATCHID = (
    *("Fx [pixels]", "Fy [pixels]", "Fs [pixels]", "Kappa 1", "Kappa 2", "Kappa 3", "P1", "P2"),
    *("Cx [pixels]", "Cy [pixels]"),
)


def matchid_text(rig: Rig) -> str:
    """Write as MatchID exports a calibration."""
    left, right, motion = _two(rig)
    lines = []
    for number, camera in enumerate((left, right)):
        values = [*camera.focal, camera.skew, *camera.radial, *camera.tangential, *camera.centre]
        lines += [f"Cam{number}_{k};{float(v)!r}" for k, v in zip(_MATCHID, values, strict=True)]
    shifts = zip(("Tx", "Ty", "Tz"), motion.translation, strict=True)
    lines += [f"{name} [mm];{float(value)!r}" for name, value in shifts]
    turns = zip(("Theta", "Phi", "Psi"), _angles(motion.rotation), strict=True)
    lines += [f"{name} [deg];{value!r}" for name, value in turns]
    return "\n".join(lines) + "\n"


def parse_matchid(text: str, size: tuple[int, int]) -> Rig:
    """Read a MatchID calibration; cameras may count from 0 or from 1."""
    table = {}
    for line in text.splitlines():
        key, _, value = line.partition(";")
        if value.strip():
            table[re.sub(r"\s*\[.*\]|\s", "", key)] = float(value)
    first = 0 if "Cam0_Fx" in table else 1
    if f"Cam{first}_Fx" not in table or f"Cam{first + 1}_Fx" not in table:
        raise DataError("expected Cam0_Fx and Cam1_Fx in it")
    cameras = [_matchid_camera(table, f"Cam{first + k}_", size) for k in (0, 1)]
    angles = [table[name] for name in ("Theta", "Phi", "Psi")]
    shift = np.array([table[name] for name in ("Tx", "Ty", "Tz")])
    return _stereo(cameras[0], cameras[1], _rotation(angles), shift)


def _matchid_camera(table: dict[str, float], prefix: str, size: tuple[int, int]) -> Camera:
    def numbers(*names: str) -> Floats:
        return np.array([table.get(prefix + name, 0.0) for name in names])

    return Camera(
        size,
        numbers("Fx", "Fy"),
        numbers("Cx", "Cy"),
        numbers("Kappa1", "Kappa2", "Kappa3"),
        numbers("P1", "P2"),
        table.get(prefix + "Fs", 0.0),
    )


# --- OpenCorr ------------------------------------------------------------------------

_OPENCORR = ("Fx", "Fy", "Fs", "Cx", "Cy", "K1", "K2", "K3", "K4", "K5", "K6", "P1", "P2")
_PLACE = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


def opencorr_text(rig: Rig) -> str:
    """Write a name and a value for each camera on each line."""
    left, right, motion = _two(rig)
    columns = []
    for camera, pose in ((left, RigidTransform.identity()), (right, motion)):
        lens = [*camera.focal, camera.skew, *camera.centre, *camera.radial, 0.0, 0.0, 0.0]
        turn = Rotation.from_matrix(pose.rotation).as_rotvec()
        columns.append([*lens, *camera.tangential, *pose.translation, *turn])
    rows = zip((*_OPENCORR, *_PLACE), *columns, strict=True)
    lines = [f"{name},{float(one)!r},{float(two)!r}" for name, one, two in rows]
    return "\n".join(["parameter,left,right", *lines]) + "\n"


def parse_opencorr(text: str, size: tuple[int, int]) -> Rig:
    """Read a calibration of OpenCorr, which goes by the order of the lines, not by their names."""
    rows = [row for row in csv.reader(io.StringIO(text)) if any(word.strip() for word in row)][1:]
    names = (*_OPENCORR, *_PLACE)
    for name, row in zip(names, rows, strict=False):
        if len(row) < 3:
            raise DataError(f"expected {name} as name,left,right, got {','.join(row)!r}")
    if len(rows) < len(names):
        raise DataError(
            f"expected a line of titles and {len(names)} lines name,left,right, "
            f"got {len(rows)} of them, {names[len(rows)]} is missing"
        )
    left, right = (
        {name: float(row[k]) for name, row in zip(names, rows, strict=False)} for k in (1, 2)
    )
    if any(column[name] for column in (left, right) for name in ("K4", "K5", "K6")):
        raise DataError("expected distortion k1, k2, k3, got further terms")
    poses = [_opencorr_pose(column) for column in (left, right)]
    cameras = [
        _opencorr_camera(column, size).placed(pose)
        for column, pose in zip((left, right), poses, strict=True)
    ]
    motion = Rig((cameras[0], cameras[1]), NAMES).between(0, 1)
    still = cameras[0].placed(RigidTransform.identity())
    return _stereo(still, cameras[1], motion.rotation, motion.translation)


def _opencorr_pose(column: dict[str, float]) -> RigidTransform:
    shift, turn = (np.array([column[name] for name in names]) for names in (_PLACE[:3], _PLACE[3:]))
    return RigidTransform(Rotation.from_rotvec(turn).as_matrix(), shift)


def _opencorr_camera(column: dict[str, float], size: tuple[int, int]) -> Camera:
    def numbers(*names: str) -> Floats:
        return np.array([column[name] for name in names])

    return Camera(
        size,
        numbers("Fx", "Fy"),
        numbers("Cx", "Cy"),
        numbers("K1", "K2", "K3"),
        numbers("P1", "P2"),
        column["Fs"],
    )
