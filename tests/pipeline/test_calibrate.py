import json
import shutil

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from shapemorph.cli.main import main
from shapemorph.core.camera import Camera
from shapemorph.core.transform import RigidTransform
from shapemorph.io.images import write_grey_png
from shapemorph.io.rig_files import read_rig
from shapemorph.methods.synthetic.photographs import (
    Exposure,
    Film,
    chessboard_pattern,
    photograph_plane,
)

SIZE, VIEWS = (320, 240), 7
BOARD = (7, 5, 10.0)


@pytest.fixture(scope="module")
def cameras():
    turn = Rotation.from_euler("y", 15, degrees=True).as_matrix()
    there = np.array([0.0, 0.0, 260.0])
    left = Camera(
        SIZE, np.array([700.0, 702.0]), np.array([161.0, 118.0]), radial=np.array([-0.2, 0.0, 0.0])
    )
    right = Camera(
        SIZE,
        np.array([690.0, 691.0]),
        np.array([158.0, 121.0]),
        radial=np.array([-0.15, 0.0, 0.0]),
        pose=RigidTransform(turn, there - turn @ there),
    )
    return left, right


@pytest.fixture(scope="module")
def pictures(cameras, tmp_path_factory):
    """A folder with seven pairs of pictures of a chessboard."""
    folder = tmp_path_factory.mktemp("pictures")
    films = [Film(camera) for camera in cameras]
    middle = np.array([30.0, 20.0, 0.0])
    rng = np.random.default_rng(3)
    for k in range(VIEWS):
        rotation = Rotation.from_rotvec(rng.uniform(-0.45, 0.45, 3)).as_matrix()
        shift = np.array([*rng.uniform(-12, 12, 2), 260 + rng.uniform(-20, 20)])
        pose = RigidTransform(rotation, shift - rotation @ middle)
        for name, film in zip(("left", "right"), films, strict=True):
            exposure = Exposure(samples=9, blur=0.6, noise=1.5, seed=k)
            picture = photograph_plane(film, pose, chessboard_pattern(*BOARD), exposure)
            write_grey_png(folder / f"{name}{k}.png", picture, np.ones(picture.shape, bool))
    return folder


def rig_file(folder, **changes):
    document = {
        "cameras": ["left", "right"],
        "targets": {
            "board": {"kind": "chessboard", "columns": 7, "rows": 5, "spacing": 10.0},
        },
        "views": [
            {"target": "board", "pictures": {"left": "left*.png", "right": "right*.png"}},
        ],
        "calibrate": {"radial": 1},
    }
    path = folder / "rig.yaml"
    path.write_text(yaml.safe_dump({**document, **changes}))
    return path


def run(capsys, *words):
    code = main([str(word) for word in words])
    spoken = capsys.readouterr()
    return code, spoken.out, spoken.err


