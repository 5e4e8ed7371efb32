"""Writing and reading `truth.npz`, and the folder of a synthetic pair."""

import io
import math
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.synthetic import DamageSpot, SyntheticPair, Truth, TruthPoints
from shapemorph.core.transform import RigidTransform
from shapemorph.io.mesh_writers import write_mesh

TRUTH = "truth.npz"
TABLE_DIGITS = 11  # of the table, relative to the size: the last bits differ between processors


def write_pair(folder: Path, pair: SyntheticPair, *, file_format: str) -> list[Path]:
    """Write reference, deformed and truth.npz into a folder, made where it is missing.

    All files are finished in a temporary folder inside and then moved: a run that is
    killed leaves none half-written.

    Returns
    -------
    list of Path
        The files, the meshes first.

    Raises
    ------
    DataError
        If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".synthesize-") as temporary:
            room = Path(temporary)
            files = write_mesh(room / f"reference.{file_format}", pair.reference)
            files += write_mesh(room / f"deformed.{file_format}", pair.deformed)
            files.append(write_truth(room / TRUTH, pair.truth))
            return [file.replace(folder / file.name) for file in files]
    except OSError as problem:
        raise DataError(
            f"cannot write into {folder}: {problem.strerror}: choose another folder"
        ) from problem


def write_truth(path: Path, truth: Truth) -> Path:
    """Write a truth: its parameters, both poses and the table.

    Arrays: `shape`, `size`, `offset` (mm), `tilt` (radians), `reference_file_from_body` and
    `deformed_file_from_body` (4, 4), `damage_kind`, `damage_centre`, `damage_radius`; and the
    table, one row a material point: `material` (2), `reference` and `deformed` (3; mm, frames
    of the files), `E1`, `E2` (Green-Lagrange), `rim_distance`, `kink_distance` (mm), `visible`,
    rounded to 1e-11 (strain) and 1e-11 of the size or finer (mm).
    """
    table = truth.table
    digits = TABLE_DIGITS - math.floor(math.log10(truth.size))
    _write_arrays(
        path,
        shape=np.array(truth.shape),
        size=np.array(truth.size),
        offset=np.array(truth.offset),
        tilt=np.array(truth.tilt),
        reference_file_from_body=_matrix(truth.reference_pose),
        deformed_file_from_body=_matrix(truth.deformed_pose),
        damage_kind=np.array([spot.kind for spot in truth.damage], dtype="U16"),
        damage_centre=np.array([spot.centre for spot in truth.damage]).reshape(-1, 2),
        damage_radius=np.array([spot.radius for spot in truth.damage], dtype=np.float64),
        material=np.round(table.material, digits),
        reference=np.round(table.reference, digits),
        deformed=np.round(table.deformed, digits),
        E1=np.round(table.e1, TABLE_DIGITS),
        E2=np.round(table.e2, TABLE_DIGITS),
        rim_distance=np.round(table.rim_distance, digits),
        kink_distance=np.round(table.kink_distance, digits),
        visible=table.visible,
    )
    return path


def _write_arrays(path: Path, **arrays: np.ndarray) -> None:
    """Write a compressed npz whose bytes do not depend on the version of Python.

    `numpy.savez` leaves the entries' headers to `zipfile`, which has changed them.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, np.asarray(array, order="C"), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{name}.npy")
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            archive.writestr(entry, content.getvalue())


def read_truth(path: Path) -> Truth:
    """Read a truth.

    Raises
    ------
    DataError
        If the file is missing or is not a truth.
    """
    if not path.is_file():
        raise DataError(f"expected a truth.npz, found no file {path}: give the one of synthesize")
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        return _truth(arrays)
    except KeyError as problem:
        raise DataError(f"{_no_truth(path)}, it lacks the array {problem}") from problem
    except (TypeError, ValueError, zipfile.BadZipFile, zlib.error, EOFError) as problem:
        raise DataError(_no_truth(path)) from problem
    except OSError as problem:
        raise DataError(f"{path} cannot be read ({problem.strerror or problem})") from problem


def _no_truth(path: Path) -> str:
    return f"{path} is not a truth file: expected the truth.npz of `shapemorph synthesize`"


def _truth(arrays: dict[str, np.ndarray]) -> Truth:
    table = TruthPoints(
        material=arrays["material"],
        reference=arrays["reference"],
        deformed=arrays["deformed"],
        e1=arrays["E1"],
        e2=arrays["E2"],
        rim_distance=arrays["rim_distance"],
        kink_distance=arrays["kink_distance"],
        visible=arrays["visible"],
    )
    rows = zip(arrays["damage_kind"], arrays["damage_centre"], arrays["damage_radius"], strict=True)
    return Truth(
        shape=str(arrays["shape"]),
        size=float(arrays["size"]),
        offset=float(arrays["offset"]),
        tilt=float(arrays["tilt"]),
        reference_pose=_pose(arrays["reference_file_from_body"]),
        deformed_pose=_pose(arrays["deformed_file_from_body"]),
        damage=tuple(DamageSpot(str(kind), centre, float(radius)) for kind, centre, radius in rows),
        table=table,
    )


def _matrix(pose: RigidTransform) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
    return matrix


def _pose(matrix: Floats) -> RigidTransform:
    return RigidTransform(matrix[:3, :3], matrix[:3, 3])
