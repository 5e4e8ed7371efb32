"""glTF and GLB files: transforms, primitives, textures, colours, and what is refused."""

import base64
import copy
import io
import json
import struct

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.io.gltf import read_gltf

VERTICES = np.array([[0, 0, 0], [2, 0, 0.5], [2, 1, 0.25], [0, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
UV = np.array([[0.1, 0.2], [0.9, 0.3], [0.8, 0.6], [0.1, 0.7]])
COLOURS = np.array([[10, 20, 30], [250, 0, 0], [0, 250, 0], [255, 255, 255]], dtype=np.uint8)
PATTERN = np.random.default_rng(0).integers(0, 256, (24, 40), dtype=np.uint8)


def png():
    buffer = io.BytesIO()
    Image.fromarray(PATTERN).save(buffer, "PNG")
    return buffer.getvalue()


class Scene:
    """A glTF document under construction."""

    def __init__(self):
        self.data = b""
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
        }

    def view(self, data, **extra):
        self.data += b"\0" * (-len(self.data) % 4)
        entry = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **extra}
        self.json["bufferViews"].append(entry)
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, kind, shape, **extra):
        view = self.view(np.ascontiguousarray(values).tobytes())
        entry = {"bufferView": view, "componentType": kind, "count": len(values), "type": shape}
        self.json["accessors"].append({**entry, **extra})
        return len(self.json["accessors"]) - 1

    def positions(self, values=VERTICES):
        return self.accessor(values.astype("<f4"), 5126, "VEC3")

    def indices(self, values=TRIANGLES):
        return self.accessor(values.ravel().astype("<u2"), 5123, "SCALAR")

    def uv(self, values=UV):
        return self.accessor(values.astype("<f4"), 5126, "VEC2")

    def picture(self, **texture_info):
        self.json["images"] = [{"bufferView": self.view(png()), "mimeType": "image/png"}]
        self.json["textures"] = [{"source": 0}]
        info = {"index": 0, **texture_info}
        self.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": info}}]

    def primitive(self, **entry):
        self.json["meshes"][0]["primitives"].append(entry)

    def write_glb(self, path):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        body = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(body), 0x004E4942) + body
        path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        return path


def textured_scene(**texture_info):
    scene = Scene()
    attributes = {"POSITION": scene.positions(), "TEXCOORD_0": scene.uv()}
    scene.primitive(attributes=attributes, indices=scene.indices(), material=0)
    scene.picture(**texture_info)
    return scene


def flipped(uv):
    return np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)


def test_embedded_picture_and_uv_with_their_origin_at_the_lower_left(tmp_path):
    mesh = read_gltf(textured_scene().write_glb(tmp_path / "a.glb"))
    np.testing.assert_allclose(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, TRIANGLES)
    np.testing.assert_allclose(mesh.wedge_uv, flipped(UV)[TRIANGLES], atol=1e-7)
    np.testing.assert_allclose(mesh.textures[0], PATTERN / 255.0, atol=1e-7)
    assert mesh.file_format == "GLB"


def test_buffers_and_pictures_in_files_of_their_own_or_in_the_text_are_the_same(tmp_path):
    scene = textured_scene()
    document = copy.deepcopy(scene.json)
    (tmp_path / "my data.bin").write_bytes(scene.data)
    (tmp_path / "my skin.png").write_bytes(png())
    document["buffers"] = [{"byteLength": len(scene.data), "uri": "my%20data.bin"}]
    document["images"] = [{"uri": "my%20skin.png"}]
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    beside = read_gltf(tmp_path / "a.gltf")
    uri = "data:application/octet-stream;base64,"
    document["buffers"][0]["uri"] = uri + base64.b64encode(scene.data).decode()
    document["images"][0]["uri"] = "data:image/png;base64," + base64.b64encode(png()).decode()
    (tmp_path / "b.gltf").write_text(json.dumps(document))
    inside = read_gltf(tmp_path / "b.gltf")
    for mesh in (beside, inside):
        np.testing.assert_allclose(mesh.wedge_uv, flipped(UV)[TRIANGLES], atol=1e-7)
        np.testing.assert_allclose(mesh.textures[0], PATTERN / 255.0, atol=1e-7)
        assert mesh.file_format == "glTF"


def test_transforms_of_nested_nodes_are_applied_from_the_leaf_up(tmp_path):
    scene = textured_scene()
    quarter = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]  # +90 degrees about z
    scene.json["nodes"] = [
        {"children": [1], "translation": [10, 20, 30]},
        {"children": [2], "rotation": quarter, "scale": [2, 3, 4]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]},
    ]
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    local = np.add(VERTICES, [1, 0, 0]) * [2, 3, 4]
    turned = np.stack([-local[:, 1], local[:, 0], local[:, 2]], axis=1)
    expected = np.add(turned, [10, 20, 30])
    np.testing.assert_allclose(mesh.vertices, expected, atol=1e-6)