def test_pictures_become_a_calibration(pictures, cameras, tmp_path, capsys):
    out = tmp_path / "out"
    code, said, _ = run(capsys, "calibrate", rig_file(pictures), "-o", out, "--quiet")
    assert code == 0
    assert "mm from left" in said
    rig = read_rig(out / "calibration.json", (1, 1))
    summary = json.loads((out / "summary.json").read_text())
    for camera, true in zip(rig.cameras, cameras, strict=True):
        np.testing.assert_allclose(camera.focal, true.focal, rtol=4e-3)
    true = np.linalg.norm(cameras[1].position)
    pair = summary["pairs"][0]
    assert abs(pair["baseline_mm"] - true) < 5 * pair["sigma_baseline_mm"] + 0.05
    assert summary["rms_px"] < 0.08
    assert summary["cameras"]["left"]["sigma"]["fx"] > 0
    assert {entry["view"] for entry in summary["views"]} == {f"board {k}" for k in range(VIEWS)}
    rows = (out / "residuals.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * VIEWS * 35 - summary["dropped_points"]
    assert summary["dropped_points"] < 5
    for name in ("figures/residuals.png", "figures/views.png", "opencv.yml", "vic3d.xml"):
        assert (out / name).stat().st_size > 500


def test_an_earlier_calibration_shows_that_the_rig_has_moved(pictures, tmp_path, capsys):
    path = rig_file(pictures, report={"figures": False})
    first = tmp_path / "first"
    assert run(capsys, "calibrate", path, "-o", first, "--quiet")[0] == 0
    same = run(
        capsys,
        "calibrate",
        path,
        "-o",
        tmp_path / "b",
        "--quiet",
        "--json",
        "--set",
        f"calibrate.before={first / 'calibration.json'}",
    )[1]
    assert json.loads(same)["drift"]["shape_mm"] < 1e-6
    document = json.loads((first / "calibration.json").read_text())
    document["cameras"][1]["translation_mm"][1] += 1.0
    (first / "moved.json").write_text(json.dumps(document))
    moved = run(
        capsys,
        "calibrate",
        path,
        "-o",
        tmp_path / "c",
        "--quiet",
        "--json",
        "--set",
        f"calibrate.before={first / 'moved.json'}",
    )[1]
    found = json.loads(moved)
    assert found["drift"]["epipolar_px"] == pytest.approx(700 / 260 / 2, rel=0.1)
    assert any("the rig has moved" in reason for reason in found["verdict"]["reasons"])


@pytest.fixture
def copied(pictures, tmp_path):
    return shutil.copytree(pictures, tmp_path / "pictures")


def refused(capsys, path, tmp_path):
    code, _, error = run(capsys, "calibrate", path, "-o", tmp_path / "out", "--quiet")
    assert not (tmp_path / "out").exists()
    assert error.count("\n") == 1
    return code, error


def test_a_board_that_is_not_there(copied, tmp_path, capsys):
    target = {"board": {"kind": "chessboard", "columns": 9, "rows": 6, "spacing": 10.0}}
    code, error = refused(capsys, rig_file(copied, targets=target), tmp_path)
    assert code == 3
    assert "left: the target was found in none of its 7 pictures" in error
    assert "9 x 6 inner corners" in error


def test_pictures_of_one_camera_are_missing(copied, tmp_path, capsys):
    for path in copied.glob("right*.png"):
        path.unlink()
    code, error = refused(capsys, rig_file(copied), tmp_path)
    assert code == 3
    assert "camera right, target board: pictures right*.png: no file" in error


def test_pictures_with_nothing_in_common(copied, tmp_path, capsys):
    for path in copied.glob("right*.png"):
        path.rename(copied / path.name.replace("right", "right1"))
    code, error = refused(capsys, rig_file(copied), tmp_path)
    assert code == 3
    assert "no picture of one camera has the name of one of another" in error


def test_a_picture_of_another_size(copied, tmp_path, capsys):
    write_grey_png(copied / "left3.png", np.zeros((200, 320)), np.ones((200, 320), bool))
    code, error = refused(capsys, rig_file(copied), tmp_path)
    assert code == 3
    assert "left3.png: expected 320 x 240 px" in error


def test_views_that_contradict_each_other(copied, tmp_path, capsys):
    for k in range(VIEWS):
        (copied / f"right{k}.png").rename(copied / f"moved{(k + 3) % VIEWS}.png")
    for k in range(VIEWS):
        (copied / f"moved{k}.png").rename(copied / f"right{k}.png")
    code, error = refused(capsys, rig_file(copied), tmp_path)
    assert code == 3
    assert "views contradict each other: of 7" in error


def test_one_pair_with_its_cameras_swapped_is_put_aside(copied, tmp_path, capsys):
    (copied / "left2.png").rename(copied / "swap.png")
    (copied / "right2.png").rename(copied / "left2.png")
    (copied / "swap.png").rename(copied / "right2.png")
    path = rig_file(copied, report={"figures": False})
    code, said, _ = run(capsys, "calibrate", path, "-o", tmp_path / "out", "--quiet", "--json")
    assert code == 0
    rejected = json.loads(said)["rejected"]
    assert {entry["what"] for entry in rejected} == {"board 2 in right"}
    assert "different places" in rejected[0]["reason"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cameras": ["left"]}, "name camera 'right'"),
        ({"targets": {"board": {"kind": "chessboard", "columns": 7}}}, "needs rows, spacing"),
        ({"targets": {"board": {"kind": "points"}}}, "give points"),
        ({"calibrate": {"radial": 4}}, "radial"),
        ({"views": [{"target": "disc", "pictures": {"left": "l"}}]}, "name target 'disc'"),
        ({"cameras": ["left", "right", "top"]}, "camera top has no pictures"),
    ],
)
def test_says_what_is_wrong_with_the_file(copied, tmp_path, capsys, changes, message):
    code, error = refused(capsys, rig_file(copied, **changes), tmp_path)
    assert code == 2
    assert message in error
