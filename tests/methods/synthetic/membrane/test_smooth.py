import numpy as np

from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.smooth import fit_map, map_points


def test_a_bent_sheet_is_repeated_with_its_derivatives():
    material, _ = disc_mesh(20.0, 30)

    def place(at):
        x, y = at.T
        return np.column_stack([x + 0.01 * x * y, 1.2 * y, 0.02 * x**2 - 1e-3 * x * y**2])

    mapped = fit_map(material, place(material), spacing=2.0)
    at = np.random.default_rng(0).uniform(-12, 12, (200, 2))
    position, slope = map_points(mapped, at)
    np.testing.assert_allclose(position, place(at), atol=1e-4)
    step = 1e-5 * np.eye(2)
    for k in range(2):
        along = (place(at + step[k]) - place(at - step[k])) / 2e-5
        np.testing.assert_allclose(slope[..., k], along, atol=1e-3)


def test_a_disc_is_covered_once():
    points, faces = disc_mesh(3.0, 5)
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert len(faces) == 6 * 25
    assert area.min() > 0
    side = 0.5 * 30 * 9 * np.sin(2 * np.pi / 30)
    np.testing.assert_allclose(area.sum(), side, rtol=1e-12)
