import numpy as np
import pytest

from shapemorph.core.measurement import Measurement
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.smooth import fit_map
from shapemorph.methods.synthetic.stereo_rig import stereo_rig
from shapemorph.methods.twin_errors import between_methods, error_figures, twin_points

RIG = stereo_rig(scale=0.2, target=np.zeros(3))


@pytest.fixture
def twin():
    material, _ = disc_mesh(20.0, 16)
    flat = np.column_stack([material, np.zeros(len(material))])
    maps = tuple(fit_map(material, nodes, spacing=3.0) for nodes in (flat, flat * [1.5, 1.2, 1.0]))
    return StereoTwin("membrane", RIG, 20.0, maps, np.array([0.0, 1.0]))


def measured(world, bias):
    """Measurement in a world frame, displaced by the truth plus a bias in the body frame."""
    material = np.random.default_rng(0).uniform(-10, 10, (300, 2))
    body = np.column_stack([material, np.zeros(300)])
    moved = body * [0.5, 0.2, 0.0] + bias
    status = np.zeros(300, dtype=np.uint8)
    status[:5] = 7
    arrays = {
        "status": status,
        "displacement": world.rotate(moved),
        "E1": np.full(300, (1.5**2 - 1) / 2 + 0.01),
        "E2": np.full(300, (1.2**2 - 1) / 2),
    }
    return Measurement(world.apply(body), np.zeros((0, 4), np.int64), arrays)


@pytest.mark.parametrize("frame", ["body", "left camera"])
def test_errors_are_found_in_the_frame_of_the_body(twin, frame):
    bias = np.array([0.003, -0.001, 0.02])
    left = RIG.cameras[0].pose
    world = RigidTransform.identity() if frame == "body" else left
    cameras = tuple(
        camera.placed(
            RigidTransform(
                camera.pose.rotation @ world.rotation.T,
                camera.pose.translation
                - camera.pose.rotation @ world.rotation.T @ world.translation,
            )
        )
        for camera in RIG.cameras
    )
    rig = type(RIG)(cameras, RIG.names)
    points = twin_points(twin, measured(world, bias), rig, 1)
    assert len(points.material) == 295
    np.testing.assert_allclose(points.error, np.tile(bias, (295, 1)), atol=1e-5)
    figures = error_figures(points)
    assert figures["w"]["sum"] == pytest.approx(0.02, abs=1e-5)
    assert figures["E1"]["mean"] == pytest.approx(0.01, abs=1e-4)


def test_methods_are_compared_where_both_measured(twin):
    one = twin_points(twin, measured(RigidTransform.identity(), np.zeros(3)), RIG, 1)
    other = twin_points(twin, measured(RigidTransform.identity(), np.array([0, 0, 0.05])), RIG, 1)
    found = between_methods(other, one)
    assert found["w"]["mean"] == pytest.approx(0.05, abs=1e-6)
    assert found["u"]["largest"] < 1e-6
