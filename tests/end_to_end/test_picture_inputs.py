"""Every kind of picture file, regions, sequences and YAML at the command line."""

import json

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image

from shapemorph.cli import main
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture

pytestmark = pytest.mark.slow

SHAPE = (140, 170)
MOVED = np.array([1.3, -0.6])
QUICK = ("--set", "correlate.subset_size=21", "--set", "correlate.spacing=10", "--no-figures")


def levels(shift):
    """Grey 0 to 1 of the pattern moved by a shift."""
    return take_picture(
        planar_speckle(diameter=4.5, seed=4), SHAPE,
        Exposure(gain=1.0, offset=0.0, slope=0.0, noise=0.0, seed=0, blur=0.8),
        material_at=lambda p: p - shift, inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    ).grey  # fmt: skip


@pytest.fixture(scope="module")
def pair():
    return levels(np.zeros(2)), levels(MOVED)


def save_8(grey, path):
    Image.fromarray(np.rint(255 * grey).astype(np.uint8)).save(path)


def save_16(grey, path):
    cv2.imwrite(str(path), np.rint(65535 * grey).astype(np.uint16))


def save_colour(grey, path):
    """Colours whose Rec. 709 luma is the grey level, but none of whose channels is."""
    sway = 0.2 * np.sin(np.arange(grey.shape[1]) / 9.0)
    green = grey - 0.0722 / 0.7152 * sway
    colours = np.stack([grey, green, grey + sway], axis=-1)
    Image.fromarray(np.rint(255 * np.clip(colours, 0, 1)).astype(np.uint8)).save(path)


def run(capsys, *words):
    code = main([*map(str, words), "--quiet", "--json"])
    captured = capsys.readouterr()
    assert code == 0, captured.err
    return json.loads(captured.out)


def refused(capsys, code, *words):
    assert main([*map(str, words), "--quiet"]) == code
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


@pytest.mark.parametrize(
    ("save", "suffix"),
    [
        (save_8, "bmp"),
        (save_8, "jpg"),
        (save_16, "tif"),
        (save_16, "png"),
        (save_colour, "png"),
        (save_colour, "tiff"),
    ],
)
def test_every_format_gives_the_same_shift(pair, tmp_path, capsys, save, suffix):
    paths = [tmp_path / f"{name}.{suffix}" for name in ("a", "b")]
    for grey, path in zip(pair, paths, strict=True):
        save(grey, path)
    found = run(capsys, "correlate", *paths, "-o", tmp_path / "out", *QUICK)
    assert found["displacement_px"]["u"]["median"] == pytest.approx(MOVED[0], abs=4e-3)
    assert found["displacement_px"]["v"]["median"] == pytest.approx(MOVED[1], abs=4e-3)
    assert abs(found["strain"]["E1"]["median"]) < 1e-3
    assert found["strain"]["gauge_px"] == 4 * 10 + 21
    assert set(found["seconds"]) >= {"read", "correlate", "total"}
    assert found["correlate"]["points_per_second"] > 0


@pytest.fixture
def files(pair, tmp_path):
    for grey, name in zip(pair, ("a", "b"), strict=True):
        save_8(grey, tmp_path / f"{name}.png")
    return tmp_path


def write_yaml(path, **sections):
    path.write_text(yaml.safe_dump(sections), encoding="utf-8")
    return path


def test_a_yaml_file_names_pictures_and_polygons(files, capsys):
    left = [[20, 20], [70, 20], [70, 120], [20, 120]]
    right = [[100, 20], [150, 20], [150, 120], [100, 120]]
    hole = [[30, 50], [60, 50], [60, 80], [30, 80]]
    config = write_yaml(
        files / "case.yaml",
        inputs={
            "reference": "a.png",
            "deformed": "b.png",
            "region": {"polygons": [left, right], "holes": [hole]},
        },
        correlate={"subset_size": 21, "spacing": 5},
        report={"figures": False},
    )
    words = ("correlate", config, "-o", files / "out")
    found = run(capsys, *words)
    with np.load(files / "out" / "correlation.npz") as table:
        x, y = table["x_px"], table["y_px"]
    in_left, in_right = (x >= 20) & (x < 70), (x >= 100) & (x < 150)
    in_hole = (x >= 30) & (x < 60) & (y >= 50) & (y < 80)
    assert (in_left | in_right).all()
    assert not in_hole.any()
    assert in_left.sum() == 10 * 20 - 6 * 6
    assert in_right.sum() == 10 * 20
    assert found["points"]["ok_share"] > 0.85  # corners lack half of their subsets
    first = (files / "out" / "correlation.csv").stat().st_mtime_ns
    assert main([*map(str, words), "--quiet"]) == 0
    assert "nothing to do" in capsys.readouterr().out
    assert (files / "out" / "correlation.csv").stat().st_mtime_ns == first
    run(capsys, *words, "--set", "correlate.spacing=10")
    assert (files / "out" / "correlation.csv").stat().st_mtime_ns != first
    assert main(["run", str(files / "out"), "--quiet"]) == 0
    assert "nothing to do" in capsys.readouterr().out


