import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.methods.facet_strain import facet_strain, triangle_strain
from shapemorph.methods.principal import principal


def oblique_grid(rows: int, cols: int) -> np.ndarray:
    """Sheared, stretched, tilted grid: nothing square, nothing along an axis."""
    j, i = np.meshgrid(np.arange(cols), np.arange(rows))
    flat = np.stack([0.7 * j + 0.2 * i, 0.45 * i, np.zeros_like(i)], axis=-1)
    return flat @ Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix().T + [3, -2, 5]


def test_homogeneous_stretch_of_any_size_is_exact_on_every_facet():
    reference = oblique_grid(4, 6)
    rotation = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
    plane = np.array([[3.0, 0.4], [0.1, 0.2]])  # stretches from 15 % to 300 %
    change = rotation @ np.block([[plane, np.zeros((2, 1))], [0, 0, 1]]) @ rotation.T
    found = facet_strain(reference, reference @ change.T)
    expected = (plane.T @ plane - np.eye(2)) / 2
    # columns follow the first axis of the plane, so the basis of the facets is the plane's
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-12)


def test_rigid_motion_of_a_curved_surface_has_no_strain():
    grid = oblique_grid(5, 4)
    grid[..., 2] += np.sin(grid[..., 0])
    moved = grid @ Rotation.from_rotvec([2, 1, -1]).as_matrix().T + [100, -40, 7]
    np.testing.assert_allclose(facet_strain(grid, moved), 0, atol=1e-12)


def test_lost_point_costs_only_its_own_facets():
    reference = oblique_grid(5, 6)
    deformed = reference.copy()
    deformed[2, 3] = np.nan
    missing = np.isnan(facet_strain(reference, deformed)).any(axis=(-1, -2))
    expected = np.zeros((4, 5, 2), dtype=bool)
    expected[1, 2] = expected[2, 3] = True  # the diagonal through the point: both triangles
    expected[1, 3, 1] = True  # row 1, right of it: only the triangle along row 2
    expected[2, 2, 0] = True
    np.testing.assert_array_equal(missing, expected)


def test_facet_without_area_has_no_strain():
    reference = oblique_grid(3, 3)
    reference[1, 1] = reference[0, 1]
    found = facet_strain(reference, oblique_grid(3, 3))
    assert np.isnan(found[0, 0, 0]).any()  # corners (0,0) (0,1) (1,1): two coincide
    assert np.isfinite(found[0, 0, 1]).all()  # corners (0,0) (1,1) (1,0) do not


def test_triangles_of_finite_elements_have_their_stretches():
    rng = np.random.default_rng(8)
    nodes = rng.normal(size=(300, 3))
    faces = rng.integers(0, 300, size=(500, 3))
    faces = faces[(np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)]
    moved = nodes @ np.diag([4.0, 0.3, 1.5]) + 0.2 * rng.normal(size=nodes.shape)
    # oracle: shape functions of the linear triangle, F = sum of x_i grad N_i, singular values
    corners = nodes[faces]
    shape_gradients = np.linalg.pinv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    gradients = np.concatenate([-shape_gradients.sum(axis=1, keepdims=True), shape_gradients], 1)
    deformation = np.einsum("fki,fkj->fij", moved[faces], gradients)
    stretches = np.linalg.svd(deformation, compute_uv=False)[:, :2]
    found = principal(triangle_strain(nodes, moved, faces))[0]
    np.testing.assert_allclose(np.sqrt(1 + 2 * found), stretches, atol=1e-9, rtol=1e-9)
