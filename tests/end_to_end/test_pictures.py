"""`morph` and `correlate` on two plain pictures with a known affine map between them."""

import json

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from shapemorph.cli import main
from shapemorph.io.images import read_grey_image, write_grey_png

pytestmark = pytest.mark.slow

HEIGHT, WIDTH = 300, 380
MATRIX = np.array([[1.5, 0.2], [-0.15, 1.1]])  # far beyond what subsets follow from scratch
SHIFT = np.array([30.0, 70.0])


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Folder with a.png, b.png (b shows a moved by the map) and a mask."""
    folder = tmp_path_factory.mktemp("pictures")
    fine = gaussian_filter(np.random.default_rng(2).normal(size=(4 * HEIGHT, 4 * WIDTH)), 6.0)
    fine = 0.5 + 0.18 * fine / fine.std()
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    _write(folder / "a.png", fine, columns, rows)
    size = (480, 700)
    rows, columns = np.mgrid[0 : size[0], 0 : size[1]].astype(float)
    back = (np.stack([columns, rows], axis=-1) - SHIFT) @ np.linalg.inv(MATRIX).T
    _write(folder / "b.png", fine, back[..., 0], back[..., 1])
    mask = np.zeros((HEIGHT, WIDTH), "f4")
    mask[60:220, 80:300] = 1.0
    write_grey_png(folder / "mask.png", mask, np.ones(mask.shape, bool))
    return folder


def _write(path, fine, x, y):
    grey = map_coordinates(fine, [4 * y, 4 * x], order=1, mode="constant", cval=0.5)
    noise = np.random.default_rng(3).normal(scale=0.005, size=grey.shape)
    write_grey_png(path, np.clip(grey + noise, 0, 1).astype("f4"), np.ones(grey.shape, bool))


def _run(capsys, *words):
    assert main([str(word) for word in (*words, "--json", "--quiet")]) == 0
    return json.loads(capsys.readouterr().out)


def _true_displacement(x, y):
    place = np.stack([x, y], axis=-1)
    return place @ MATRIX.T + SHIFT - place


def test_correlation_finds_the_map_where_the_material_is_in_both(pictures, tmp_path, capsys):
    words = ("correlate", pictures / "a.png", pictures / "b.png", "-o", tmp_path / "out")
    found = _run(capsys, *words, "--no-figures")
    assert not (tmp_path / "out" / "figures").exists()
    with np.load(tmp_path / "out" / "correlation.npz") as table:
        ok = table["status"] == 0
        x, y = table["x_px"][ok], table["y_px"][ok]
        error = np.stack([table["u_px"][ok], table["v_px"][ok]], -1) - _true_displacement(x, y)
        gradient = np.array([np.median(table[name][ok]) for name in ("du_dx", "du_dy")])
        assert not np.any(x % found["correlate"]["spacing_px"])
    assert ok.mean() > 0.9
    assert np.median(np.abs(error)) < 0.01  # noise of 1.3 grey levels
    assert np.percentile(np.abs(error), 99) < 0.1
    np.testing.assert_allclose(gradient, [0.5, 0.2], atol=2e-3)
    assert found["points"]["ok"] == ok.sum()
    assert found["verdict"]["level"] == "PASS"


def test_a_mask_and_a_subset_size_limit_what_is_measured(pictures, tmp_path, capsys):
    words = ("correlate", pictures / "a.png", pictures / "b.png", "-o", tmp_path / "out")
    more = ("--mask", pictures / "mask.png", "--set", "correlate.subset_size=31")
    found = _run(capsys, *words, *more)
    assert found["correlate"]["subset_size_px"] == 31
    assert (tmp_path / "out" / "figures").is_dir()
    with np.load(tmp_path / "out" / "correlation.npz") as table:
        assert table["x_px"].min() >= 80
        assert table["x_px"].max() < 300
        assert table["y_px"].max() < 220


def test_a_mask_of_another_size_is_refused(pictures, tmp_path, capsys):
    words = ["correlate", pictures / "a.png", pictures / "b.png", "-o", tmp_path / "out"]
    assert main([*map(str, words), "--mask", str(pictures / "b.png"), "--quiet"]) == 3
    assert "expected the size of the reference, 380 x 300 px" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_morph_sequence_goes_from_one_picture_to_the_other(pictures, tmp_path, capsys):
    folder = tmp_path / "out"
    words = ("morph", pictures / "a.png", pictures / "b.png", "-o", folder)
    found = _run(capsys, *words, "--set", "morph.images=4")
    names = sorted(path.name for path in (folder / "sequence").iterdir())
    assert names == [f"I_{number:02d}.png" for number in range(1, 7)]
    matches = np.loadtxt(folder / "matches.csv", delimiter=",", skiprows=1)
    assert len(matches) == found["match"]["pairs"]
    expected = _true_displacement(matches[:, 0], matches[:, 1])
    error = np.linalg.norm(matches[:, 2:] - matches[:, :2] - expected, axis=1)
    assert np.percentile(error, 95) < 1.0
    middle = [read_grey_image(folder / "sequence" / f"I_0{number}.png") for number in (3, 4)]
    both = middle[0].mask & middle[1].mask
    assert both.sum() > 60_000
    # the same half-way state from both sides: 8 bit, noise of 1.3 levels, warps to 0.1 px
    assert np.median(np.abs(middle[0].grey - middle[1].grey)[both]) < 0.02
    with np.load(folder / "warp_forward.npz") as warp:
        assert set(warp.files) == {"coefficients", "origin", "spacing"}


def test_the_steps_follow_from_the_strain_or_are_given(pictures, tmp_path, capsys):
    folder = tmp_path / "out"
    words = ("morph", pictures / "a.png", pictures / "b.png", "-o", folder)
    found = _run(capsys, *words)["morph"]
    # the largest stretch is 1.54: in steps of 15 % that takes 4 between
    assert found["images"] == 6
    assert max(found["strain"]) < 0.15
    assert min(found["zncc"]) > 0.9
    with Image.open(folder / "sequence.gif") as film:
        assert film.n_frames == 6
    given = _run(capsys, *words, "--steps", "4")["morph"]
    assert given["images"] == 4
    assert max(given["strain"]) > 0.15
    assert main([*map(str, words), "--steps", "5", "--quiet"]) == 2
    assert "even number" in capsys.readouterr().err


def test_another_law_ends_in_the_same_field(pictures, tmp_path, capsys):
    fields = []
    for law in ("warp", "polynomial"):
        folder = tmp_path / law
        words = ("correlate", pictures / "a.png", pictures / "b.png", "-o", folder, "--no-figures")
        _run(capsys, *words, "--set", f"morph.law={law}", "--set", "morph.order=1")
        with np.load(folder / "correlation.npz") as table:
            fields.append((table["status"] == 0, table["u_px"]))
    both = fields[0][0] & fields[1][0]
    assert both.sum() > 0.98 * fields[0][0].sum()
    apart = (fields[0][1] - fields[1][1])[both]
    assert np.sqrt((apart**2).mean()) < 0.005


def test_a_law_that_two_pictures_cannot_follow_is_refused_at_once(pictures, tmp_path, capsys):
    words = ["morph", pictures / "a.png", pictures / "b.png", "-o", tmp_path / "out", "--quiet"]
    assert main([*map(str, words), "--set", "morph.law=landmarks"]) == 2
    assert "landmarks with morph.dots" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["morph", "correlate"])
def test_pictures_that_do_not_match_are_exit_4_and_leave_only_a_picture_of_why(
    pictures, tmp_path, capsys, command
):
    noise = gaussian_filter(np.random.default_rng(9).normal(size=(HEIGHT, WIDTH)), 1.5)
    other = np.clip(0.5 + 0.2 * noise / noise.std(), 0, 1).astype("f4")
    write_grey_png(tmp_path / "other.png", other, np.ones(other.shape, bool))
    words = [command, pictures / "a.png", tmp_path / "other.png", "-o", tmp_path / "out"]
    assert main([*map(str, words), "--quiet"]) == 4
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "failed_match.png" in error
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["failed_match.png"]


def test_a_missing_picture_is_exit_3_and_leaves_nothing(pictures, tmp_path, capsys):
    words = ["correlate", pictures / "a.png", pictures / "absent.png", "-o", tmp_path / "out"]
    assert main([*map(str, words), "--quiet"]) == 3
    assert "absent.png" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_pattern_in_one_colour_is_followed_there(pictures, tmp_path, capsys):
    """Red on green of equal brightness: grey as the eye sees it shows nothing."""
    for name in ("a", "b"):
        grey = np.asarray(Image.open(pictures / f"{name}.png").convert("L")).astype(float) - 127.5
        colours = 127.5 + grey[..., None] * [0.7, -0.7 * 0.2126 / 0.7152, 0.0]
        Image.fromarray(np.rint(colours).astype(np.uint8)).save(tmp_path / f"{name}.png")
    words = ("correlate", tmp_path / "a.png", tmp_path / "b.png", "-o", tmp_path / "out")
    found = _run(capsys, *words, "--no-figures")
    assert found["inputs"]["channel"] == "red"
    assert "gradient" in found["inputs"]["channel_reason"]
    with np.load(tmp_path / "out" / "correlation.npz") as table:
        ok = table["status"] == 0
        x, y = table["x_px"][ok], table["y_px"][ok]
        error = np.stack([table["u_px"][ok], table["v_px"][ok]], -1) - _true_displacement(x, y)
    assert ok.mean() > 0.9
    assert np.median(np.abs(error)) < 0.015