def test_a_sequence_in_yaml_and_at_the_command_line_are_one(files, capsys):
    config = write_yaml(
        files / "case.yaml",
        inputs={"sequence": "?.png"},
        correlate={"subset_size": 21, "spacing": 10},
        report={"figures": False},
    )
    by_file = run(capsys, "correlate", config, "-o", files / "one")
    words = ("correlate", "--sequence", files / "?.png", "-o", files / "two", *QUICK)
    by_words = run(capsys, *words)
    for found in (by_file, by_words):
        assert [row["frame"] for row in found["frames"]] == ["b"]
        assert found["frames"][0]["u_median_px"] == pytest.approx(MOVED[0], abs=4e-3)
    texts = [(files / name / "b" / "correlation.csv").read_bytes() for name in ("one", "two")]
    assert texts[0] == texts[1]


def test_a_stack_of_pages_is_a_sequence_but_no_picture(pair, tmp_path, capsys):
    pages = [Image.fromarray(np.rint(255 * grey).astype(np.uint8)) for grey in pair]
    stack = tmp_path / "stack.tif"
    pages[0].save(stack, save_all=True, append_images=pages[1:])
    found = run(capsys, "correlate", "--sequence", stack, "-o", tmp_path / "out", *QUICK[:-1])
    assert found["frames"][0]["frame"] == "stack_2"
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["figures", "frames.csv", "stack_2", "summary.json"]
    assert (tmp_path / "out" / "figures" / "frames.png").is_file()
    assert (tmp_path / "out" / "stack_2" / "figures" / "strain.png").is_file()
    error = refused(capsys, 3, "correlate", stack, stack, "-o", tmp_path / "no")
    assert "expected one picture, got 2" in error


@pytest.mark.parametrize(
    ("inputs", "code", "expected"),
    [
        ({"reference": "a.png"}, 2, "inputs.deformed is empty"),
        ({"reference": "a.png", "deformed": "b.obj"}, 2, "two pictures or two meshes"),
        ({"reference": "a.png", "sequence": "?.png"}, 2, "instead of reference and deformed"),
        ({"sequence": "nothing*.png"}, 3, "expected two pictures or more, got 0"),
        (
            {
                "reference": "a.png",
                "deformed": "b.png",
                "region": {"polygon": [[900, 0], [999, 0], [999, 9]]},
            },
            2,
            "leave no pixel of",
        ),
        (
            {
                "reference": "a.png",
                "deformed": "b.png",
                "region": {"centre": [0, 0, 0], "radius": 5},
            },
            2,
            "ball around a mesh",
        ),
        (
            {
                "reference": "a.png",
                "deformed": "b.png",
                "region": {"holes": [[[-5, -5], [200, -5], [200, 200], [-5, 200]]]},
            },
            2,
            "leave no pixel of",
        ),
    ],
)
def test_inputs_that_make_no_sense_are_one_clear_line(files, capsys, inputs, code, expected):
    config = write_yaml(files / "case.yaml", inputs=inputs)
    assert expected in refused(capsys, code, "correlate", config, "-o", files / "out")
    assert not (files / "out").exists()


def test_a_stage_of_meshes_is_refused_for_pictures(files, capsys):
    config = write_yaml(files / "case.yaml", inputs={"reference": "a.png", "deformed": "b.png"})
    error = refused(capsys, 2, "strain", config, "-o", files / "out")
    assert "stages morph and correlate" in error


def test_two_pictures_and_a_sequence_are_refused(files, capsys):
    words = ("correlate", files / "a.png", "--sequence", "*.png", "-o", files / "out")
    assert "stands instead of two pictures" in refused(capsys, 2, *words)
    assert "got none" in refused(capsys, 2, "correlate", "-o", files / "out")
