"""A cone of dots that turns in front of one camera: its lens, and where the cone stood."""

import json

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from shapemorph.cli.main import main
from shapemorph.core.calibration import Target
from shapemorph.core.camera import Camera
from shapemorph.core.transform import RigidTransform
from shapemorph.io.images import write_grey_png
from shapemorph.io.rig_files import read_poses
from shapemorph.io.target_files import write_target
from shapemorph.methods.synthetic.photographs import Exposure, Film, photograph_dots

COLUMNS, ROWS, STEP, VIEWS = 24, 6, 25.0, 7
LEFT_OUT = {(1, 1), (2, 6), (3, 4), (1, 9), (4, 11), (2, 14), (3, 15), (1, 18), (4, 20), (3, 22)}


def cone():
    """Dots around a cone, some left out, so that every view tells where it is."""
    lattice = np.array(
        [(r, c) for r in range(ROWS) for c in range(COLUMNS) if (r, c) not in LEFT_OUT]
    )
    angle = 2 * np.pi * lattice[:, 1] / COLUMNS
    radius = 45.0 - 3.0 * lattice[:, 0]
    around = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = around * radius[:, None] + np.outer(lattice[:, 0] * 10.0, [0, 0, 1])
    normals = around + np.array([0, 0, 0.3])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Target("cone", points, normals=normals, dot_radius=2.0, lattice=lattice)


def pose(number):
    """Stand the cone before the camera, its axis up and leaning, and turn it: camera_from_cone."""
    upright = Rotation.from_euler("x", 115, degrees=True)
    turned = upright * Rotation.from_euler("z", number * STEP, degrees=True)
    shift = np.array([0.0, 12.0, 260.0])
    return RigidTransform(turned.as_matrix(), shift)


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cone")
    camera = Camera(
        (420, 360), np.array([900.0, 903.0]), np.array([212.0, 176.0]),
        radial=np.array([-0.15, 0.0, 0.0]),
    )  # fmt: skip
    film, target = Film(camera), cone()
    for k in range(VIEWS):
        exposure = Exposure(samples=12, blur=0.5, noise=1.0, seed=k)
        picture = photograph_dots(film, pose(k), target, exposure)
        write_grey_png(folder / f"frame_{k}.png", picture, np.ones(picture.shape, bool))
    write_target(folder / "cone.csv", target)
    document = {
        "cameras": ["cam"],
        "targets": {"cone": {"kind": "points", "points": "cone.csv", "dot_diameter": 4.0}},
        "views": [{"target": "cone", "pictures": {"cam": "frame_*.png"}}],
        "calibrate": {"radial": 1},
        "report": {"figures": False},
    }
    (folder / "rig.yaml").write_text(yaml.safe_dump(document))
    return folder


def test_one_camera_and_the_poses_of_a_cone_that_turned(case, tmp_path, capsys):
    out = tmp_path / "out"
    code = main(["calibrate", str(case / "rig.yaml"), "-o", str(out), "--quiet"])
    assert code == 0, capsys.readouterr().err
    summary = json.loads((out / "summary.json").read_text())
    assert not summary["rejected"]
    assert summary["rms_px"] < 0.06
    found = summary["cameras"]["cam"]
    assert abs(found["fx"] - 900) < 4 * found["sigma"]["fx"]
    assert abs(found["k1"] + 0.15) < 4 * found["sigma"]["k1"]
    poses = read_poses(out / "calibration.json", "cone")
    assert list(poses) == [str(k) for k in range(VIEWS)]
    for k in range(1, VIEWS):
        turn = Rotation.from_matrix(poses["0"].rotation.T @ poses[str(k)].rotation)
        expected = Rotation.from_euler("z", k * STEP, degrees=True)
        assert np.degrees((turn * expected.inv()).magnitude()) < 0.1
