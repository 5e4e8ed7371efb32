"""A synthetic stereo experiment: pictures that agree with their truth, written whole."""

import numpy as np
import pytest

from shapemorph.config import TwinConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.images import read_grey_image, read_white
from shapemorph.io.twin_files import read_twin
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.pipeline.twin import write_twin_case
from shapemorph.stages.twin import make_twin, region_of_first

SMALL = TwinConfig(law="analytic", scale=0.12, steps=1, rings=12, views=1, samples=1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("twin")
    write_twin_case(SMALL, place, listener=lambda _: None)
    return place


def test_pictures_show_both_states_to_both_cameras(folder):
    names = {path.name for path in folder.glob("*.png")}
    assert names == {"mask_left.png"} | {
        f"{side}_{state:02d}.png" for side in ("left", "right") for state in range(2)
    }
    assert {path.name for path in (folder / "calibration").iterdir()} == {
        "left_00.png",
        "right_00.png",
        "rig.yaml",
    }
    picture = read_grey_image(folder / "left_00.png")
    assert picture.shape == (207, 282)


def test_the_truth_says_where_material_is_seen(folder):
    twin = read_twin(folder / "truth.npz")
    material = np.array([[0.0, 0.0], [10.0, -20.0], [-30.0, 5.0]])
    flat, _ = map_points(twin.maps[0], material)
    np.testing.assert_allclose(flat, np.column_stack([material, np.zeros(3)]), atol=1e-6)
    pushed, _ = map_points(twin.maps[1], material)
    assert pushed[0, 2] > 20.0
    seen = twin.rig.cameras[0].project(flat)
    inside = read_white(folder / "mask_left.png")
    assert inside[tuple(np.rint(seen).astype(int).T[::-1])].all()


def test_a_rim_of_the_truth_stays_where_it_is(folder):
    twin = read_twin(folder / "truth.npz")
    angle = np.linspace(0, 6, 20)
    rim = 37.9 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    moved = map_points(twin.maps[1], rim)[0] - map_points(twin.maps[0], rim)[0]
    assert np.abs(moved).max() < 0.2


@pytest.mark.parametrize("law", ["fe", "analytic"])
def test_the_bulge_is_strained_beyond_one_and_a_half(law):
    config = TwinConfig(kind="bulge", law=law, scale=0.12, steps=2, rings=8, height=1.12)
    twin = make_twin(config)
    assert twin.radius == 22.5
    assert twin.travel[0] == 0
    middle, slope = map_points(twin.maps[-1], np.array([[0.0, 0.0], [1.0, 0.5]]))
    assert middle[0, 2] == pytest.approx(twin.travel[-1], abs=0.1)
    green = (np.swapaxes(slope, 1, 2) @ slope - np.eye(2)) / 2
    assert np.linalg.eigvalsh(green).min() > 1.2
    assert region_of_first(twin).sum() > 1_000


def test_pictures_of_another_origin_are_left_alone(tmp_path):
    (tmp_path / "photo.png").write_bytes(b"mine")
    with pytest.raises(ConfigError, match=r"holds photo\.png and is no synthetic experiment"):
        write_twin_case(SMALL, tmp_path, listener=lambda _: None)


def test_a_file_that_is_no_truth_is_refused(tmp_path):
    (tmp_path / "truth.npz").write_bytes(b"nothing")
    with pytest.raises(DataError, match=r"expected the truth\.npz of a stereo experiment"):
        read_twin(tmp_path / "truth.npz")