def test_a_mirroring_node_turns_faces_so_that_they_still_look_outwards(tmp_path):
    scene = textured_scene()
    scene.json["nodes"][0]["scale"] = [1, 1, -1]
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(mesh.faces, TRIANGLES[:, ::-1])
    np.testing.assert_allclose(mesh.wedge_uv, flipped(UV)[TRIANGLES[:, ::-1]], atol=1e-7)


def test_primitives_and_instances_are_joined_with_their_textures(tmp_path):
    scene = textured_scene()
    scene.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}]
    scene.json["scenes"] = [{"nodes": [0, 1]}]
    scene.json["textures"] += [{"source": 0}, {"source": 0}]
    other = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}}
    scene.json["materials"] += [other, {"pbrMetallicRoughness": {}}]
    attributes = scene.json["meshes"][0]["primitives"][0]["attributes"]
    scene.primitive(attributes=attributes, material=1, mode=5)
    scene.primitive(attributes=attributes, material=2, mode=6)
    scene.primitive(attributes=attributes, mode=1)
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(mesh.face_texture, [0, 0, 1, 1, -1, -1] * 2)
    np.testing.assert_array_equal(mesh.faces[2:6] % 4, [[0, 1, 2], [2, 1, 3], [0, 1, 2], [0, 2, 3]])
    np.testing.assert_allclose(mesh.vertices[12:16], np.add(VERTICES, [5, 0, 0]), atol=1e-6)


def test_texture_transform_scales_turns_and_moves(tmp_path):
    # The example of the extension's own page: the lower left quadrant of the picture.
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    scene = textured_scene(extensions={"KHR_texture_transform": transform})
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    moved = np.stack([0.5 * UV[:, 1], 1 - 0.5 * UV[:, 0]], axis=1)
    np.testing.assert_allclose(mesh.wedge_uv, flipped(moved)[TRIANGLES], atol=1e-7)


def test_texture_transform_chooses_another_set_of_coordinates(tmp_path):
    scene = textured_scene(extensions={"KHR_texture_transform": {"texCoord": 1}})
    scene.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = scene.uv(UV[::-1])
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    np.testing.assert_allclose(mesh.wedge_uv, flipped(UV[::-1])[TRIANGLES], atol=1e-7)


def test_normalised_short_coordinates_and_interleaved_data_are_read(tmp_path):
    scene = Scene()
    row = np.dtype([("place", "<f4", 3), ("uv", "<u2", 2), ("rest", "u1", 4)])
    rows = np.zeros(4, dtype=row)
    rows["place"], rows["uv"] = VERTICES, np.round(UV * 65535)
    view = scene.view(rows.tobytes(), byteStride=row.itemsize)
    common = {"bufferView": view, "count": 4}
    scene.json["accessors"] = [
        {**common, "componentType": 5126, "type": "VEC3"},
        {**common, "componentType": 5123, "type": "VEC2", "normalized": True, "byteOffset": 12},
    ]
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    scene.primitive(attributes=attributes, indices=scene.indices(), material=0)
    scene.picture()
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    np.testing.assert_allclose(mesh.vertices, VERTICES)
    np.testing.assert_allclose(mesh.wedge_uv, flipped(UV)[TRIANGLES], atol=1e-5)


def test_sparse_accessors_replace_what_they_list(tmp_path):
    scene = textured_scene()
    rows = scene.view(np.array([2], dtype="<u2").tobytes())
    values = scene.view(np.array([[7, 8, 9]], dtype="<f4").tobytes())
    scene.json["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": rows, "componentType": 5123},
        "values": {"bufferView": values},
    }
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    np.testing.assert_allclose(mesh.vertices[[1, 2]], [VERTICES[1], [7, 8, 9]])


@pytest.mark.parametrize("stored", ["bytes", "floats"])
def test_linear_vertex_colours_are_encoded_before_they_become_grey(tmp_path, stored):
    scene = Scene()
    if stored == "bytes":
        colour = scene.accessor(COLOURS, 5121, "VEC3", normalized=True)
    else:
        rgba = np.concatenate([COLOURS / 255, np.ones((4, 1))], axis=1).astype("<f4")
        colour = scene.accessor(rgba, 5126, "VEC4")
    attributes = {"POSITION": scene.positions(), "COLOR_0": colour}
    scene.primitive(attributes=attributes, indices=scene.indices())
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    linear = COLOURS / 255
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    expected = curved @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(mesh.corner_grey, expected[TRIANGLES], atol=1e-6)
    assert mesh.grey_source == "vertex colours"


