import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.cli.main import main
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.transform import RigidTransform
from shapemorph.io.images import write_grey_png
from shapemorph.io.meshes import read_mesh
from shapemorph.io.rig_files import write_rig
from shapemorph.methods.synthetic.photographs import Exposure, Film, photograph_plane

SIZE = (320, 240)
NORMAL = Rotation.from_euler("xy", [12, 9], degrees=True).as_matrix()[:, 2]
MIDDLE = np.array([0.0, 0.0, 260.0])


@pytest.fixture(scope="module")
def rig():
    turn = Rotation.from_euler("y", 15, degrees=True).as_matrix()
    left = Camera(
        SIZE, np.array([1300.0, 1302.0]), np.array([161.0, 118.0]), radial=np.array([-0.2, 0, 0])
    )
    right = Camera(
        SIZE,
        np.array([1290.0, 1291.0]),
        np.array([158.0, 121.0]),
        radial=np.array([-0.15, 0.0, 0.0]),
        pose=RigidTransform(turn, MIDDLE - turn @ MIDDLE),
    )
    return Rig((left, right), ("left", "right"))


@pytest.fixture(scope="module")
def case(rig, wave_pattern, tmp_path_factory):
    """Two photographs of a tilted plane with a pattern, and the calibration."""
    folder = tmp_path_factory.mktemp("stereo")
    pattern = wave_pattern(size=1.1)
    rotation = Rotation.from_euler("xy", [12, 9], degrees=True).as_matrix()
    pose = RigidTransform(rotation, MIDDLE)
    for number, (name, camera) in enumerate(zip(rig.names, rig.cameras, strict=True)):
        exposure = Exposure(samples=4, blur=0.3, noise=1.0, seed=number)
        picture = photograph_plane(Film(camera), pose, pattern, exposure)
        write_grey_png(folder / f"{name}.png", picture, np.ones(picture.shape, bool))
    write_rig(folder / "calibration.json", rig)
    return folder


def run(capsys, *words):
    code = main([str(word) for word in words])
    spoken = capsys.readouterr()
    return code, spoken.out, spoken.err


def arguments(case, out, *settings, calibration="calibration.json", pictures=("left", "right")):
    sets = [word for setting in settings for word in ("--set", setting)]
    names = [case / f"{name}.png" for name in pictures]
    return ["reconstruct", case / calibration, *names, "-o", out, "--quiet", *sets]


def test_two_photographs_become_a_textured_mesh(case, tmp_path, capsys):
    out = tmp_path / "out"
    code, said, error = run(capsys, *arguments(case, out))
    assert code == 0, error
    assert "epipolar" in said
    mesh = read_mesh(out / "mesh.obj", unit="mm")[0]
    height = (mesh.vertices - MIDDLE) @ NORMAL
    assert np.sqrt((height**2).mean()) < 0.02  # 0.2 mm a pixel, 15 degrees
    assert len(mesh.vertices) > 500
    assert mesh.textures[0].shape == SIZE[::-1]
    summary = json.loads((out / "summary.json").read_text())
    assert summary["reconstruct"]["epipolar_px"]["rms"] < 0.05
    assert summary["verdict"]["level"] == "PASS"
    table = np.genfromtxt(out / "points.csv", delimiter=",", names=True)
    ok = table["status"] == 0
    off = np.stack([table[f"{axis}_mm"] for axis in "xyz"], axis=-1)[ok] @ NORMAL
    error = off - MIDDLE @ NORMAL
    sigma = table["sigma_z_mm"][ok] * NORMAL[2]
    assert 0.5 < (np.abs(error) < sigma).mean() < 0.8
    assert (out / "figures" / "reconstruction.png").stat().st_size > 10_000


def test_smoothing_brings_a_plane_nearer_to_a_plane(case, tmp_path, capsys):
    rms = []
    for word in ("false", "true"):
        out = tmp_path / word
        words = arguments(case, out, f"reconstruct.smooth={word}", "report.figures=false")
        assert run(capsys, *words)[0] == 0
        mesh = read_mesh(out / "mesh.obj", unit="mm")[0]
        rms.append(np.std((mesh.vertices - MIDDLE) @ NORMAL))
    assert rms[1] < 0.7 * rms[0]


def refused(capsys, words, out):
    code, _, error = run(capsys, *words)
    assert not out.exists()
    assert error.count("\n") == 1
    return code, error


def test_swapped_pictures_are_named(case, tmp_path, capsys):
    out = tmp_path / "out"
    code, error = refused(capsys, arguments(case, out, pictures=("right", "left")), out)
    assert code == 3
    assert "cameras swapped" in error
    assert "name the picture of left first" in error


def test_a_rig_that_has_moved_is_refused_and_can_be_oriented_anew(case, rig, tmp_path, capsys):
    left, right = rig.cameras
    turn = Rotation.from_euler("x", 0.5, degrees=True).as_matrix()
    moved = RigidTransform(turn @ right.pose.rotation, right.pose.translation)
    write_rig(case / "moved.json", Rig((left, right.placed(moved)), rig.names))
    out = tmp_path / "out"
    words = arguments(case, out, "report.figures=false", calibration="moved.json")
    code, error = refused(capsys, words, out)
    assert code == 3
    assert "the calibration contradicts the pictures" in error
    assert run(capsys, *words, "--set", "reconstruct.orient=true")[0] == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["reconstruct"]["epipolar_px"]["rms"] < 0.05


def test_a_calibration_of_another_size(case, rig, tmp_path, capsys):
    bigger = tuple(replace(camera, size=(640, 480)) for camera in rig.cameras)
    write_rig(case / "bigger.json", Rig(bigger, rig.names))
    out = tmp_path / "out"
    code, error = refused(capsys, arguments(case, out, calibration="bigger.json"), out)
    assert code == 3
    assert "is for pictures of 640 x 480 px, got 320 x 240 px" in error


def test_a_calibration_of_one_camera(case, rig, tmp_path, capsys):
    write_rig(case / "one.json", Rig(rig.cameras[:1], rig.names[:1]))
    out = tmp_path / "out"
    code, error = refused(capsys, arguments(case, out, calibration="one.json"), out)
    assert code == 3
    assert "expected two cameras, got 1" in error


def test_a_picture_that_is_not_there(case, tmp_path, capsys):
    out = tmp_path / "out"
    code, error = refused(capsys, arguments(case, out, pictures=("left", "top")), out)
    assert code == 3
    assert "top.png" in error
