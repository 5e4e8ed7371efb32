"""OBJ files of every dialect give the same wedges, materials and textures."""

import numpy as np
import pytest
import trimesh
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.io.obj import read_obj

PATTERN = np.random.default_rng(0).integers(0, 256, (24, 40), dtype=np.uint8)

SQUARE = """v 0 0 0
v 2 0 0
v 2 1 0.5
v 0 1 0.5
vt 0.1 0.2
vt 0.9 0.2
vt 0.9 0.7
vt 0.1 0.7
"""
SQUARE_UV = np.array([[0.1, 0.2], [0.9, 0.2], [0.9, 0.7], [0.1, 0.7]])


def write(
    folder, text, name="mesh.obj", material="newmtl m\nmap_Kd skin.png\n", picture="skin.png"
):
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    if material is not None:
        (folder / "mesh.mtl").write_text(material)
    if picture is not None:
        Image.fromarray(PATTERN).save(folder / picture)
    return path


def textured(body):
    return "mtllib mesh.mtl\nusemtl m\n" + SQUARE + body


@pytest.mark.parametrize(
    "body",
    [
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
        "f 1/1 2/2 3/3 4/4\n",
        "f -4/-4 -3/-3 -2/-2 -1/-1\n",
        "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n",
        "f 1/1 2/2 \\\n  3/3 4/4\n",
        "  f 1/1\t2/2  3/3 4/4   # a quad\n",
        "g a\no b\ns 1\nf 1/1 2/2 3/3 4/4\nl 1 2\np 1\n",
        "f 1/1 2/2 3/3 4/4",
    ],
)
def test_every_way_to_write_a_face_gives_the_same_triangles(tmp_path, body):
    mesh = read_obj(write(tmp_path, textured(body)))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.wedge_uv, SQUARE_UV[[[0, 1, 2], [0, 2, 3]]])
    np.testing.assert_allclose(mesh.textures[0], PATTERN / 255.0, atol=1e-7)
    assert mesh.notes == ()


@pytest.mark.parametrize("ending", [b"\r\n", b"\r", b"\n"])
def test_line_breaks_of_every_system_and_a_byte_order_mark_are_read(tmp_path, ending):
    text = textured("# comment\n\nf 1/1 2/2 3/3 4/4\n").encode().replace(b"\n", ending)
    mesh = read_obj(write(tmp_path, b"\xef\xbb\xbf" + text))
    assert len(mesh.faces) == 2
    assert mesh.polygons_split == 1


def test_backward_numbers_count_from_their_own_line(tmp_path):
    text = "mtllib mesh.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    text += "f -3/-3 -2/-2 -1/-1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nvt 0.5 0.5\nf -3/-2 -2/-1 -1/1\n"
    mesh = read_obj(write(tmp_path, text))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [3, 4, 5]])
    np.testing.assert_array_equal(mesh.wedge_uv[1], [[0, 1], [0.5, 0.5], [0, 0]])


def test_faces_may_come_before_their_vertices(tmp_path):
    mesh = read_obj(write(tmp_path, "mtllib mesh.mtl\nusemtl m\nf 1/1 2/2 3/3\n" + SQUARE))
    np.testing.assert_array_equal(mesh.wedge_uv[0], SQUARE_UV[:3])


def test_one_vertex_keeps_a_different_uv_in_each_face(tmp_path):
    mesh = read_obj(write(tmp_path, textured("f 1/1 2/2 3/3\nf 1/4 3/2 4/1\n")))
    np.testing.assert_array_equal(mesh.wedge_uv[0, 0], SQUARE_UV[0])
    np.testing.assert_array_equal(mesh.wedge_uv[1, 0], SQUARE_UV[3])
    assert len(mesh.vertices) == 4


def test_a_reflex_quad_is_cut_with_its_uv(tmp_path):
    text = "mtllib mesh.mtl\nusemtl m\nv 0 0 0\nv 3 1 0\nv 0.6 0.6 0\nv 1 3 0\n"
    text += "vt 0 0\nvt 1 0.3\nvt 0.2 0.2\nvt 0.3 1\nf 2/2 3/3 4/4 1/1\n"
    mesh = read_obj(write(tmp_path, text))
    uv = np.array([[0, 0], [1, 0.3], [0.2, 0.2], [0.3, 1]])
    np.testing.assert_array_equal(mesh.wedge_uv, uv[mesh.faces])
    assert all(0 in face and 2 in face for face in mesh.faces)


def test_corners_without_vt_are_marked(tmp_path):
    mesh = read_obj(write(tmp_path, textured("f 1/1 2/2 3/3\nf 1 3 4\nf 1//1 3//1 4//1\n")))
    np.testing.assert_array_equal(np.isnan(mesh.wedge_uv).all(axis=(1, 2)), [False, True, True])


