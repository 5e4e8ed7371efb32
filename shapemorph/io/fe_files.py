"""Results of finite element programs: radial profiles and displacement fields."""

import csv
import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, Literal

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.laws import NodalField, RadialProfile
from shapemorph.io.frd import read_frd
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import decode_text

PROFILE_COLUMNS = ("r0", "r", "z")
FIELD_COLUMNS = ("x", "y", "z", "ux", "uy", "uz")
DISPLACEMENT_NAMES = ("displacement", "displacements", "u", "disp", "uvw", "depl")
SAME_RADIUS = 1e-6  # of the largest: nodes through the thickness stand above each other
Model = Literal["solid", "axisymmetric"]


def read_finite_elements(
    path: Path,
    *,
    scale: float,
    model: Model,
    moved: Path | None = None,
    displacement: str | None = None,
) -> RadialProfile | NodalField:
    """Read a finite element result as a law.

    Parameters
    ----------
    path : Path
        CSV ``r0,r,z`` (a profile) or ``x,y,z,ux,uy,uz`` (a field), CalculiX ``.frd``, or any
        mesh that meshio reads (VTU, VTK, Abaqus ``.inp``, ...).
    scale : float
        mm per unit of the file.
    model : "solid" or "axisymmetric"
        Axisymmetric meshes have the radius as x and the axis as y; nodes of one radius
        (through the thickness) are averaged.
    moved : Path, optional
        Second mesh with the same nodes where they went, for files without displacements.
    displacement : str, optional
        Name of the displacements at the nodes; None: the usual names.

    Raises
    ------
    DataError
        If the file is missing, of no known form, or holds no displacements.
    """
    if path.suffix.lower() == ".csv":
        found = _read_csv(path)
    else:
        found = _read_mesh(path, moved, displacement)
    if isinstance(found, NodalField) and model == "axisymmetric":
        found = _profile_of(found, path.name)
    return _scaled(found, scale)


def read_dots(path: Path) -> tuple[Floats, Floats]:
    """Read marks in two pictures: CSV ``x_ref_px,y_ref_px,x_def_px,y_def_px``.

    Returns
    -------
    reference, deformed : (K, 2)
        px.

    Raises
    ------
    DataError
        If it is missing or has another form.
    """
    columns = ("x_ref_px", "y_ref_px", "x_def_px", "y_def_px")
    table = _table(path, [columns])[1]
    return table[:, :2], table[:, 2:]


def _read_csv(path: Path) -> RadialProfile | NodalField:
    columns, table = _table(path, [PROFILE_COLUMNS, FIELD_COLUMNS])
    if columns == FIELD_COLUMNS:
        return NodalField(table[:, :3], table[:, 3:])
    table = table[np.argsort(table[:, 0], kind="stable")]
    return _checked(RadialProfile(*table.T), path.name)


def _table(path: Path, forms: list[tuple[str, ...]]) -> tuple[tuple[str, ...], Floats]:
    """Read the header and the numbers of a CSV of one of several forms."""
    text = decode_text(read_bytes(path, what="table"))
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline="")) if any(row)]
    except csv.Error as error:
        raise DataError(f"{path.name}: expected a CSV file, got something else ({error})") from None
    header = tuple(cell.strip().lower() for cell in rows[0]) if rows else ()
    if header not in forms:
        wanted = " or ".join(",".join(form) for form in forms)
        raise DataError(
            f"{path.name}: expected the header {wanted}, got {','.join(header)[:80] or 'nothing'}"
        )
    numbers = [_numbers(path.name, line, row, header) for line, row in enumerate(rows[1:], start=2)]
    if len(numbers) < 2:
        raise DataError(f"{path.name}: expected at least two rows below the header")
    return header, np.array(numbers, np.float64)


def _numbers(name: str, line: int, row: list[str], header: tuple[str, ...]) -> list[float]:
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        values = []
    if len(values) != len(header) or not np.isfinite(values).all():
        raise DataError(
            f"{name}, line {line}: expected {len(header)} numbers ({','.join(header)}), got "
            f"{','.join(row)[:60]!r}"
        )
    return values


