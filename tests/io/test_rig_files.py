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


def lines_of_matchid(separator):
    """Lay out as such programs do, some with a blank after the semicolon, no line end."""
    lens = ["Fx [pixels]", "Fy [pixels]", "Fs [pixels]", "Kappa 1", "Kappa 2", "Kappa 3"]
    lens += ["P1", "P2", "Cx [pixels]", "Cy [pixels]"]
    values = ([2900.0, 2901.0, 0, -0.2, 0.1, 0, 1e-4, -2e-4, 640, 400], [2950, 2951] + [0] * 8)
    lines = [
        f"Cam{number}_{name}{separator}{value}"
        for number, own in enumerate(values)
        for name, value in zip(lens, own, strict=True)
    ]
    turn = Rotation.from_euler("y", 15.0, degrees=True).as_matrix()
    shift = -turn @ np.array([187.0, 0.0, 0.0])  # the second camera stands 187 mm to the right
    place = [("Tx [mm]", shift[0]), ("Ty [mm]", shift[1]), ("Tz [mm]", shift[2])]
    place += [("Theta [deg]", 0.0), ("Phi [deg]", 15.0), ("Psi [deg]", 0.0)]
    return lines + [f"{name}{separator}{value}" for name, value in place]


@pytest.mark.parametrize("separator", [";", "; "])
def test_a_camera_of_matchid_beside_the_first_one_looks_back_at_what_it_sees(tmp_path, separator):
    """Its centre lies on the x axis of the first camera, and its own axis crosses that one's."""
    path = tmp_path / "stereo.caldat"
    path.write_text("\n".join(lines_of_matchid(separator)))
    rig = read_rig(path, SIZE)
    motion = rig.between(0, 1)
    np.testing.assert_allclose(-motion.rotation.T @ motion.translation, [187.0, 0, 0], atol=1e-9)
    looks = motion.rotation[2]
    np.testing.assert_allclose(looks, [-np.sin(np.pi / 12), 0, np.cos(np.pi / 12)], atol=1e-12)
    np.testing.assert_allclose(rig.cameras[0].centre, [640, 400])
    np.testing.assert_allclose(rig.cameras[0].tangential, [1e-4, -2e-4])
    np.testing.assert_allclose(rig.cameras[1].focal, [2950, 2951])


def test_angles_of_matchid_turn_about_x_then_y_then_z(tmp_path):
    lines = [*lines_of_matchid(";")[:-3], "Theta [deg];10", "Phi [deg];20", "Psi [deg];30"]
    (tmp_path / "a.caldat").write_text("\n".join(lines))
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.deg2rad([10, 20, 30])), np.sin(np.deg2rad([10, 20, 30]))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    found = read_rig(tmp_path / "a.caldat", SIZE).between(0, 1).rotation
    np.testing.assert_allclose(found, about_z @ about_y @ about_x, atol=1e-12)


def test_opencorr_goes_by_the_order_of_lines_not_by_their_names(tmp_path):
    rows = ["name,view 1,view 2", "focal x,2900,2950", "focal y,2901,2951", "skew,0.5,0"]
    rows += ["centre x,640,630", "centre y,400,390", *(f"radial {k},0,0" for k in range(6))]
    rows += ["p one,1e-4,0", "p two,-2e-4,0", "x,0,-187", "y,0,2", "z,0,30"]
    rows += ["angle,0,0.1", "angle,0,-0.2", "angle,0,0.3"]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    rig = read_rig(tmp_path / "a.csv", SIZE)
    np.testing.assert_allclose(rig.cameras[0].tangential, [1e-4, -2e-4])
    assert rig.cameras[0].skew == 0.5
    np.testing.assert_allclose(rig.cameras[1].centre, [630, 390])
    motion = rig.between(0, 1)
    np.testing.assert_allclose(motion.translation, [-187, 2, 30])
    expected = cv2.Rodrigues(np.array([0.1, -0.2, 0.3]))[0]
    np.testing.assert_allclose(motion.rotation, expected, atol=1e-12)


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
        ("a.csv", "x,left,right\nFx,1\n", "expected Fx as name,left,right"),
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