def test_several_materials_share_pictures_and_those_without_have_none(tmp_path):
    material = "newmtl a\nmap_Kd skin.png\nnewmtl b b\n\tmap_Kd other one.png\nnewmtl c\nKd 1 0 0\n"
    material += "newmtl d\nmap_Kd skin.png\n"
    Image.fromarray(PATTERN.T).save(tmp_path / "other one.png")
    body = "usemtl a\nf 1/1 2/2 3/3\nusemtl b b\nf 1/1 3/3 4/4\nusemtl c\nf 1/1 2/2 4/4\n"
    body += "usemtl d\nf 2/2 3/3 4/4\nusemtl a\nf 4/4 3/3 2/2\n"
    mesh = read_obj(write(tmp_path, "mtllib mesh.mtl\n" + SQUARE + body, material=material))
    np.testing.assert_array_equal(mesh.face_texture, [0, 1, -1, 0, 0])
    assert [texture.shape for texture in mesh.textures] == [(24, 40), (40, 24)]


@pytest.mark.parametrize(
    ("statement", "picture"),
    [
        ("map_Kd skin of a part.png", "skin of a part.png"),
        ("map_Kd -blendu on -mm 0 1 -bm 1.0 skin 1.png", "skin 1.png"),
        ("map_Kd -o 0 0 0 -s 1 1 1 2nd skin.png", "2nd skin.png"),
        ('map_Kd "skin.png"', "skin.png"),
        ("map_Kd .\\skin.png", "skin.png"),
        ("MAP_KD skin.png", "skin.png"),
        ("map_Kd -skin.png", "-skin.png"),
    ],
)
def test_options_and_blanks_of_map_kd_are_understood(tmp_path, statement, picture):
    text = textured("f 1/1 2/2 3/3\n")
    mesh = read_obj(write(tmp_path, text, material=f"newmtl m\n{statement}\n", picture=picture))
    assert mesh.notes == ()
    np.testing.assert_allclose(mesh.wedge_uv[0], SQUARE_UV[:3])


def test_scale_and_offset_of_a_picture_move_the_uv(tmp_path):
    material = "newmtl m\nmap_Kd -s 2 0.5 -o 0.25 -0.1 0 -clamp on skin.png\n"
    mesh = read_obj(write(tmp_path, textured("f 1/1 2/2 3/3\n"), material=material))
    np.testing.assert_allclose(mesh.wedge_uv[0], SQUARE_UV[:3] * [2, 0.5] + [0.25, -0.1])
    assert mesh.wrap == "clamp"


def test_a_picture_named_by_a_foreign_path_is_found_beside_the_mesh_and_said(tmp_path):
    material = "newmtl m\nmap_Kd C:\\scans\\monday\\SKIN.png\n"
    mesh = read_obj(write(tmp_path, textured("f 1/1 2/2 3/3\n"), material=material))
    assert "skin.png beside the mesh is used" in mesh.notes[0]


@pytest.mark.parametrize(
    ("pictures", "reason"),
    [
        (["mesh.jpg", "other.png"], "has the name of the mesh"),
        (["a mesh_texture.png", "other.png"], "contains that of the mesh"),
        (["anything.tif"], "only picture in the folder"),
    ],
)
def test_a_missing_material_file_is_replaced_by_the_obvious_picture(tmp_path, pictures, reason):
    for picture in pictures:
        Image.fromarray(PATTERN).save(tmp_path / picture)
    body = "mtllib gone.mtl\nusemtl m\n" + SQUARE + "f 1/1 2/2 3/3\n"
    mesh = read_obj(write(tmp_path, body, material=None, picture=None))
    assert mesh.notes[0] == "material file gone.mtl does not exist"
    assert pictures[0] in mesh.notes[1]
    assert reason in mesh.notes[1]


def test_two_equally_good_pictures_are_not_guessed_between(tmp_path):
    for picture in ("one.png", "two.png"):
        Image.fromarray(PATTERN).save(tmp_path / picture)
    with pytest.raises(DataError, match=r"one\.png, two\.png"):
        read_obj(write(tmp_path, SQUARE + "f 1/1 2/2 3/3\n", material=None, picture=None))


def test_faces_of_no_known_material_take_the_only_one_with_a_texture(tmp_path):
    mesh = read_obj(write(tmp_path, "mtllib mesh.mtl\n" + SQUARE + "f 1/1 2/2 3/3\n"))
    assert "m is used" in mesh.notes[0]
    np.testing.assert_array_equal(mesh.face_texture, [0])