def _read_mesh(path: Path, moved: Path | None, displacement: str | None) -> NodalField:
    if path.suffix.lower() == ".frd":
        nodes, shift = read_frd(path)
        return NodalField(nodes, shift)
    mesh = _load(path)
    nodes = _in_space(np.asarray(mesh.points, np.float64))
    if moved is not None:
        after = _in_space(np.asarray(_load(moved).points, np.float64))
        if after.shape != nodes.shape:
            raise DataError(
                f"{moved.name}: expected the {len(nodes)} nodes of {path.name}, got {len(after)}"
            )
        return NodalField(nodes, after - nodes)
    return NodalField(nodes, _displacement(mesh.point_data, displacement, nodes, path.name))


def _load(path: Path) -> Any:
    """Let meshio read a mesh; its complaints, some of them printed, become ours."""
    import meshio

    if not path.is_file():
        raise DataError(f"{path} does not exist: expected a finite element result")
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            mesh = meshio.read(path)
        if np.ndim(mesh.points) == 2 and len(mesh.points) > 0:
            return mesh
        reason = "no nodes"
    except SystemExit:
        reason = "unknown form"
    except (
        meshio.ReadError,
        OSError,
        ValueError,
        LookupError,
        TypeError,
        ArithmeticError,
    ) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    raise DataError(
        f"{path.name} cannot be read as a finite element mesh ({reason[:120]}): expected CSV, frd, "
        "or what meshio reads (vtu, vtk, inp, ...)"
    )


def _displacement(data: dict[str, Any], wanted: str | None, nodes: Floats, name: str) -> Floats:
    """Find the displacements among the values at the nodes."""
    by_name = {key.lower(): np.asarray(values) for key, values in data.items()}
    names = (wanted.lower(),) if wanted else DISPLACEMENT_NAMES
    for key in names:
        if key in by_name and by_name[key].ndim == 2 and len(by_name[key]) == len(nodes):
            return _in_space(by_name[key].astype(np.float64))
    raise DataError(
        f"{name}: expected displacements at the nodes ({', '.join(names)}), got "
        f"{', '.join(data) or 'no values'}: set morph.fe_displacement, or morph.fe_deformed to a "
        "mesh with the same nodes after the deformation"
    )


def _in_space(vectors: Floats) -> Floats:
    """(N, 3) from vectors of two or three components."""
    missing = np.zeros((len(vectors), 3 - vectors.shape[1]))
    return np.hstack([vectors, missing])


def _profile_of(field: NodalField, name: str) -> RadialProfile:
    """Mean profile of an axisymmetric mesh: x is the radius, y the axis."""
    order = np.argsort(field.nodes[:, 0], kind="stable")
    material = field.nodes[order, 0]
    after = (field.nodes + field.displacement)[order]
    near = SAME_RADIUS * max(float(material[-1]), 1e-300)
    group = np.cumsum(np.concatenate([[False], np.diff(material) > near]))
    count = np.bincount(group)
    parts = (material, after[:, 0], after[:, 1])
    means = [np.bincount(group, weights=part) / count for part in parts]
    return _checked(RadialProfile(*means), name)


def _checked(profile: RadialProfile, name: str) -> RadialProfile:
    material = profile.material
    if len(material) < 2 or material[0] < 0 or not (np.diff(material) > 0).all():
        raise DataError(
            f"{name}: expected at least two different radii r0 >= 0, each once, got "
            f"{np.array2string(material[:6], precision=4)}"
        )
    return profile


def _scaled(found: RadialProfile | NodalField, scale: float) -> RadialProfile | NodalField:
    if isinstance(found, NodalField):
        return NodalField(found.nodes * scale, found.displacement * scale)
    return RadialProfile(found.material * scale, found.radius * scale, found.height * scale)
