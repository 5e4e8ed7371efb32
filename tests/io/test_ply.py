"""PLY files in every encoding, with colours or a texture, as mesh or as cloud."""

import struct

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.io.ply import read_ply

VERTICES = np.array([[0, 0, 0], [2, 0, 0.5], [2, 1, 0.25], [0, 1, 0], [1, 2, 0.75]])
POLYGONS = [[0, 1, 2, 3], [3, 2, 4]]
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4]])
UV = np.array([[0.1, 0.2], [0.9, 0.2], [0.9, 0.6], [0.1, 0.6], [0.5, 0.9]])
RGB = np.array([[10, 20, 30], [250, 0, 0], [0, 250, 0], [0, 0, 250], [255, 255, 255]])
GREY = RGB @ [0.2126, 0.7152, 0.0722] / 255.0
ENCODINGS = ["ascii", "binary_little_endian", "binary_big_endian"]
CODES = {"uchar": "B", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}


def ply(encoding, vertex, face=(), comments=(), polygons=POLYGONS):
    """A PLY file from columns {name: (type, values)} and face lists {name: (type, rows)}."""
    head = ["ply", f"format {encoding} 1.0", *(f"comment {c}" for c in comments)]
    count = len(next(iter(vertex.values()))[1])
    head += [f"element vertex {count}", *(f"property {t} {n}" for n, (t, _) in vertex.items())]
    lists = {"vertex_indices": ("int", polygons), **dict(face)} if polygons else {}
    if polygons:
        head.append(f"element face {len(polygons)}")
    for name, (kind, rows) in lists.items():
        listed = np.ndim(rows[0]) > 0
        head.append(f"property {'list uchar ' if listed else ''}{kind} {name}")
    rows = [[(t, v[k]) for t, v in vertex.values()] for k in range(count)]
    for k in range(len(polygons or [])):
        row = []
        for kind, values in lists.values():
            items = np.atleast_1d(values[k])
            row += [("uchar", len(items))] if np.ndim(values[k]) else []
            row += [(kind, item) for item in items]
        rows.append(row)
    return ("\n".join([*head, "end_header"]) + "\n").encode() + b"".join(
        encode(encoding, row) for row in rows
    )


def encode(encoding, row):
    if encoding == "ascii":
        return (" ".join(f"{value:.9g}" for _, value in row) + "\n").encode()
    order = "<" if "little" in encoding else ">"
    return b"".join(
        struct.pack(order + CODES[t], v if t in ("float", "double") else int(v)) for t, v in row
    )


def positions(kind="double"):
    return {name: (kind, VERTICES[:, k]) for k, name in enumerate("xyz")}


def colours(kind="uchar", scale=1.0, names=("red", "green", "blue")):
    return {name: (kind, RGB[:, k] * scale) for k, name in enumerate(names)}


def write(folder, data, picture=None):
    path = folder / "mesh.ply"
    path.write_bytes(data)
    if picture:
        Image.fromarray(np.arange(600, dtype=np.uint8).reshape(20, 30)).save(folder / picture)
    return path


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(("kind", "scale"), [("uchar", 1.0), ("float", 1 / 255), ("ushort", 257)])
def test_vertex_colours_become_grey_in_every_encoding(tmp_path, encoding, kind, scale):
    data = ply(encoding, {**positions(), **colours(kind, scale)})
    mesh = read_ply(write(tmp_path, data))
    np.testing.assert_allclose(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, TRIANGLES)
    np.testing.assert_allclose(mesh.corner_grey, GREY[TRIANGLES], atol=1e-6)
    assert mesh.polygons_split == 1


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_texture_coordinates_on_faces_stay_with_their_corners(tmp_path, encoding):
    wedges = [UV[polygon].ravel() + 0.01 * k for k, polygon in enumerate(POLYGONS)]
    face = {"texcoord": ("float", wedges), "texnumber": ("int", [1, 0])}
    comments = ("TextureFile  first skin.png", "TextureFile second.png")
    Image.fromarray(np.zeros((5, 9), dtype=np.uint8)).save(tmp_path / "second.png")
    data = ply(encoding, {**positions("float"), **colours()}, face, comments)
    mesh = read_ply(write(tmp_path, data, "first skin.png"))
    np.testing.assert_allclose(mesh.wedge_uv[:2], UV[TRIANGLES[:2]], atol=1e-7)
    np.testing.assert_allclose(mesh.wedge_uv[2], UV[TRIANGLES[2]] + 0.01, atol=1e-7)
    np.testing.assert_array_equal(mesh.face_texture, [1, 1, 0])
    assert [texture.shape for texture in mesh.textures] == [(20, 30), (5, 9)]


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_texture_coordinates_on_vertices_are_read(tmp_path, names):
    uv = {name: ("float", UV[:, k]) for k, name in enumerate(names)}
    data = ply("binary_little_endian", {**positions(), **uv}, comments=["TextureFile skin.png"])
    mesh = read_ply(write(tmp_path, data, "skin.png"))
    np.testing.assert_allclose(mesh.wedge_uv, UV[TRIANGLES], atol=1e-7)


