"""Whatever is broken in a file, only our own one-line errors come out, and soon.

Small valid files of every format are mutated in a fixed way: cut short, bytes and bits
flipped, tokens swapped or replaced by extreme numbers, stretches deleted or repeated.
"""

import base64
import io
import json
import re
import struct
import time

import cv2
import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import ShapemorphError
from shapemorph.io.images import read_grey_image
from shapemorph.io.landmarks import read_landmarks
from shapemorph.io.meshes import read_mesh

ROUNDS = 80
SLOWEST = 5.0  # seconds of computing for one tiny file; the first cloud loads Open3D
RANDOM = np.random.default_rng(11)
TEXELS = RANDOM.integers(0, 256, (12, 16), dtype=np.uint8)
X, Y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(4.0)))
POINTS = np.stack([X, Y, 0.2 * X * Y], axis=1)
UV = np.stack([X / 4, Y / 3], axis=1)
QUADS = [[k, k + 1, k + 6, k + 5] for k in range(14) if k % 5 < 4]
TRIANGLES = np.array([[q[i] for i in t] for q in QUADS for t in ([0, 1, 2], [0, 2, 3])])
EXTREMES = (
    *(b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-320", b"1e400", b"0x10", b"1.5", b"x", b""),
    *(b"//", b"1/2/3/4", b"[]", b"{}", b"null", b'"a"', b"\xff\xfe", b"999999999999"),
    *(b"4294967295", b"-2147483648", b"2147483647", b"18446744073709551616"),
)


def picture(array, file_format, **options):
    buffer = io.BytesIO()
    Image.fromarray(array).save(buffer, format=file_format, **options)
    return buffer.getvalue()


def obj():
    lines = ["mtllib a.mtl", *(f"v {x} {y} {z}" for x, y, z in POINTS)]
    lines += [*(f"vt {u} {v}" for u, v in UV), "vn 0 0 1", "usemtl m"]
    for k, quad in enumerate(QUADS):
        if k % 2:
            lines.append("f " + " ".join(f"{i + 1}/{i + 1}/1" for i in quad))
        else:
            lines.append("f " + " ".join(f"{i - 20}/{i - 20}" for i in quad[:3]) + " \\")
            lines.append(f"  {quad[3] + 1}/{quad[3] + 1}")
    return "\n".join(lines).encode()


def coloured_obj():
    rgb = RANDOM.random((20, 3))
    lines = [" ".join(f"{n:.6g}" for n in (*p, *c)) for p, c in zip(POINTS, rgb, strict=True)]
    faces = [" ".join(str(i + 1) for i in quad) for quad in QUADS]
    return "\n".join([*(f"v {line}" for line in lines), *(f"f {f}" for f in faces)]).encode()


def text_ply():
    head = "ply\nformat ascii 1.0\nelement vertex 20\nproperty float x\nproperty float y\n"
    head += "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    head += f"element face {len(QUADS) + 1}\nproperty list uchar int vertex_indices\nend_header\n"
    rgb = RANDOM.integers(0, 256, (20, 3))
    rows = [" ".join(f"{n:.6g}" for n in (*p, *c)) for p, c in zip(POINTS, rgb, strict=True)]
    rows += ["4 " + " ".join(str(i) for i in quad) for quad in QUADS] + ["3 0 1 2"]
    return (head + "\n".join(rows)).encode()


def cloud_ply():
    return b"element face 0\n".join(
        part if k == 0 else b"property" + part.split(b"property", 1)[1]
        for k, part in enumerate(re.split(rb"element face \d+\n", text_ply()))
    )


def binary_ply():
    head = "ply\nformat binary_big_endian 1.0\ncomment TextureFile a.png\nelement vertex 20\n"
    head += "property double x\nproperty double y\nproperty double z\n"
    head += f"element face {len(QUADS) + 1}\nproperty list uchar int vertex_indices\n"
    head += "property list uchar float texcoord\nproperty int texnumber\nend_header\n"
    body = POINTS.astype(">f8").tobytes()
    for face in [*QUADS, QUADS[0][:3]]:
        body += struct.pack(f">B{len(face)}i", len(face), *face)
        body += struct.pack(f">B{2 * len(face)}fi", 2 * len(face), *UV[face].ravel(), 0)
    return head.encode() + body


def gltf(*, as_text):
    chunks = [POINTS.astype("<f4").tobytes(), UV.astype("<f4").tobytes()]
    chunks += [TRIANGLES.astype("<u2").tobytes(), picture(TEXELS, "PNG")]
    views, data = [], b""
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)})
        data += chunk + b"\0" * (-len(chunk) % 4)
    shapes = [(5126, 20, "VEC3"), (5126, 20, "VEC2"), (5123, TRIANGLES.size, "SCALAR")]
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "rotation": [0, 0, 0.6, 0.8]}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
                ]
            }
        ],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33648}],
        "images": [{"bufferView": 3}],
        "accessors": [
            {"bufferView": k, "componentType": kind, "count": count, "type": shape}
            for k, (kind, count, shape) in enumerate(shapes)
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    if as_text:
        inline = base64.b64encode(data).decode()
        document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + inline
        return json.dumps(document).encode()
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(data)
    head = b"glTF" + struct.pack("<IIII", 2, total, len(text), 0x4E4F534A)
    return head + text + struct.pack("<II", len(data), 0x004E4942) + data


def table():
    rows = [f"{x};{y};{z:.4g};{60 + 9 * k}" for k, (x, y, z) in enumerate(POINTS)]
    return "\n".join(["x;y;z;grey", *rows]).replace(".", ",").encode()


def deep(suffix):
    levels = RANDOM.integers(0, 65536, (9, 7, 3)).astype(np.uint16)
    return cv2.imencode(suffix, levels)[1].tobytes()


LANDMARKS = b"name,ref_x,ref_y,ref_z,def_x,def_y,def_z\na,1,2,3,4,5,6\nb,1,2,4,4,5,7\n"
MATERIAL = b"newmtl m\nKd 1 1 1\nmap_Kd -o 0 0 0 -s 1 1 1 -clamp off a.png\n"
MESHES = {
    "part.obj": obj(),
    "coloured.obj": coloured_obj(),
    "text.ply": text_ply(),
    "cloud.ply": cloud_ply(),
    "binary.ply": binary_ply(),
    "whole.glb": gltf(as_text=False),
    "text.gltf": gltf(as_text=True),
    "table.csv": table(),
}
PICTURES = {
    "grey.png": picture(TEXELS, "PNG"),
    "photo.jpg": picture(np.stack([TEXELS] * 3, axis=-1), "JPEG"),
    "plain.tif": picture(TEXELS, "TIFF"),
    "packed.tif": picture(TEXELS, "TIFF", compression="tiff_lzw"),
    "float.tif": picture(TEXELS / np.float32(255), "TIFF"),
    "grey.bmp": picture(TEXELS, "BMP"),
    "deep.png": deep(".png"),
    "deep.tif": deep(".tiff"),
}


def mutated(data, random):
    """One or two kinds of damage."""
    for _ in range(random.integers(1, 3)):
        kind = random.integers(0, 7)
        low, high = sorted(int(place) for place in random.integers(0, len(data) + 1, 2))
        if kind == 0:
            data = data[:low]
        elif kind == 1:
            data = data[:low] + data[high:]
        elif kind == 2:
            data = data[:high] + data[low:high] + data[high:]
        elif kind == 3 and data:
            place = min(low, len(data) - 1)
            data = data[:place] + bytes([random.integers(0, 256)]) + data[place + 1 :]
        elif kind == 4 and data:
            place = min(low, len(data) - 1)
            data = (
                data[:place]
                + bytes([data[place] ^ (1 << random.integers(0, 8))])
                + data[place + 1 :]
            )
        elif tokens := [match.span() for match in re.finditer(rb"[-+.\w]+", data)]:
            start, end = tokens[random.integers(0, len(tokens))]
            other = tokens[random.integers(0, len(tokens))]
            extreme = EXTREMES[random.integers(0, len(EXTREMES))]
            data = data[:start] + (extreme if kind == 5 else data[slice(*other)]) + data[end:]
    return data


def survive(path, data, read, seed):
    """Read many mutations; count those that were refused."""
    random = np.random.default_rng(seed)
    read()
    messages = []
    for _ in range(ROUNDS):
        path.write_bytes(mutated(data, random))
        started = time.process_time()
        try:
            read()
        except ShapemorphError as error:
            messages.append(str(error))
        assert time.process_time() - started < SLOWEST
    assert not any("\n" in message for message in messages)
    path.write_bytes(data)
    return len(messages)


def furnish(folder):
    (folder / "a.mtl").write_bytes(MATERIAL)
    (folder / "a.png").write_bytes(picture(TEXELS, "PNG"))


@pytest.mark.parametrize("name", MESHES)
def test_damaged_meshes_give_a_mesh_or_our_error(tmp_path, name):
    furnish(tmp_path)
    path = tmp_path / name
    path.write_bytes(MESHES[name])
    assert survive(path, MESHES[name], lambda: read_mesh(path, unit="mm"), 1) > ROUNDS // 5


def test_damaged_materials_give_a_mesh_or_our_error(tmp_path):
    furnish(tmp_path)
    path = tmp_path / "part.obj"
    path.write_bytes(MESHES["part.obj"])
    survive(tmp_path / "a.mtl", MATERIAL, lambda: read_mesh(path, unit="mm"), 2)


@pytest.mark.parametrize("name", PICTURES)
def test_damaged_pictures_give_a_picture_or_our_error(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(PICTURES[name])
    assert survive(path, PICTURES[name], lambda: read_grey_image(path), 3) > ROUNDS // 5


def test_damaged_landmarks_give_landmarks_or_our_error(tmp_path):
    path = tmp_path / "landmarks.csv"
    path.write_bytes(LANDMARKS)

    def read():
        return read_landmarks(path, reference_scale=1.0, deformed_scale=1.0)

    assert survive(path, LANDMARKS, read, 4) > ROUNDS // 5