def test_coloured_points_without_faces_are_a_cloud(tmp_path):
    scene = Scene()
    x, y = np.meshgrid(np.arange(7.0), np.arange(5.0))
    points = np.stack([x, y, 0.1 * x * y], axis=-1).reshape(-1, 3)
    grey = np.repeat(np.arange(35)[:, None] * 7, 3, axis=1).astype(np.uint8)
    colour = scene.accessor(grey, 5121, "VEC3", normalized=True)
    scene.primitive(attributes={"POSITION": scene.positions(points), "COLOR_0": colour}, mode=0)
    mesh = read_gltf(scene.write_glb(tmp_path / "a.glb"))
    assert mesh.grey_source == "point cloud"
    assert len(mesh.faces) == 2 * 6 * 4


@pytest.mark.parametrize(
    ("extension", "message"),
    [
        ("KHR_draco_mesh_compression", "Draco compression .* export it without"),
        ("EXT_meshopt_compression", "meshopt compression .* export it without"),
        ("VENDOR_voxels", "requires VENDOR_voxels"),
    ],
)
def test_compressed_and_unknown_geometry_is_refused_with_a_way_out(tmp_path, extension, message):
    scene = textured_scene()
    scene.json["extensionsRequired"] = [extension]
    with pytest.raises(DataError, match=message):
        read_gltf(scene.write_glb(tmp_path / "a.glb"))


def test_a_draco_primitive_is_refused_even_where_it_is_not_required(tmp_path):
    scene = textured_scene()
    scene.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}
    with pytest.raises(DataError, match="Draco"):
        read_gltf(scene.write_glb(tmp_path / "a.glb"))


def test_pictures_in_formats_of_the_graphics_card_are_refused(tmp_path):
    scene = textured_scene()
    scene.json["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    with pytest.raises(DataError, match=r"PNG or JPEG texture.*KHR_texture_basisu"):
        read_gltf(scene.write_glb(tmp_path / "a.glb"))


def broken(path, value):
    """A scene with one entry replaced."""
    scene = textured_scene()
    entry = scene.json
    for key in path[:-1]:
        entry = entry[key]
    entry[path[-1]] = value
    return scene


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (broken(["accessors", 0, "count"], 10**9), "expected 1000000000 elements"),
        (broken(["accessors", 0, "bufferView"], 99), "contradicts itself"),
        (broken(["accessors", 0, "componentType"], 1), "contradicts itself"),
        (broken(["bufferViews", 0, "byteLength"], 10**12), "truncated"),
        (broken(["bufferViews", 0, "byteOffset"], -8), "truncated"),
        (broken(["nodes", 0, "children"], [0]), "node 0 twice"),
        (broken(["nodes", 0, "matrix"], [1, 2]), "contradicts itself"),
        (broken(["nodes", 0, "translation"], [1e300, 0, 0]), "finite positions"),
        (broken(["meshes"], None), "contradicts itself"),
        (broken(["meshes", 0, "primitives"], []), "expected a mesh in the scene, got none"),
        (broken(["materials"], []), "contradicts itself"),
        (broken(["materials", 0], {}), "neither"),
        (broken(["asset"], {}), None),
    ],
)
def test_contradictions_are_refused(tmp_path, scene, message):
    path = scene.write_glb(tmp_path / "a.glb")
    if message is None:
        assert len(read_gltf(path).faces) == 2
        return
    with pytest.raises(DataError, match=message):
        read_gltf(path)


def test_indices_beyond_the_vertices_are_refused(tmp_path):
    scene = textured_scene()
    primitive = scene.json["meshes"][0]["primitives"][0]
    primitive["indices"] = scene.indices(TRIANGLES + 3)
    with pytest.raises(DataError, match="vertices 0 to 3, got 6"):
        read_gltf(scene.write_glb(tmp_path / "a.glb"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d[:-40], "truncated"),
        (lambda d: d[:10], "truncated"),
        (lambda d: d[:4] + struct.pack("<I", 1) + d[8:], "version 2, got 1"),
        (lambda d: d[:20] + b"[" + d[21:], "damaged text"),
        (lambda _: b"[1, 2]", "glTF object"),
        (lambda _: b"[" * 100_000, "damaged text"),
    ],
)
def test_damaged_containers_are_refused(tmp_path, change, message):
    path = textured_scene().write_glb(tmp_path / "a.glb")
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(DataError, match=message):
        read_gltf(path)
