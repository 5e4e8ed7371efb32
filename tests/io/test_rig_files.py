import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.calibration import CameraUncertainty
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform
from shapemorph.io.rig_files import FILES, read_rig, read_uncertainty, write_exports, write_rig

SIZE = (1280, 800)


@pytest.fixture
def rig():
    turn = Rotation.from_euler("xyz", [1.5, -18.0, 0.7], degrees=True).as_matrix()
    left = Camera(
        SIZE,
        np.array([2468.5, 2468.2]),
        np.array([638.9, 407.3]),
        radial=np.array([-0.2, 0.06, 0.4]),
        skew=0.17,
    )
    right = Camera(
        SIZE,
        np.array([2377.1, 2376.9]),
        np.array([628.6, 394.6]),
        radial=np.array([-0.1, 0.05, -0.3]),
        skew=-0.09,
        pose=RigidTransform(turn, np.array([128.0, -0.9, 15.3])),
    )
    return Rig((left, right), ("left", "right"))


def same(one, other, tolerance=1e-9):
    for a, b in zip(one.cameras, other.cameras, strict=True):
        assert a.size == b.size
        for name in ("focal", "centre", "radial", "tangential", "skew"):
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), atol=tolerance)
        np.testing.assert_allclose(a.pose.rotation, b.pose.rotation, atol=tolerance)
        np.testing.assert_allclose(a.pose.translation, b.pose.translation, atol=1e-7)


@pytest.mark.parametrize("name", FILES)
def test_what_is_exported_is_read_back(rig, tmp_path, name):
    write_exports(tmp_path, rig)
    same(read_rig(tmp_path / name, SIZE), rig)


def test_own_file_keeps_standard_deviations(rig, tmp_path):
    sigma = CameraUncertainty(
        np.ones(2), np.full(2, 0.5), np.full(3, 0.1), np.zeros(2), 0.0, np.full(3, 1e-4), np.ones(3)
    )
    write_rig(tmp_path / "calibration.json", rig, (sigma, sigma))
    same(read_rig(tmp_path / "calibration.json", (1, 1)), rig)
    found = read_uncertainty(tmp_path / "calibration.json")
    assert len(found) == 2
    np.testing.assert_array_equal(found[1].rotation, sigma.rotation)


def test_opencv_reads_its_own_format(rig, tmp_path):
    write_exports(tmp_path, rig)
    storage = cv2.FileStorage(str(tmp_path / "opencv.yml"), cv2.FILE_STORAGE_READ)
    np.testing.assert_allclose(storage.getNode("cameraMatrix2").mat(), rig.cameras[1].matrix)
    np.testing.assert_allclose(storage.getNode("R").mat(), rig.between(0, 1).rotation)
    np.testing.assert_allclose(storage.getNode("T").mat()[:, 0], rig.between(0, 1).translation)


def test_what_opencv_writes_is_read(rig, tmp_path):
    path = tmp_path / "stereo.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for number, camera in enumerate(rig.cameras, start=1):
        (k1, k2, k3), (p1, p2) = camera.radial, camera.tangential
        storage.write(f"cameraMatrix{number}", camera.matrix)
        storage.write(f"distCoeffs{number}", np.array([[k1, k2, p1, p2, k3]]))
    storage.write("R", rig.between(0, 1).rotation)
    storage.write("T", rig.between(0, 1).translation[:, None])
    storage.release()
    same(read_rig(path, SIZE), rig)


def test_the_convention_of_vic3d_is_that_of_its_own_points(shared_data):
    """Start points of the project file itself lie on the epipolar lines of its cameras."""
    from shapemorph.methods.cameras.triangulation import triangulate

    rig = read_rig(shared_data("dice_stereo_static") / "cal.xml", SIZE)
    left = np.array([[456.0, 121.0], [544.0, 369.0], [609.0, 326.0], [611.0, 242.0]])
    right = np.array([[516.716, 104.7], [571.169, 350.874], [648.066, 309.293], [637.642, 227.563]])
    found = triangulate(rig.cameras, np.stack([left, right]), np.ones((2, 4, 2)))
    assert found.epipolar_error.max() < 0.1
    assert rig.baseline(0, 1) == pytest.approx(131.874, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.json", "{}", "expected .format."),
        ("a.json", "no", "is no calibration"),
        ("a.yml", "%YAML:1.0\n", "cameraMatrix1 is missing"),
        ("a.xml", "<project/>", "two <camera>"),
        ("a.xml", "nothing", "is not XML"),
        ("a.caldat", "Cam0_Fx;1\n", "Cam0_Fx and Cam1_Fx"),
        ("a.csv", "x,left,right\nFx,1,2\n", "Fy is missing"),
        ("a.mat", "", "ends in .json, .yml"),
    ],
)
def test_says_what_is_wrong_with_a_file(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(DataError, match=message):
        read_rig(tmp_path / name, SIZE)


def test_a_missing_file(tmp_path):
    with pytest.raises(DataError, match="does not exist"):
        read_rig(tmp_path / "a.json", SIZE)