def test_material_files_with_blanks_in_their_names_are_found(tmp_path):
    path = write(tmp_path, textured("f 1/1 2/2 3/3\n").replace("mesh.mtl", "my mesh.mtl"))
    (tmp_path / "mesh.mtl").rename(tmp_path / "my mesh.mtl")
    assert len(read_obj(path).textures) == 1


@pytest.mark.parametrize(("full", "written"), [(1.0, "{:.6f}"), (255.0, "{:.0f}")])
def test_vertex_colours_after_the_position_become_grey(tmp_path, full, written):
    rgb = np.random.default_rng(4).integers(0, 256, (4, 3)) / 255.0
    rgb[0] = 1.0
    lines = [
        f"v {k} {k * k} 0 " + " ".join(written.format(c * full) for c in rgb[k]) for k in range(4)
    ]
    text = "\n".join([*lines, "f 1 2 3", "f 1 3 4"])
    mesh = read_obj(write(tmp_path, text, material=None, picture=None))
    expected = rgb @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(mesh.corner_grey, expected[[[0, 1, 2], [0, 2, 3]]], atol=2e-6)
    assert mesh.grey_source == "vertex colours"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (textured("f 1/1 2/2 9/3\n"), r"line 11: expected v numbers from 1 to 4, got 9"),
        (textured("f 1/1 2/2 3/9\n"), r"line 11: expected vt numbers from 1 to 4, got 9"),
        (textured("f 0/1 2/2 3/3\n"), r"line 11: expected v numbers .* got 0"),
        (textured("f -5/1 2/2 3/3\n"), r"line 11: expected v numbers .* got -5"),
        (textured("f 1/-5 2/2 3/3\n"), r"line 11: expected vt numbers .* got -5"),
        (textured("f 1/1 2/2 3/x\n"), r"line 11: expected corners .* got 'x'"),
        (textured("f 1/1 2/2 3.5/3\n"), r"line 11: expected corners .* got '3.5'"),
        (textured("f 1/1 2/2 /3\n"), r"line 11: .*misplaced slash"),
        (textured("f 1/1/1/1 2/2 3/3\n"), r"line 11: .*misplaced slash"),
        (textured("v 1 2 z\nf 1/1 2/2 3/3\n"), r"line 11: expected numbers after v, got 'z'"),
        (textured("v 1 2\nf 1/1 2/2 3/3\n"), r"line 11: expected 3 or more numbers after v, got 2"),
        (textured(""), "expected faces"),
        (textured("f 1/1 2/2\n"), "expected faces"),
        ("just words\n", "expected an OBJ file with vertices"),
        (b"v 1 2 3\n\0\0\0", "binary data"),
        (textured("v 1 nan 3\nf 1/1 2/2 5/3\n"), r"NaN, infinity .* in 1 vertices .*number 5"),
    ],
)
def test_damaged_text_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        read_obj(write(tmp_path, text))


@pytest.mark.parametrize(
    ("material", "picture", "message"),
    [
        ("newmtl m\nmap_Kd gone.png\n", None, "texture 'gone.png' does not exist"),
        ("newmtl m\nKd 0.5 0.5 0.5\n", "skin.png", "add a line map_Kd"),
        ("newmtl m\nmap_Kd skin.png\n\0", "skin.png", "got binary data"),
    ],
)
def test_materials_that_lead_nowhere_are_refused(tmp_path, material, picture, message):
    path = write(tmp_path, textured("f 1/1 2/2 3/3\n"), material=material, picture=picture)
    with pytest.raises(DataError, match=message):
        read_obj(path)


def test_a_mesh_without_uv_and_colours_is_refused(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    with pytest.raises(DataError, match="neither vt lines nor colours"):
        read_obj(write(tmp_path, text, material=None, picture=None))


def test_large_random_files_agree_with_an_independent_reader(tmp_path):
    random = np.random.default_rng(7)
    vertices, uv = random.normal(size=(300, 3)).round(5), random.random((400, 2)).round(5)
    corner = np.stack([random.integers(1, 301, (500, 3)), random.integers(1, 401, (500, 3))], -1)
    lines = ["mtllib mesh.mtl"]
    lines += [f"v {x} {y} {z}" for x, y, z in vertices] + [f"vt {s} {t}" for s, t in uv]
    lines += ["usemtl m", *("f " + " ".join(f"{v}/{t}" for v, t in face) for face in corner)]
    path = write(tmp_path, "\n".join(lines))
    mesh = read_obj(path)
    other = trimesh.load(path, process=False)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], other.vertices[other.faces], atol=1e-9)
    np.testing.assert_allclose(mesh.wedge_uv, other.visual.uv[other.faces], atol=1e-9)