def test_faces_with_an_incomplete_list_of_uv_are_marked(tmp_path):
    face = {"texcoord": ("float", [UV[POLYGONS[0]].ravel(), []])}
    data = ply("binary_little_endian", positions(), face, ["TextureFile skin.png"])
    mesh = read_ply(write(tmp_path, data, "skin.png"))
    np.testing.assert_array_equal(np.isnan(mesh.wedge_uv).any(axis=(1, 2)), [False, False, True])


@pytest.mark.parametrize("name", ["intensity", "quality", "grey", "gray"])
def test_a_single_scalar_is_grey_and_said(tmp_path, name):
    data = ply("ascii", {**positions(), name: ("float", GREY * 255)})
    mesh = read_ply(write(tmp_path, data))
    np.testing.assert_allclose(mesh.corner_grey, GREY[TRIANGLES], atol=1e-6)
    assert mesh.notes == (f"grey is the vertex property {name}",)


def test_a_uniform_colour_gives_way_to_a_scalar_with_a_pattern(tmp_path):
    white = {name: ("uchar", np.full(5, 255)) for name in ("red", "green", "blue")}
    data = ply("ascii", {**positions(), **white, "quality": ("float", GREY)})
    np.testing.assert_allclose(
        read_ply(write(tmp_path, data)).corner_grey, GREY[TRIANGLES], atol=1e-6
    )


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_first_row_shorter_than_the_others_does_not_set_the_pace(tmp_path, encoding):
    data = ply(encoding, {**positions(), **colours()}, polygons=POLYGONS[::-1])
    mesh = read_ply(write(tmp_path, data))
    np.testing.assert_array_equal(mesh.faces, [[3, 2, 4], [0, 1, 2], [0, 2, 3]])


def test_lists_of_many_lengths_are_followed_row_by_row(tmp_path):
    random = np.random.default_rng(8)
    polygons = [random.integers(0, 5, random.integers(0, 7)) for _ in range(200)]
    flags = {"flags": ("uchar", list(range(200)))}
    data = ply("binary_big_endian", {**positions(), **colours()}, flags, polygons=polygons)
    mesh = read_ply(write(tmp_path, data))
    assert len(mesh.faces) == sum(max(0, len(polygon) - 2) for polygon in polygons)


def test_a_cloud_is_meshed_and_says_how(tmp_path):
    x, y = np.meshgrid(np.arange(8.0), np.arange(6.0))
    places = {"x": x.ravel(), "y": y.ravel(), "z": 0.1 * (x * y).ravel()}
    vertex = {name: ("float", values) for name, values in places.items()}
    vertex["intensity"] = ("uchar", np.arange(48) * 5)
    mesh = read_ply(write(tmp_path, ply("binary_little_endian", vertex, polygons=[])))
    assert mesh.grey_source == "point cloud"
    assert "Delaunay" in mesh.method
    assert len(mesh.faces) == 2 * 7 * 5
    np.testing.assert_allclose(mesh.corner_grey, (mesh.faces * 5) / 255.0)


def damaged(change):
    return change(ply("binary_little_endian", {**positions(), **colours()}))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"plywood", "expected a PLY file"),
        (damaged(lambda d: d[:-3]), "element face.* truncated"),
        (damaged(lambda d: d[:-60]), "element vertex.* truncated"),
        (damaged(lambda d: d.replace(b"vertex 5", b"vertex 999999999999")), "truncated"),
        (damaged(lambda d: d.replace(b"vertex 5", b"vertex -5")), "line 3: expected a statement"),
        (damaged(lambda d: d.replace(b"property double x", b"property real x")), "line 4"),
        (damaged(lambda d: d.replace(b"double z", b"double w")), "expected vertices with x, y"),
        (damaged(lambda d: d.replace(b"little", b"middle")), "expected format"),
        (ply("ascii", {**positions(), **colours()}).replace(b"250", b"2b0"), "got '2b0'"),
        (
            ply("ascii", {**positions(), **colours()}, polygons=[[0, 1, 5]]),
            "vertices 0 to 4, got 5",
        ),
        (ply("ascii", {**positions(), **colours()}, polygons=[[0, 1, -1]]), "got -1"),
        (ply("ascii", positions()), "expected vertex colours or texture"),
        (ply("ascii", positions(), polygons=[]), "bare points"),
        (ply("ascii", {**positions(), "grey": ("float", GREY - 9)}), "negative"),
        (ply("ascii", {**positions(), "grey": ("float", GREY * 1e9)}), "0 to 1, 255 or 65535"),
    ],
)
def test_damaged_files_are_refused_with_a_reason(tmp_path, data, message):
    with pytest.raises(DataError, match=message):
        read_ply(write(tmp_path, data))


def test_a_texture_that_is_not_there_is_refused(tmp_path):
    uv = {name: ("float", UV[:, k]) for k, name in enumerate("st")}
    data = ply("ascii", {**positions(), **uv}, comments=["TextureFile gone.png"])
    with pytest.raises(DataError, match=r"gone\.png"):
        read_ply(write(tmp_path, data))
