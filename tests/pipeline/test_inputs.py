"""Inputs: fingerprints follow content, units and regions come out in mm."""

import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.config import RegionConfig, RunConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.mesh import textured_mesh
from shapemorph.io.images import write_grey_png
from shapemorph.io.mesh_writers import write_mesh
from shapemorph.pipeline.inputs import Inputs, check_sizes, region_in_mm


def _write_mesh(folder, scale=1.0, seed=0):
    """A square of 6 x 5 vertices with a random texture, 12 mm wide times `scale`."""
    rows, columns = np.mgrid[0:5, 0:6]
    uv = np.stack([columns / 5, rows / 4], axis=-1).reshape(-1, 2)
    vertices = np.column_stack([12.0 * uv[:, 0], 10.0 * uv[:, 1], uv[:, 0] * uv[:, 1]])
    corner = (6 * np.arange(4)[:, None] + np.arange(5)).ravel()
    lower = np.column_stack([corner, corner + 1, corner + 6])
    upper = np.column_stack([corner + 1, corner + 7, corner + 6])
    faces = np.concatenate([lower, upper])
    texture = np.random.default_rng(seed).random((32, 40), dtype="f4")
    face_texture = np.zeros(len(faces), int)
    mesh = textured_mesh(vertices * scale, faces, uv[faces], face_texture, (texture,), name="m")
    folder.mkdir(parents=True, exist_ok=True)
    write_mesh(folder / "mesh.obj", mesh)
    return folder / "mesh.obj"


def _paint(mesh, *, seed, amplitudes):
    """Give a mesh a texture of which each channel shows as much as `amplitudes` says."""
    from PIL import Image

    from shapemorph.methods.synthetic.planar import planar_speckle

    rows, columns = np.mgrid[:160, :200].astype(float)
    speckle = planar_speckle(diameter=7.0, seed=seed).at(np.stack([columns, rows], -1))
    levels = 128 + speckle[..., None] * np.array(amplitudes)
    picture = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
    Image.fromarray(picture).save(mesh.with_suffix(".png"))
    return picture


def _inputs(reference, deformed, **more):
    document = {"inputs": {"reference": str(reference), "deformed": str(deformed), **more}}
    return Inputs(RunConfig.model_validate(document))


@pytest.fixture
def pair(tmp_path):
    return _write_mesh(tmp_path / "a"), _write_mesh(tmp_path / "b", seed=1)


def test_a_fingerprint_is_of_content_wherever_it_lies(pair, tmp_path):
    shutil.copytree(pair[0].parent, tmp_path / "copy")
    moved = _inputs(tmp_path / "copy" / "mesh.obj", pair[1])
    assert moved.fingerprint("reference") == _inputs(*pair).fingerprint("reference")
    assert moved.fingerprint("reference") != moved.fingerprint("deformed")


@pytest.mark.parametrize("suffix", [".png", ".mtl", ".obj"])
def test_every_file_of_a_mesh_counts(pair, suffix):
    before = _inputs(*pair)
    marks = before.fingerprint("reference"), before.fingerprint("reports")
    file = pair[0].with_suffix(suffix)
    file.write_bytes(file.read_bytes() + b"\n#\n")
    after = _inputs(*pair)
    assert after.fingerprint("reference") != marks[0]
    assert after.fingerprint("reports") != marks[1]
    assert after.fingerprint("deformed") == before.fingerprint("deformed")


def test_a_picture_that_nobody_names_does_not_count(pair):
    before = _inputs(*pair).fingerprint("reference")
    (pair[0].parent / "holiday.png").write_bytes(b"")
    assert _inputs(*pair).fingerprint("reference") == before


def test_the_unit_counts_and_its_override_only_for_its_side(pair):
    plain, other = _inputs(*pair), _inputs(*pair, deformed_units="cm")
    assert plain.fingerprint("reference") == other.fingerprint("reference")
    assert plain.fingerprint("deformed") != other.fingerprint("deformed")


def test_lengths_come_out_in_mm_for_any_unit(pair):
    assert_allclose(_inputs(*pair, units="cm").load("reference").size, 10 * 15.65248, rtol=1e-5)


def test_sizes_in_different_units_name_the_keys(tmp_path):
    pair = _write_mesh(tmp_path / "a"), _write_mesh(tmp_path / "b", scale=0.1)
    with pytest.raises(ConfigError, match=r"as between mm and cm.*inputs\.reference_units"):
        _inputs(*pair).load("reports")
    reports = _inputs(*pair, deformed_units="cm").load("reports")
    assert_allclose(reports.reference_size, reports.deformed_size, rtol=1e-5)


@pytest.mark.parametrize(
    ("ratio", "hint"),
    [(9.0, "mm and cm"), (24.0, "mm and in"), (0.01, "cm and m"), (1200.0, "mm and m")],
)
def test_the_nearest_pair_of_units_is_suggested(ratio, hint):
    with pytest.raises(ConfigError, match=f"as between {hint}\\)"):
        check_sizes(10.0, 10.0 * ratio)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 4.5])
def test_a_balloon_may_grow(ratio):
    check_sizes(70.0, 70.0 * ratio)


def test_what_is_not_given_is_none_and_missing_files_are_data_errors(pair, tmp_path):
    inputs = _inputs(*pair)
    assert inputs.load("landmarks") is None
    assert inputs.load("region") is None
    with pytest.raises(DataError, match=r"absent\.csv does not exist"):
        _inputs(*pair, landmarks=str(tmp_path / "absent.csv")).files()
    with pytest.raises(ConfigError, match=r"inputs\.deformed is empty"):
        Inputs(RunConfig.model_validate({"inputs": {"reference": str(pair[0])}})).files()


