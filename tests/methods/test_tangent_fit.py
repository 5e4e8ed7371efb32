import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.methods.grid_windows import connected_windows
from shapemorph.methods.principal import principal
from shapemorph.methods.rim_cubics import PointNoise
from shapemorph.methods.tangent_fit import fit_tangent

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()


def sheet(rows: int, cols: int, spacing: float) -> np.ndarray:
    """Flat oblique grid (R, C, 2) around the origin."""
    j, i = np.meshgrid(np.arange(cols) - (cols - 1) / 2, np.arange(rows) - (rows - 1) / 2)
    return np.stack([j + 0.3 * i, 0.8 * i], axis=-1) * spacing


def lifted(flat: np.ndarray) -> np.ndarray:
    return np.concatenate([flat, np.zeros_like(flat[..., :1])], axis=-1)


def dome(flat: np.ndarray, radius: float) -> np.ndarray:
    """Disc whose points go to twice their distance from the pole, along a sphere."""
    distance = np.hypot(flat[..., 0], flat[..., 1])
    safe = np.where(distance > 0, distance, 1)
    outward = flat / safe[..., None] * (radius * np.sin(2 * distance / radius))[..., None]
    return np.concatenate([outward, radius * np.cos(2 * distance / radius)[..., None]], axis=-1)


def principal_strains(reference, deformed, usable=None, window=5, noise=None):
    """E1 and E2 of every grid point, (R, C, 2); noise: standard deviation of the positions."""
    rows, cols = reference.shape[:2]
    usable = np.ones((rows, cols), dtype=bool) if usable is None else usable
    j, i = np.meshgrid(np.arange(cols), np.arange(rows))
    picture = np.stack([j, i], axis=-1).reshape(-1, 2) * 8.0
    found = np.full((rows * cols, 2), np.nan)
    for windows in connected_windows(usable, window=window, chunk=500):
        errors = None
        if noise is not None:
            errors = PointNoise(np.full(rows * cols, noise), np.eye(len(windows.offsets)))
        fit = fit_tangent(
            reference.reshape(-1, 3), deformed.reshape(-1, 3), picture, windows, errors
        )
        metric = np.swapaxes(fit.gradient, 1, 2) @ fit.gradient
        found[windows.centres] = principal((metric - np.eye(2)) / 2)[0]
    return found.reshape(rows, cols, 2)


def test_homogeneous_stretch_is_exact_up_to_the_rim():
    flat = lifted(sheet(9, 12, 0.6)) @ TURN.T
    change = TURN @ np.diag([3.0, 0.2, 1.0]) @ TURN.T
    found = principal_strains(flat, flat @ change.T @ TURN)
    np.testing.assert_allclose(found[..., 0], (9 - 1) / 2, atol=1e-9)
    np.testing.assert_allclose(found[..., 1], (0.04 - 1) / 2, atol=1e-9)


def test_rigid_motion_of_a_curved_surface_gives_zero_to_rounding_up_to_the_rim():
    curved = dome(sheet(14, 11, 0.9), 12.0)
    found = principal_strains(curved, curved @ TURN.T + [100, -50, 20])
    np.testing.assert_allclose(found, 0, atol=1e-11)


def test_uniform_scaling_of_a_curved_surface_is_exact():
    curved = dome(sheet(14, 11, 0.9), 12.0)
    found = principal_strains(curved, 1.7 * curved)
    np.testing.assert_allclose(found, (1.7**2 - 1) / 2, atol=1e-9)


def rolled_error(spacing: float) -> float:
    """Largest error inside the rim of a sheet that is stretched by 2 and rolled up."""
    rows, cols = (round(size / spacing) + 1 for size in (8, 12))
    flat = sheet(rows, cols, spacing)
    angle = 2 * flat[..., 0] / 10
    rolled = np.stack([10 * np.sin(angle), flat[..., 1], 10 * np.cos(angle)], axis=-1)
    found = principal_strains(lifted(flat), rolled)[2:-2, 2:-2]
    return float(np.abs(found - [1.5, 0]).max())


def test_rolling_up_a_sheet_adds_next_to_no_strain_and_converges_with_fourth_order():
    errors = [rolled_error(spacing) for spacing in (1.0, 0.5, 0.25)]
    assert errors[0] < 1e-3  # a quadratic alone is off by 0.035 here
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12


