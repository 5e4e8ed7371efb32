import numpy as np
import pytest

from shapemorph.config import StrainConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.mid_surface import mid_metric
from shapemorph.stages.strain import strain

THICKNESS, RADIUS = 1.35, 22.5


def flat_grid():
    j, i = np.meshgrid(np.arange(31) - 15, np.arange(29) - 14)
    return np.stack([j + 0.2 * i, 0.9 * i], axis=-1) * 0.55


def dome(flat, outward):
    """Skin of a sheet whose middle goes to a hemisphere, every meridian stretched by 2."""
    distance = np.hypot(flat[..., 0], flat[..., 1])
    safe = np.where(distance > 0, distance, 1)
    hoop = np.where(distance > 0, RADIUS / safe * np.sin(2 * distance / RADIUS), 2.0)
    along = flat / safe[..., None] * np.sin(2 * distance / RADIUS)[..., None]
    normal = np.concatenate([along, np.cos(2 * distance / RADIUS)[..., None]], axis=-1)
    thickness = THICKNESS / (2 * hoop)
    skin = normal * (RADIUS + outward * thickness / 2)[..., None]
    return skin, normal, hoop


HEIGHT = 0.006  # mm, noise


def measured(surface, turned=1.0, noise=None):
    """Strain from a skin, for meshes whose normals point outwards, or inwards (-1)."""
    flat = flat_grid()
    outward = {"outer": 1.0, "inner": -1.0}[surface] * turned
    skin, normal, hoop = dome(flat, outward)
    shape = flat.shape[:2]
    known = {}
    if noise is not None:
        skin = skin + normal * noise.normal(scale=HEIGHT, size=(*shape, 1))
        known = {"sigma_heights": np.broadcast_to([0.0, HEIGHT], (*shape, 2))}
    up = np.broadcast_to([0.0, 0, 1], normal.shape)
    status = np.zeros(shape, dtype=np.uint8)
    tracked = TrackedSurface(
        np.concatenate([flat, np.full((*shape, 1), outward * THICKNESS / 2)], axis=-1),
        skin,
        up * turned,
        normal * turned,
        np.full(shape, 0.004),
        status,
        np.zeros(2),
        **known,
    )
    picture = np.stack(np.meshgrid(np.arange(31), np.arange(29)), axis=-1) * 5.0
    grid = CorrelationGrid(
        picture, picture * 2, np.broadcast_to(2 * np.eye(2), (*shape, 2, 2)), np.ones(shape),
        np.ones(shape, dtype=np.int64), np.full(picture.shape, 1e-4), status, 5, 19, 0.0,
    )  # fmt: skip
    skinned = strain(tracked, grid, StrainConfig(thickness=THICKNESS, surface=surface))
    bare = strain(tracked, grid, StrainConfig())
    return skinned, bare, hoop


@pytest.mark.parametrize("turned", [1.0, -1.0])
@pytest.mark.parametrize("surface", ["outer", "inner"])
def test_strain_of_the_middle_of_a_dome_follows_from_either_skin(surface, turned):
    found, bare, hoop = measured(surface, turned)
    inner = (slice(3, -3), slice(3, -3))
    expected = np.stack([np.full_like(hoop, 1.5), (hoop**2 - 1) / 2])
    errors = np.abs(np.stack([found.e1, found.e2]) - expected)[:, *inner]
    off = np.abs(np.stack([bare.e1, bare.e2]) - expected)[:, *inner]
    assert np.median(off[0]) > 0.03  # what the skin itself says
    assert errors.max() < 0.006
    assert np.median(errors) < 0.002


def test_a_sheet_that_only_bends_has_no_strain_in_its_middle():
    outer = (1 + THICKNESS / 2 / 10) ** 2
    metric = np.array([np.diag([outer, 1.0])])
    bends = np.stack([np.zeros((1, 2, 2)), [np.diag([-outer / (10 + THICKNESS / 2), 0.0])]], axis=1)
    found, offsets = mid_metric(metric, bends, np.array([[-1.0, -1.0]]), thickness=THICKNESS)
    np.testing.assert_allclose(found[0], np.eye(2), atol=1e-9)
    np.testing.assert_allclose(offsets[0], -THICKNESS / 2)


def test_noise_of_the_curvatures_reaches_the_strain_as_predicted():
    rng = np.random.default_rng(7)
    inner = (slice(5, -5), slice(5, -5))

    def carried(noise):
        found, bare, _ = measured("outer", noise=noise)
        variance = (found.sigma_tensor**2 - bare.sigma_tensor**2)[*inner, :2]
        return (found.tensor - bare.tensor)[*inner], np.sqrt(np.median(variance, axis=(0, 1)))

    clean, _ = carried(None)
    draws = [carried(rng) for _ in range(3)]
    errors = np.stack([tensor - clean for tensor, _ in draws])
    scatter = np.sqrt(np.mean(errors[..., [0, 1], [0, 1]] ** 2, axis=(0, 1, 2)))
    np.testing.assert_allclose(draws[0][1], scatter, rtol=0.25)  # windows of 81 points overlap


def test_a_skin_needs_a_thickness():
    with pytest.raises(ValueError, match="thickness"):
        StrainConfig(surface="outer")
