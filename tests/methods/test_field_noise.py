import numpy as np
from scipy.ndimage import uniform_filter

from shapemorph.config import StrainConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.field_noise import (
    interpolated_noise,
    overlap_correlation,
    position_noise,
)
from shapemorph.stages.strain import strain

SPACING, SUBSET = 7, 20  # px
WIDTH = 15  # px, what counts of the subset


def averaged_noise(rng, rows, cols, sigma):
    """Errors at grid points that share the noise of overlapping subsets, (R, C, 2)."""
    height, width = rows * SPACING + WIDTH, cols * SPACING + WIDTH
    noise = uniform_filter(rng.normal(size=(height, width, 2)), (WIDTH, WIDTH, 1))
    start = WIDTH // 2
    down = slice(start, start + rows * SPACING, SPACING)
    right = slice(start, start + cols * SPACING, SPACING)
    return noise[down, right] * WIDTH * sigma


def test_overlap_correlation_is_that_of_averages_over_subsets():
    rng = np.random.default_rng(9)
    offsets = np.array([[0, 0], [1, 0], [1, 1], [2, 1], [3, 0]])
    expected = overlap_correlation(offsets, spacing=SPACING, subset_size=SUBSET)
    field = averaged_noise(rng, 120, 130, 1.0)[..., 0]
    shifted = [field[dy : 110 + dy, dx : 110 + dx].ravel() for dx, dy in offsets]
    np.testing.assert_allclose(np.corrcoef(shifted), expected, atol=0.04)  # 12 100 draws


def test_noise_of_position_adds_pictures_and_both_meshes_along_and_across():
    reference = np.array([[[0.1, 0.0], [0.0, 0.1], [0.0, 0.0]]])
    deformed = np.array([[[0.2, 0.0], [0.0, 0.0], [0.0, 0.1]]])
    gradient = np.array([[[1.5, 0.0], [0.0, 1.0]]])
    found = position_noise(
        (reference, deformed),
        gradient,
        np.array([[0.03, 0.05]]),
        np.array([[0.002, 0.003]]),
        np.array([0.007]),
    )
    matched = (0.2 * 0.03) ** 2 + (0.1 * 0.05) ** 2
    carried = (3.0**2 + 1.0**2) * 0.002**2  # the surface is stretched by 3 and by 1
    expected = np.sqrt((matched + carried + 2 * 0.003**2 + 0.007**2) / 3)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_interpolation_between_three_vertices_averages_their_noise():
    weights = np.array([[1.0, 0, 0], [0.5, 0.5, 0]])
    found = interpolated_noise(weights, vertex_noise=0.006)
    np.testing.assert_allclose(found, [0.006, 0.006 / np.sqrt(2)])


def stretched_sheet(error_px):
    """Sheet of 0.1 mm/px stretched by (2, 1.2) and sheared, matched with errors in px."""
    rows, cols = error_px.shape[:2]
    j, i = np.meshgrid(np.arange(cols), np.arange(rows))
    picture = np.stack([j, i], axis=-1) * float(SPACING)
    change = np.array([[2.0, 0.3], [0.0, 1.2]])
    deformed_px = picture @ change.T / 0.8 + error_px  # the deformed picture has 0.08 mm/px
    flat = np.zeros((rows, cols, 1))
    reference = np.concatenate([0.1 * picture, flat], axis=-1)
    deformed = np.concatenate([0.08 * deformed_px, flat], axis=-1)
    normal = np.zeros_like(reference)
    normal[..., 2] = 1
    status = np.zeros((rows, cols), dtype=np.uint8)
    sigma = np.full((rows, cols), 0.003)
    tracked = TrackedSurface(reference, deformed, normal, normal, sigma, status, np.zeros(2))
    return tracked, picture, deformed_px


def test_predicted_noise_of_strain_covers_two_thirds_of_the_errors():
    rng = np.random.default_rng(10)
    error = averaged_noise(rng, 50, 60, 1.0) * [0.04, 0.02]
    tracked, picture, deformed_px = stretched_sheet(error)
    shape = picture.shape[:2]
    grid = CorrelationGrid(
        picture,
        deformed_px,
        np.zeros((*shape, 2, 2)),
        np.ones(shape),
        np.ones(shape, dtype=np.int64),
        np.broadcast_to([0.04, 0.02], (*shape, 2)).copy(),
        tracked.status,
        SPACING,
        SUBSET,
        0.0,
    )
    field = strain(tracked, grid, StrainConfig())
    change = np.array([[2.0, 0.3], [0.0, 1.2]])
    true = (change.T @ change - np.eye(2)) / 2
    off = field.tensor - true
    components = np.stack([off[..., 0, 0], off[..., 1, 1], off[..., 0, 1]], axis=-1)
    within = (np.abs(components) <= field.sigma_tensor).mean(axis=(0, 1))
    # 3000 points in windows that overlap: some 200 independent draws, 3 % of scatter
    np.testing.assert_allclose(within, 0.683, atol=0.08)
    values = np.linalg.eigvalsh(true)
    np.testing.assert_allclose(
        (np.abs(field.e1 - values[1]) <= field.sigma_e1).mean(), 0.683, atol=0.08
    )
    np.testing.assert_allclose(
        (np.abs(field.e2 - values[0]) <= field.sigma_e2).mean(), 0.683, atol=0.08
    )