def dome_error(spacing: float, noise: float | None = None) -> np.ndarray:
    rows, cols = (round(size / spacing) + 1 for size in (14, 18))
    flat = sheet(rows, cols, spacing)
    distance = np.hypot(flat[..., 0], flat[..., 1])
    safe = np.where(distance > 0, distance, 1)
    hoop = np.where(distance > 0, 22.5 / safe * np.sin(2 * distance / 22.5), 2.0)
    found = principal_strains(lifted(flat), dome(flat, 22.5), noise=noise)
    return np.abs(found - np.stack([np.full_like(hoop, 1.5), (hoop**2 - 1) / 2], axis=-1))


def test_dome_converges_with_second_order_up_to_the_rim():
    coarse, fine = (dome_error(spacing) for spacing in (1.0, 0.5))
    assert coarse[3:-3, 3:-3].max() < 0.006  # a quadratic alone is off by 0.035 here
    assert np.median(fine) < 1e-3
    assert coarse.max() / fine.max() > 3


def test_where_noise_is_known_the_rim_converges_with_third_order():
    plain, coarse, fine = dome_error(1.0), dome_error(1.0, noise=0.0), dome_error(0.5, noise=0.0)
    rims = [np.ones(each.shape[:2], dtype=bool) for each in (coarse, fine)]
    for rim in rims:
        rim[2:-2, 2:-2] = False
    assert coarse[rims[0]].max() < 0.3 * plain[rims[0]].max()
    assert coarse[rims[0]].max() / fine[rims[1]].max() > 7
    np.testing.assert_array_equal(coarse[~rims[0]], plain[~rims[0]])
    np.testing.assert_array_equal(dome_error(1.0, noise=10.0), plain)


def hole_error(step: float, noise: float | None) -> np.ndarray:
    """Errors beside a hole of radius 4 that opens: r to r + 3 / r, as sheets do."""
    flat = sheet(round(24 / step), round(24 / step), step)
    distance = np.hypot(flat[..., 0], flat[..., 1])
    usable = distance > 4
    far = np.where(usable, distance, 4.0)
    opened = lifted(flat * (1 + 3 / far**2)[..., None])
    stretches = np.stack([1 + 3 / far**2, 1 - 3 / far**2], axis=-1)
    found = principal_strains(lifted(flat), opened, usable, noise=noise)
    near = usable & (distance < 4.7)
    return np.abs(found - (stretches**2 - 1) / 2)[near]


def test_strain_that_rises_towards_a_hole_is_followed_to_its_rim():
    plain, found = hole_error(0.5, None), hole_error(0.5, 0.002)
    assert plain.max() > 0.02
    assert found.max() < 0.4 * plain.max()
    assert np.median(found) < 0.3 * np.median(plain)


def test_noise_costs_the_rim_little():
    flat = sheet(24, 24, 0.5)
    moved = lifted(flat) + np.random.default_rng(2).normal(scale=0.002, size=(24, 24, 3))
    plain = principal_strains(lifted(flat), moved)
    found = principal_strains(lifted(flat), moved, noise=0.002 * np.sqrt(2))
    rim = np.ones((24, 24), dtype=bool)
    rim[2:-2, 2:-2] = False
    assert found[rim].std() < 1.15 * plain[rim].std()
    np.testing.assert_array_equal(found[~rim], plain[~rim])


def test_flattening_a_dome_is_as_exact_as_forming_it():
    flat = sheet(19, 21, 0.5)
    found = principal_strains(dome(flat, 22.5), lifted(flat))
    np.testing.assert_allclose(found[3:-3, 3:-3, 1], (0.25 - 1) / 2, atol=2e-3)


def test_hole_and_slit_cost_no_neighbour_its_strain():
    flat = sheet(15, 18, 0.7)
    usable = np.ones(flat.shape[:2], dtype=bool)
    usable[5:9, 6:9] = False
    usable[12, :10] = False
    found = principal_strains(lifted(flat), lifted(flat) * [1.3, 1.3, 1], usable)
    np.testing.assert_array_equal(np.isfinite(found[..., 0]), usable)
    np.testing.assert_allclose(found[usable], (1.69 - 1) / 2, atol=1e-9)


