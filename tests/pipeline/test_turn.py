import json

import numpy as np
import pytest
import yaml

from shapemorph.cli.main import main
from shapemorph.core.calibration import Target, View
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.transform import RigidTransform
from shapemorph.io.images import write_grey_png
from shapemorph.io.meshes import read_mesh
from shapemorph.io.rig_files import write_rig
from shapemorph.methods.synthetic.photographs import Exposure, Film, exposed

RADIUS, DISTANCE, STEP, COUNT = 25.0, 220.0, 15.0, 6
SIZE = (280, 240)


def pose_at(degrees):
    """The camera's view of a ball that has turned about its axis y: camera_from_part."""
    turn = np.radians(degrees)
    rotation = np.array(
        [[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]]
    )
    return RigidTransform(rotation, np.array([0.0, 0.0, DISTANCE]))


def photograph_ball(film, pose, pattern, exposure):
    """Photograph a ball about the origin of the part; its pattern is made of plane waves."""
    eye = -pose.rotation.T @ pose.translation
    shade = np.zeros(film.flat.shape[:2])
    offsets = ((0.25, -0.25), (-0.25, 0.25), (0.25, 0.25), (-0.25, -0.25))
    for right, down in offsets:
        flat = film.within(right, down)
        rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
        rays = rays @ pose.rotation / np.linalg.norm(rays, axis=-1, keepdims=True)
        along = rays @ eye
        inside = along**2 - (eye @ eye - RADIUS**2)
        reach = -along - np.sqrt(np.maximum(inside, 0))
        points = eye + reach[..., None] * rays
        shade += np.where(inside > 0, pattern(points), 0.05)
    return exposed(shade / len(offsets), exposure), inside > 0


@pytest.fixture(scope="module")
def pattern():
    rng = np.random.default_rng(5)
    vectors = rng.normal(0, 1.5, (160, 3)).clip(-3.5, 3.5)
    phases = rng.uniform(0, 2 * np.pi, 160)

    def at(points):
        return 0.45 + 0.1 * np.sqrt(2 / 160) * sum(
            np.cos(points @ vector + phase) for vector, phase in zip(vectors, phases, strict=True)
        )

    return at


@pytest.fixture(scope="module")
def case(pattern, tmp_path_factory):
    folder = tmp_path_factory.mktemp("turn")
    camera = Camera(SIZE, np.array([900.0, 900.0]), np.array([140.0, 119.0]))
    film = Film(camera)
    target = Target("cone", np.eye(4, 3))
    views = []
    for k in range(COUNT):
        pose = pose_at(k * STEP)
        exposure = Exposure(samples=4, blur=0.0, noise=1.0, seed=k)
        picture, ball = photograph_ball(film, pose, pattern, exposure)
        if k == 2:  # glare that other views do not have
            picture[100:130, 150:180] = 1.0
        whole = np.ones(ball.shape, bool)
        write_grey_png(folder / f"part_{k}.png", picture, whole)
        write_grey_png(folder / f"mask_{k}.png", ball.astype(np.float32), whole)
        views.append((View(f"cone {k}", target), pose))
    write_rig(folder / "calibration.json", Rig((camera,), ("cam",)), (), views)
    document = {
        "calibration": "calibration.json",
        "target": "cone",
        "pictures": {"cam": "part_*.png"},
        "masks": {"cam": "mask_*.png"},
        "angle": 15.0,
        "patches": 3,
    }
    (folder / "turn.yaml").write_text(yaml.safe_dump(document))
    return folder


@pytest.mark.slow
def test_views_all_around_become_one_mesh(case, pattern, tmp_path, capsys):
    out = tmp_path / "out"
    code = main(["reconstruct", str(case / "turn.yaml"), "-o", str(out), "--quiet"])
    said = capsys.readouterr()
    assert code == 0, said.err
    assert "they agree to" in said.out
    summary = json.loads((out / "summary.json").read_text())
    assert len(summary["patches"]) == 3
    assert summary["overlap_rms_mm"] < 0.12  # half a pixel, seen under 15 degrees
    mesh, _ = read_mesh(out / "mesh.obj", unit="mm")
    radius = np.linalg.norm(mesh.vertices, axis=1)
    assert abs(radius.mean() - RADIUS) < 0.02
    assert radius.std() < 0.05  # 0.24 mm a pixel, 15 degrees
    angle = np.degrees(np.arctan2(mesh.vertices[:, 0], -mesh.vertices[:, 2]))
    assert np.ptp(angle) > 110  # one view alone sees 80 of it so well
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normals * corners.mean(axis=1)).sum(axis=1) > 0).mean() > 0.999
    uv = mesh.wedge_uv.mean(axis=1)
    texture = mesh.textures[0]
    height, width = texture.shape
    x = np.clip(np.rint(uv[:, 0] * width - 0.5).astype(int), 0, width - 1)
    y = np.clip(np.rint((1 - uv[:, 1]) * height - 0.5).astype(int), 0, height - 1)
    seen, true = texture[y, x], pattern(corners.mean(axis=1))
    assert np.corrcoef(seen, true)[0, 1] > 0.9
    assert np.abs(seen - true).max() < 0.35  # the glare, 0.5 brighter, is gone


def refused(case, changes, tmp_path, capsys):
    document = yaml.safe_load((case / "turn.yaml").read_text())
    (case / "bad.yaml").write_text(yaml.safe_dump({**document, **changes}))
    out = tmp_path / "out"
    code = main(["reconstruct", str(case / "bad.yaml"), "-o", str(out), "--quiet"])
    assert not out.exists()
    return code, capsys.readouterr().err


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"target": "board"}, "expected views of target 'board'"),
        ({"pictures": {"top": "part_*.png"}}, "camera 'top' is not in calibration.json"),
        ({"pictures": {"cam": "mask*.png"}}, "must stand for the name of a view"),
        ({"angle": 5.0}, "no two of 6 views are about 5 degrees apart"),
    ],
)
def test_says_what_is_wrong(case, tmp_path, capsys, changes, message):
    code, error = refused(case, changes, tmp_path, capsys)
    assert code == 3
    assert message in error
    assert error.count("\n") == 1
