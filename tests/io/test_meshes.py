"""`read_mesh`: any file becomes one clean surface in mm, or one line that says what to change."""

import dataclasses
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.meshes import READERS, read_mesh
from shapemorph.methods.gluing import face_areas

DATA = Path(os.environ.get("SHAPEMORPH_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))
PATTERN = np.random.default_rng(0).integers(0, 256, (64, 96), dtype=np.uint8)


def write_sheet(folder, *, name="part.obj", change=lambda text: text, picture=PATTERN, skip=()):
    """A textured sheet of 4 x 3 quads with a seam: every quad row has its own vt."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(4.0)))
    lines = [f"mtllib {Path(name).stem}.mtl", "usemtl skin"]
    lines += [f"v {a} {b} {0.1 * a * b:.6g}" for a, b in zip(x, y, strict=True)]
    corner = 0
    for row in range(3):
        for column in range(4):
            first = row * 5 + column + 1
            quad = [first, first + 1, first + 6, first + 5]
            for vertex in quad:
                lines.append(f"vt {x[vertex - 1] / 4} {y[vertex - 1] / 3}")
            lines.append("f " + " ".join(f"{v}/{corner + k + 1}" for k, v in enumerate(quad)))
            corner += 4
    path = folder / name
    path.write_text(change("\n".join(lines) + "\n"))
    material = "newmtl skin\nmap_Kd skin.png\n"
    if "mtl" not in skip:
        path.with_suffix(".mtl").write_text(material)
    if picture is not None:
        Image.fromarray(picture).save(folder / "skin.png")
    return path


@pytest.mark.parametrize(
    ("unit", "scale"), [("mm", 1.0), ("um", 1e-3), ("cm", 10.0), ("m", 1000.0), ("in", 25.4)]
)
def test_lengths_are_in_mm_whatever_the_unit_of_the_file(tmp_path, unit, scale):
    mesh, report = read_mesh(write_sheet(tmp_path), unit=unit)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), np.array([4, 3, 1.2]) * scale)
    assert report.unit == unit


def test_the_report_counts_what_was_mended_and_can_be_stored(tmp_path):
    def dirty(text):
        text += "v 9 9 9\nf 1/1 1/1 2/2\nf 1/1 2/2 7/3\n"  # unused, degenerate, duplicate
        text += "v 50 0 0\nv 50.1 0 0\nv 50 0.1 0\nf 22/1 23/2 24/3\n"  # a crumb
        text += "f 1 2 7\n"  # no texture
        return text

    mesh, report = read_mesh(write_sheet(tmp_path, change=dirty), unit="mm")
    assert (report.vertices, report.faces) == (20, 24) == (len(mesh.vertices), len(mesh.faces))
    assert report.polygons_split == 12
    assert report.unreferenced_vertices == report.degenerate_faces == report.duplicate_faces == 1
    assert (report.components, report.dropped_faces) == (2, 1)
    assert (report.boundary_loops, report.euler_characteristic) == (1, 1)
    assert report.texture_sizes == ((64, 96),)
    assert (report.file_format, report.grey_source) == ("OBJ", "texture")
    assert "1 of 28 faces have no texture" in " ".join(report.notes)
    json.dumps(dataclasses.asdict(report))


def test_vertices_along_a_seam_are_welded_and_keep_both_uv(tmp_path):
    def cut(text):  # a second copy of the last row of quads' vertices, as scanners write seams
        lines = text.splitlines()
        vertices = [line for line in lines if line.startswith("v ")]
        faces = [line for line in lines if line.startswith("f ")]
        rest = [line for line in lines if not line.startswith("f ")]
        moved = [" ".join(_moved(c) for c in f.split()) for f in faces[8:]]
        return "\n".join([*rest, *vertices[10:], *faces[:8], *moved]) + "\n"

    def _moved(corner):
        vertex, _, uv = corner.partition("/")
        return corner if not uv else f"{int(vertex) + 10}/{uv}"

    whole, _ = read_mesh(write_sheet(tmp_path), unit="mm")
    mesh, report = read_mesh(write_sheet(tmp_path, change=cut), unit="mm")
    assert report.welded_vertices == 5
    assert report.components == 1
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], whole.vertices[whole.faces])
    np.testing.assert_array_equal(mesh.wedge_uv, whole.wedge_uv)


@pytest.mark.parametrize("ending", [".OBJ", ".Obj"])
def test_the_suffix_counts_in_either_case(tmp_path, ending):
    path = write_sheet(tmp_path)
    mesh, _ = read_mesh(path.rename(path.with_suffix(ending)), unit="mm")
    assert mesh.name == "part" + ending


def refused(path, unit="mm"):
    """The message, which must be one line."""
    with pytest.raises(DataError) as caught:
        read_mesh(path, unit=unit)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_paths_that_are_no_mesh_file_are_refused(tmp_path):
    assert "does not exist" in refused(tmp_path / "none.obj")
    assert "folder" in refused(_made(tmp_path / "folder.obj"))
    (tmp_path / "empty.ply").write_bytes(b"")
    assert "is empty" in refused(tmp_path / "empty.ply")
    (tmp_path / "part.stl").write_bytes(b"solid")
    assert "STL, which cannot store colour" in refused(tmp_path / "part.stl")
    assert ".glb" in refused(tmp_path / "part.stl")
    (tmp_path / "part.step").write_bytes(b"x")
    assert "got .step" in refused(tmp_path / "part.step")
    (tmp_path / "part").write_bytes(b"x")
    assert "no suffix" in refused(tmp_path / "part")
    assert "folder" in refused(_made(tmp_path / "scans"))
    assert "does not exist" in refused(tmp_path / "scan.step")


def _made(folder):
    folder.mkdir()
    return folder


@pytest.mark.parametrize("suffix", sorted(READERS))
def test_binary_garbage_is_refused_in_every_format(tmp_path, suffix):
    path = tmp_path / f"noise{suffix}"
    path.write_bytes(np.random.default_rng(9).bytes(5000))
    assert path.name in refused(path)


def test_an_unknown_unit_is_an_error_of_the_configuration(tmp_path):
    with pytest.raises(ConfigError, match="'ft'"):
        read_mesh(write_sheet(tmp_path), unit="ft")


def test_textures_that_carry_nothing_are_refused(tmp_path):
    blank = np.full((64, 96), 128, dtype=np.uint8)
    assert "blank texture" in refused(write_sheet(tmp_path, picture=blank))
    path = write_sheet(tmp_path)
    (tmp_path / "skin.png").unlink()
    assert "'skin.png' does not exist" in refused(path)
    write_sheet(tmp_path)
    whole = (tmp_path / "skin.png").read_bytes()
    (tmp_path / "skin.png").write_bytes(whole[: len(whole) // 2])
    assert "skin.png: expected a whole picture" in refused(path)
    (tmp_path / "skin.png").write_text("not a picture")
    assert "skin.png is not a picture" in refused(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace("v 2.0 1.0 0.2", "v 2.0 nan 0.2"), "NaN, infinity"),
        (lambda t: t.replace("v 2.0 1.0 0.2", "v 2.0 inf 0.2"), "NaN, infinity"),
        (lambda t: "\n".join(x for x in t.splitlines() if x[0] != "f"), "expected faces"),
        (lambda t: t.replace("f 1/1 2/2", "f 1/1 99/2"), "line 27: expected v numbers"),
        (lambda t: "".join(f"{x}\n" if x[:2] != "v " else "v 1 1 1\n" for x in t.splitlines()),
         "all vertices at one point"),
        (lambda t: "".join(f"{x}\n" if x[:2] != "v " else f"v {k} 0 0\n"
                           for k, x in enumerate(t.splitlines())), "triangles with an area"),
        (lambda t: t.replace("vt 0.25 0.0", "vt 250000 0"), "texture coordinates near"),
    ],
)  # fmt: skip
def test_geometry_that_cannot_be_mended_is_refused(tmp_path, change, message):
    assert message in refused(write_sheet(tmp_path, change=change))


def shared(name):
    path = DATA / name
    if not path.exists():
        pytest.skip(f"{name} is not on this machine: set SHAPEMORPH_DATA to the folder of data")
    return path


@pytest.mark.parametrize(
    ("stem", "texture"), [("neutral", (2048, 2048)), ("mouthSmile_L", (2600, 2600))]
)
def test_the_real_face_is_read_whole(stem, texture):
    path = shared("ict_face_textured_pair")
    mesh, report = read_mesh(path / f"{stem}.obj", unit="cm")
    truth = np.load(path / "truth.npz")
    key = "ref_vertices" if stem == "neutral" else f"{stem}_vertices"
    # The deformed file has its own pose and order: areas do not see either. Six digits in
    # the file leave a thousandth of the area of its smallest faces.
    got = np.sort(face_areas(mesh.vertices, mesh.faces))
    expected = np.sort(face_areas(10 * truth[key], truth["triangles"]))
    np.testing.assert_allclose(got, expected, rtol=2e-3, atol=1e-4)
    assert report.texture_sizes == (texture,)
    assert (report.components, report.boundary_loops) == (1, 4)
    assert 0.05 < np.std(mesh.textures[0]) < 0.5


def test_the_real_fuze_is_the_same_surface_as_obj_and_as_ply():
    folder = shared("trimesh_fuze_textured")
    one, report = read_mesh(folder / "fuze.obj", unit="mm")
    other, _ = read_mesh(folder / "fuze.ply", unit="mm")
    np.testing.assert_allclose(one.vertices[one.faces], other.vertices[other.faces], atol=1e-6)
    np.testing.assert_allclose(one.wedge_uv, other.wedge_uv, atol=1e-6)
    np.testing.assert_array_equal(one.textures[0], other.textures[0])
    assert "closed surface of genus 0" in report.notes


def test_only_a_cloud_of_points_has_no_outer_side(tmp_path):
    assert read_mesh(write_sheet(tmp_path), unit="mm")[0].sided
    points = np.random.default_rng(0).random((60, 4))
    np.savetxt(tmp_path / "cloud.csv", points * [9, 9, 0.1, 1], delimiter=",")
    assert not read_mesh(tmp_path / "cloud.csv", unit="mm")[0].sided
