"""Which files a mesh consists of."""

import json

import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.mesh_sources import mesh_sources


def _names(path):
    return [source.name for source in mesh_sources(path)]


def test_an_obj_names_its_libraries_and_they_their_pictures(tmp_path):
    (tmp_path / "maps").mkdir()
    for name in ("front view.png", "maps/back.jpg", "unrelated.png"):
        (tmp_path / name).touch()
    (tmp_path / "two parts.mtl").write_text(
        "newmtl a\nmap_Kd -s 1 1 1 front view.png\nnewmtl b\nmap_Kd maps\\back.jpg\n"
    )
    mesh = tmp_path / "face.obj"
    mesh.write_bytes(b"v 0 0 0\r\nmtllib two parts.mtl\r\nf 1 1 1\r\n")
    assert _names(mesh) == ["face.obj", "two parts.mtl", "front view.png", "back.jpg"]


def test_a_library_is_named_at_the_begin_of_a_line_only(tmp_path):
    for name in ("a.mtl", "b.mtl", "c.mtl"):
        (tmp_path / name).touch()
    mesh = tmp_path / "face.obj"
    mesh.write_bytes(b"# mtllib a.mtl\rv 0 0 0\r \tmtllib b.mtl\ng mtllib c.mtl\n")
    assert _names(mesh) == ["face.obj", "b.mtl"]


def test_without_a_library_the_obvious_picture_counts(tmp_path):
    (tmp_path / "face.png").touch()
    (tmp_path / "other.png").touch()
    mesh = tmp_path / "face.obj"
    mesh.write_text("v 0 0 0\n")
    assert _names(mesh) == ["face.obj", "face.png"]


def test_what_is_named_but_missing_is_left_to_the_reader(tmp_path):
    mesh = tmp_path / "face.obj"
    mesh.write_text("mtllib absent.mtl\n")
    assert _names(mesh) == ["face.obj"]


def test_a_ply_names_its_picture_in_a_comment(tmp_path):
    (tmp_path / "skin.png").touch()
    mesh = tmp_path / "face.ply"
    mesh.write_bytes(b"ply\nformat ascii 1.0\ncomment TextureFile skin.png\nend_header\n")
    assert _names(mesh) == ["face.ply", "skin.png"]


def test_a_gltf_names_buffers_and_images(tmp_path):
    (tmp_path / "a b.bin").touch()
    (tmp_path / "skin.png").touch()
    mesh = tmp_path / "face.gltf"
    images = [{"uri": "skin.png"}, {"uri": "data:image/png;base64,AAAA"}, {"bufferView": 0}]
    mesh.write_text(json.dumps({"buffers": [{"uri": "a%20b.bin"}], "images": images}))
    assert _names(mesh) == ["face.gltf", "a b.bin", "skin.png"]


@pytest.mark.parametrize("kind", ["missing", "directory"])
def test_no_mesh_file_is_a_data_error(tmp_path, kind):
    path = tmp_path if kind == "directory" else tmp_path / "absent.obj"
    with pytest.raises(DataError, match=r"is a directory|does not exist"):
        mesh_sources(path)