def test_a_region_is_in_mm_and_its_mask_is_white_where_measured(tmp_path):
    grey = np.zeros((4, 7), "f4")
    grey[1, 5] = 1.0
    write_grey_png(tmp_path / "m.png", grey, np.ones((4, 7), bool))
    config = RegionConfig(
        polygon=[(0, 0), (3, 0), (3, 2)], mask=tmp_path / "m.png", centre=(1, 2, 3), radius=0.5
    )
    region = region_in_mm(config, 25.4)
    assert_allclose(region.centre, [25.4, 50.8, 76.2])
    assert region.radius == pytest.approx(12.7)
    assert [polygon.shape for polygon in region.polygons] == [(3, 2)]
    assert np.argwhere(region.mask).tolist() == [[1, 5]]


def test_the_content_of_a_mask_counts_not_its_place(pair, tmp_path):
    def mark(name, level):
        grey = np.full((4, 4), level, "f4")
        write_grey_png(tmp_path / name, grey, np.ones((4, 4), bool))
        return _inputs(*pair, region={"mask": str(tmp_path / name)}).fingerprint("region")

    assert mark("a.png", 0.9) == mark("b.png", 0.9)
    assert mark("a.png", 0.9) != mark("c.png", 0.1)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ("a,0,0,0,0,0,0\nb,1,0,0,1,0,0\nc,2,0,0,2,0,0\n", "not on one line"),
        ("a,0,0,0,0,0,0\nb,1,0,0,-1,0,0\nc,0,1,0,0,1,0\nd,0,0,1,0,0,1\n", "mirrored"),
        ("a,0,0,0,0,0\n", "landmarks.csv"),
    ],
)
def test_landmarks_that_carry_nothing_are_refused_before_anything_is_measured(
    pair, tmp_path, rows, says
):
    path = tmp_path / "landmarks.csv"
    path.write_text("name,ref_x,ref_y,ref_z,def_x,def_y,def_z\n" + rows)
    with pytest.raises(DataError, match=says):
        _inputs(*pair, landmarks=str(path)).check_beside_meshes()


@pytest.mark.parametrize(("method", "refused"), [("auto", True), ("points", False)])
def test_landmarks_along_a_diameter_may_serve_a_law_alone(pair, tmp_path, method, refused):
    path = tmp_path / "landmarks.csv"
    rows = "".join(f"m{n},{n},0,0,{2 * n},0,0\n" for n in range(5))
    path.write_text("name,ref_x,ref_y,ref_z,def_x,def_y,def_z\n" + rows)
    document = {
        "inputs": {"reference": pair[0], "deformed": pair[1], "landmarks": path},
        "align": {"method": method},
        "morph": {"law": "landmarks"},
    }
    inputs = Inputs(RunConfig.model_validate(document))
    if refused:
        with pytest.raises(DataError, match=r"on one line.*or set align\.method=points"):
            inputs.check_beside_meshes()
    else:
        inputs.check_beside_meshes()


@pytest.mark.parametrize("method", ["landmarks", "landmarks+icp"])
def test_a_method_that_needs_landmarks_is_refused_without_before_anything_is_measured(pair, method):
    document = {
        "inputs": {"reference": str(pair[0]), "deformed": str(pair[1])},
        "align": {"method": method},
    }
    with pytest.raises(ConfigError, match=r"needs landmarks, got none: set inputs\.landmarks"):
        Inputs(RunConfig.model_validate(document)).check_beside_meshes()


def test_a_mask_that_is_no_picture_is_refused_before_anything_is_measured(pair, tmp_path):
    (tmp_path / "mask.png").write_text("white")
    with pytest.raises(DataError, match=r"mask\.png"):
        _inputs(*pair, region={"mask": str(tmp_path / "mask.png")}).check_beside_meshes()


def test_both_sides_use_the_channel_that_shows_the_pattern(pair):
    pictures = [_paint(p, seed=k, amplitudes=(30, -8.5, 3)) for k, p in enumerate(pair)]
    inputs = _inputs(*pair)
    reports = inputs.load("reports")
    assert reports.channel == reports.reference.channel == reports.deformed.channel == "red"
    assert "gradient" in reports.channel_reason
    for name, picture in zip(("reference", "deformed"), pictures, strict=True):
        assert_allclose(inputs.load(name).textures[0], picture[..., 0] / 255, atol=1e-6)


def test_one_channel_serves_both_sides_and_can_be_given(pair):
    _paint(pair[0], seed=0, amplitudes=(60, 15, 15))
    picture = _paint(pair[1], seed=1, amplitudes=(2, 20, 20))
    assert _inputs(*pair).load("reports").channel == "luma"
    given = _inputs(*pair, channel="blue")
    assert given.load("reports").deformed.channel == "blue"
    assert given.load("reports").channel_reason == "as inputs.channel says"
    assert_allclose(given.load("deformed").textures[0], picture[..., 2] / 255, atol=1e-6)
    assert given.fingerprint("deformed") != _inputs(*pair).fingerprint("deformed")


def test_pattern_that_luma_does_not_show_is_no_blank(pair):
    """Red on green of equal luma."""
    for k, mesh in enumerate(pair):
        _paint(mesh, seed=k, amplitudes=(30, -30 * 0.2126 / 0.7152, 0))
    assert _inputs(*pair).load("reports").channel == "red"
