"""Finite element results in the forms that programs write, and what is refused."""

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.errors import DataError
from shapemorph.core.laws import NodalField, RadialProfile
from shapemorph.io.fe_files import read_dots, read_finite_elements

NODES = np.random.default_rng(0).uniform(-3, 5, (9, 3))
SHIFT = np.random.default_rng(1).normal(size=(9, 3))
CELLS = [("tetra", np.arange(8).reshape(2, 4))]


def _read(path, **how):
    return read_finite_elements(path, **{"scale": 1.0, "model": "solid", **how})


@pytest.mark.parametrize("suffix", ["vtu", "vtk"])
@pytest.mark.parametrize("name", ["U", "displacement"])
def test_displacements_at_nodes_are_found_by_their_usual_names(tmp_path, suffix, name):
    path = tmp_path / f"model.{suffix}"
    others = {"stress": np.ones((9, 6)), name: SHIFT}
    meshio.Mesh(NODES, CELLS, point_data=others).write(path)
    found = _read(path, scale=25.4)
    assert isinstance(found, NodalField)
    assert_allclose(found.nodes, 25.4 * NODES, rtol=1e-12)
    assert_allclose(found.displacement, 25.4 * SHIFT, rtol=1e-12)


def test_another_name_can_be_given_and_a_missing_one_says_what_there_is(tmp_path):
    path = tmp_path / "model.vtu"
    meshio.Mesh(NODES, CELLS, point_data={"shift": SHIFT, "T": np.ones(9)}).write(path)
    assert_allclose(_read(path, displacement="Shift").displacement, SHIFT, rtol=1e-12)
    with pytest.raises(DataError, match=r"got shift, T: set morph\.fe_displacement"):
        _read(path)


def test_two_abaqus_meshes_with_the_same_nodes_make_a_field(tmp_path):
    for name, points in (("before", NODES), ("after", NODES + SHIFT)):
        meshio.Mesh(points, CELLS).write(tmp_path / f"{name}.inp")
    found = _read(tmp_path / "before.inp", moved=tmp_path / "after.inp")
    assert_allclose(found.displacement, SHIFT, atol=1e-12)
    meshio.Mesh(NODES[:8], CELLS).write(tmp_path / "fewer.inp")
    with pytest.raises(DataError, match=r"expected the 9 nodes of before\.inp, got 8"):
        _read(tmp_path / "before.inp", moved=tmp_path / "fewer.inp")


def _frd(long):
    """Two steps of a CalculiX result in its text form, by its manual."""
    width, form = (10, 1) if long else (5, 0)

    def block(values):
        for label, row in enumerate(values, start=1):
            yield f" -1{label:{width}d}" + "".join(f"{value:12.5E}" for value in row)
        yield " -3"

    yield "    1C"
    yield f"    2C{9:30d}{form:38d}"
    yield from block(NODES)
    yield f"    3C{2:30d}{form:38d}"
    yield " -1         1    3    0    1"
    yield " -3"
    for step, part in ((1, 0.5), (2, 1.0)):
        yield f"  100CL  10{step}{part:12.5E}{9:12d}{0:22d}{step:5d}{form:12d}"
        yield " -4  DISP        4    1"
        yield " -5  D1          1    2    1    0"
        yield from block(part * SHIFT)
        yield " -4  STRESS      6    1"
        yield from block(np.ones((9, 6)))
    yield " 9999"


@pytest.mark.parametrize("long", [True, False])
def test_calculix_gives_the_displacements_of_its_last_step(tmp_path, long):
    path = tmp_path / "model.frd"
    path.write_text("\n".join(_frd(long)))
    found = _read(path)
    assert_allclose(found.nodes, NODES, atol=6e-5)  # five digits
    assert_allclose(found.displacement, SHIFT, atol=6e-5)


def test_calculix_without_displacements_is_refused(tmp_path):
    path = tmp_path / "model.frd"
    path.write_text("\n".join(line for line in _frd(True) if "DISP" not in line))
    with pytest.raises(DataError, match="ask CalculiX"):
        _read(path)


def test_an_axisymmetric_mesh_becomes_the_profile_of_its_middle(tmp_path):
    radius = np.linspace(0, 20, 6)
    layers = [np.column_stack([radius, np.full(6, y), np.zeros(6)]) for y in (-0.5, 0.5)]
    nodes = np.concatenate(layers)
    shift = np.column_stack([0.1 * nodes[:, 0], 8.0 - 0.02 * nodes[:, 0] ** 2, np.zeros(12)])
    cells = [("quad", np.array([[k, k + 1, k + 7, k + 6] for k in range(5)]))]
    meshio.Mesh(nodes, cells, point_data={"U": shift}).write(tmp_path / "sheet.vtu")
    found = _read(tmp_path / "sheet.vtu", model="axisymmetric", scale=2.0)
    assert isinstance(found, RadialProfile)
    assert_allclose(found.material, 2 * radius)
    assert_allclose(found.radius, 2 * 1.1 * radius)
    assert_allclose(found.height, 2 * (8.0 - 0.02 * radius**2))


def test_tables_are_told_apart_by_their_header(tmp_path):
    profile = tmp_path / "profile.csv"
    profile.write_text("r0,r,z\n10,12,1\n0,0,3\n5,6,2.5\n")
    found = _read(profile, scale=10.0)
    assert found.material.tolist() == [0, 50, 100]
    assert found.height.tolist() == [30, 25, 10]
    field = tmp_path / "field.csv"
    rows = [",".join(map(str, [*node, *shift])) for node, shift in zip(NODES, SHIFT, strict=True)]
    field.write_text("x,y,z,ux,uy,uz\n" + "\n".join(rows))
    assert_allclose(_read(field).displacement, SHIFT)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "a,b\n1,2\n3,4\n", "expected the header r0,r,z or x,y,z,ux,uy,uz, got a,b"),
        ("a.csv", "r0,r,z\n1,2\n3,4,5\n", "line 2: expected 3 numbers"),
        ("a.csv", "r0,r,z\n1,2,nan\n3,4,5\n", "line 2: expected 3 numbers"),
        ("a.csv", "r0,r,z\n1,2,3\n1,4,5\n", "expected at least two different radii"),
        ("a.csv", "", "a.csv"),
        ("a.vtu", "hello", "cannot be read as a finite element mesh"),
        ("a.vtk", "hello", "cannot be read as a finite element mesh"),
        ("a.inp", "hello", "cannot be read as a finite element mesh"),
        ("a.odb", "hello", "cannot be read as a finite element mesh"),
        ("a.frd", "hello", "expected nodes and displacements"),
    ],
)
def test_what_is_no_result_is_refused_in_one_line(tmp_path, capfd, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(DataError, match=message) as refusal:
        _read(tmp_path / name)
    assert "\n" not in str(refusal.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["absent.vtu", "absent.csv", "absent.frd"])
def test_a_missing_file_is_said_so(tmp_path, name):
    with pytest.raises(DataError, match="absent"):
        _read(tmp_path / name)


def test_dots_are_read_in_pairs(tmp_path):
    path = tmp_path / "dots.csv"
    path.write_text("x_ref_px,y_ref_px,x_def_px,y_def_px\n1,2,3,4\n5,6,7,8.5\n")
    reference, deformed = read_dots(path)
    assert reference.tolist() == [[1, 2], [5, 6]]
    assert deformed.tolist() == [[3, 4], [7, 8.5]]