def test_strip_two_points_wide_falls_back_to_a_plane_and_a_line_has_no_strain():
    flat = sheet(5, 12, 0.7)
    usable = np.zeros(flat.shape[:2], dtype=bool)
    usable[1:3] = True
    found = principal_strains(lifted(flat), 1.5 * lifted(flat), usable)
    np.testing.assert_allclose(found[usable], (2.25 - 1) / 2, atol=1e-9)
    usable[2] = False
    assert np.isnan(principal_strains(lifted(flat), 1.5 * lifted(flat), usable)).all()


def test_lonely_point_has_no_strain():
    usable = np.zeros((5, 5), dtype=bool)
    usable[2, 2] = True
    flat = lifted(sheet(5, 5, 1.0))
    assert np.isnan(principal_strains(flat, flat, usable)).all()


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_strain_does_not_depend_on_the_unit_of_length(unit):
    flat = sheet(9, 11, 1.0)
    expected = principal_strains(lifted(flat), dome(flat, 22.5))
    found = principal_strains(unit * lifted(flat), unit * dome(flat, 22.5))
    np.testing.assert_allclose(found, expected, atol=1e-10)


STRETCH_OF_SPACE = np.array([[1.8, 0.3, -0.2], [0.1, 0.7, 0.4], [-0.3, 0.2, 1.3]])


def cylinder(flat: np.ndarray, radius: float) -> np.ndarray:
    """Sheet rolled without strain, its first axis around."""
    angle = flat[..., 0] / radius
    around = radius * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    return np.stack([around[..., 0], flat[..., 1], around[..., 1]], axis=-1)


def strains_in_planes(normal: np.ndarray, change: np.ndarray) -> np.ndarray:
    """E1 and E2 of a homogeneous deformation in the planes with these normals, (R, C, 2)."""
    planes = np.linalg.svd(normal[..., None, :])[2][..., 1:, :]
    green = planes @ (change.T @ change - np.eye(3)) @ np.swapaxes(planes, -1, -2) / 2
    return np.linalg.eigvalsh(green)[..., ::-1]


def test_homogeneous_stretch_of_a_cylinder_is_exact_inside_its_rim():
    flat = sheet(12, 14, 0.8)
    flat[..., 0] -= 0.3 * flat[..., 1] / 0.8  # the grid's columns run around
    curved = cylinder(flat, 7.0)
    normal = curved * [1, 0, 1] / 7.0
    found = principal_strains(curved, curved @ STRETCH_OF_SPACE.T)
    expected = strains_in_planes(normal, STRETCH_OF_SPACE)
    np.testing.assert_allclose(found[2:-2, 2:-2], expected[2:-2, 2:-2], atol=1e-9)


def test_homogeneous_stretch_of_a_curved_surface_is_that_of_the_fitted_plane():
    errors = []
    for step in (1.0, 0.5):
        curved = dome(sheet(13, 15, 0.9 * step), 12.0) @ TURN.T
        found = principal_strains(curved, curved @ STRETCH_OF_SPACE.T)
        errors.append(np.abs(found - strains_in_planes(curved / 12.0, STRETCH_OF_SPACE)))
    assert errors[0][2:-2, 2:-2].max() < 1e-4  # with the terms of bending it is 0.02
    assert errors[0].max() / errors[1].max() > 3.5


@pytest.mark.parametrize("radius", [5.0, 20.0, 1e6])
def test_bending_a_bent_sheet_further_or_back_adds_next_to_no_strain(radius):
    errors = []
    for spacing in (1.0, 0.5):
        flat = sheet(12, 14, spacing)
        found = principal_strains(cylinder(flat, 10.0), cylinder(flat, radius))
        errors.append(np.abs(found[2:-2, 2:-2]).max())
    assert errors[0] < 3e-4
    assert errors[0] / errors[1] > 12


def test_noise_does_not_make_bending_a_stretch_of_space():
    flat = sheet(40, 40, 1.0)
    noise = np.random.default_rng(3).normal(scale=0.003, size=(2, *flat.shape[:2], 3))
    states = cylinder(flat, 6.0), cylinder(flat, 10.0)
    quiet = principal_strains(*states)
    found = principal_strains(*(state + part for state, part in zip(states, noise, strict=True)))
    mean = (found - quiet)[3:-3, 3:-3].sum(axis=2).mean()  # of E1 + E2: not biased by noise
    assert abs(mean) < 1e-4  # without the terms of bending it is 0.012
