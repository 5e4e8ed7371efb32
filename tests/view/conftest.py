"""An analytic run: a flat plate of 60 x 40 mm pushed into a lopsided bulge, turned and shifted."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation

from shapemorph.core.flattened import Distortion, FlattenedPair, FlattenedSurface
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.measurement import Measurement
from shapemorph.core.mesh import textured_mesh
from shapemorph.core.morphed import Morphed
from shapemorph.core.results import RunResults
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface

WIDTH, HEIGHT, PX_PER_MM = 60.0, 40.0, 10.0
TURN = Rotation.from_euler("xyz", [0.4, -0.3, 0.9])
SHIFT = np.array([5.0, -80.0, 12.0])


def _bulge(x, y):
    """Positions of the deformed plate in the reference frame, and d position / d (x, y)."""
    height = 16 * np.exp(-((x - 36) ** 2) / 250 - (y - 17) ** 2 / 130)
    slope_x, slope_y = -2 * (x - 36) / 250 * height, -2 * (y - 17) / 130 * height
    one, none = np.ones_like(x), np.zeros_like(x)
    position = np.stack([1.08 * x - 2, y, height], axis=-1)
    gradient = np.stack(
        [np.stack([1.08 * one, none, slope_x], -1), np.stack([none, one, slope_y], -1)], -1
    )
    return position, gradient


def _speckle():
    noise = gaussian_filter(np.random.default_rng(5).normal(size=(800, 1200)), 3.5)
    return np.clip(0.5 + noise / (4 * noise.std()), 0, 1).astype(np.float32)


def _plate(columns, rows):
    """Vertices (V, 2) in mm, y up, and triangles counter-clockwise seen from above."""
    x, y = np.meshgrid(np.linspace(0, WIDTH, columns), np.linspace(0, HEIGHT, rows))
    corner = np.arange(columns * rows).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
    return np.stack([x.ravel(), y.ravel()], axis=-1), faces


def _mesh(flat, faces, vertices, texture, name):
    uv = flat / [WIDTH, HEIGHT]
    return textured_mesh(
        vertices, faces, uv[faces], np.zeros(len(faces), dtype=np.int64), (texture,), name=name
    )


def _calibrated(flat, faces, texture, shape, scale):
    """Lay the plate flat with `scale` px per mm along x and y; row 0 is its far edge."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    u, v = columns / (scale[0] * WIDTH), 1 - rows / (scale[1] * HEIGHT)
    inside = (u <= 1) & (v >= 0)
    line = np.clip((1 - v) * (texture.shape[0] - 1), 0, None).astype(int)
    place = (u * (texture.shape[1] - 1)).astype(int)
    grey = texture[np.minimum(line, texture.shape[0] - 1), np.minimum(place, texture.shape[1] - 1)]
    cells = np.array([np.unique(flat[:, 0]).size - 1, np.unique(flat[:, 1]).size - 1])
    cell = (
        np.minimum((v * cells[1]).astype(int), cells[1] - 1) * cells[0]
        + np.minimum((u * cells[0]).astype(int), cells[0] - 1)
    )  # fmt: skip
    triangle = np.where(inside, 2 * cell, -1).astype(np.int32)
    vertex_px = np.stack([flat[:, 0] * scale[0], (HEIGHT - flat[:, 1]) * scale[1]], axis=-1)
    turned = faces[:, ::-1]
    chart = Chart(np.arange(len(flat)), turned, np.arange(len(faces)), vertex_px, PX_PER_MM)
    barycentric = np.where(inside[..., None], 0.3, np.nan) * np.ones((*shape, 2))
    return CalibratedImage(GreyImage(grey, inside), chart, triangle, barycentric)


def _surface(calibrated, sigma_1, sigma_2):
    area = np.full(len(sigma_1), 0.5)
    return FlattenedSurface(
        calibrated, Distortion(sigma_1, sigma_2, area), "bff", "one disk", 5.1, 0.51, 1.7
    )


def _pair(flat, faces, texture):
    middle = flat[faces].mean(axis=1)
    _, gradient = _bulge(middle[:, 0], middle[:, 1])
    stretch = np.linalg.svd(gradient, compute_uv=False)
    even = np.full(len(faces), PX_PER_MM)
    return FlattenedPair(
        _surface(_calibrated(flat, faces, texture, (405, 608), (10.0, 10.0)), even, even),
        _surface(
            _calibrated(flat, faces, texture, (446, 724), (12.0, 11.0)),
            12 / stretch[:, 1],
            11 / stretch[:, 0],
        ),
    )


def _status(x, y, lose):
    status = np.full(x.shape, PointStatus.OK, dtype=np.uint8)
    if lose:
        status[(x - 15) ** 2 + (y - 27) ** 2 < 16] = PointStatus.LOW_ZNCC
        status[(x > 50) & (y < 6)] = PointStatus.NOT_CONVERGED
        status[(x - 36) ** 2 + (y - 17) ** 2 < 2.5] = PointStatus.OUTLIER
    return status


def _grid(spacing, lose):
    columns = np.arange(spacing, WIDTH * PX_PER_MM, spacing)
    rows = np.arange(spacing, HEIGHT * PX_PER_MM, spacing)
    reference_px = np.stack(np.meshgrid(columns, rows), axis=-1)
    x, y = reference_px[..., 0] / PX_PER_MM, HEIGHT - reference_px[..., 1] / PX_PER_MM
    status = _status(x, y, lose)
    lost = status != PointStatus.OK
    deformed_px = np.where(lost[..., None], np.nan, reference_px * [1.2, 1.1])
    gradient = np.where(lost[..., None, None], np.nan, np.diag([1.2, 1.1]))
    zncc = np.where(lost, 0.4, 0.985 + 0.01 * np.sin(x / 7) * np.cos(y / 5))
    sigma = np.where(lost[..., None], np.nan, 0.02) * np.ones(2)
    iterations = np.full(status.shape, 4)
    grid = CorrelationGrid(
        reference_px, deformed_px, gradient, zncc, iterations, sigma, status,
        int(spacing), 25, 0.5,
    )  # fmt: skip
    return grid, x, y


def _tracked(grid, x, y):
    lost = (grid.status != PointStatus.OK)[..., None]
    position, _ = _bulge(x, y)
    reference = np.stack([x, y, np.zeros_like(x)], axis=-1)
    in_file = TURN.inv().apply((position - SHIFT).reshape(-1, 3)).reshape(position.shape)
    up = np.broadcast_to([0.0, 0.0, 1.0], reference.shape)
    return TrackedSurface(
        reference,
        np.where(lost, np.nan, in_file),
        up,
        np.where(lost, np.nan, up),
        np.where(lost[..., 0], np.nan, 0.007),
        grid.status,
        np.array([0.006, 0.006]),
    )


def _field(grid, x, y):
    _, gradient = _bulge(x, y)
    tensor = 0.5 * (np.swapaxes(gradient, -1, -2) @ gradient - np.eye(2))
    lost = grid.status != PointStatus.OK
    values, vectors = np.linalg.eigh(tensor)
    e2, e1 = (np.where(lost, np.nan, values[..., k]) for k in (0, 1))
    direction = np.concatenate([vectors[..., :, 1], np.zeros((*lost.shape, 1))], axis=-1)
    frames = np.broadcast_to(np.eye(3)[:2], (*lost.shape, 2, 3))
    sigma = np.where(lost, np.nan, 0.0012)
    rows, columns = lost.shape
    return StrainField(
        frames, frames, tensor, tensor, e1, e2, direction, direction,
        np.repeat(sigma[..., None], 3, axis=-1), sigma, sigma, sigma,
        np.zeros((rows - 1, columns - 1, 2, 2, 2)), 1.0, 5, 45.0, 4.5,
    )  # fmt: skip


def _measurement(tracked, grid, field):
    aligned = TURN.apply(tracked.deformed.reshape(-1, 3)) + SHIFT
    reference = tracked.reference.reshape(-1, 3)
    ids = np.arange(grid.status.size).reshape(grid.status.shape)
    cells = np.stack([ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:], ids[:-1, :-1]], -1).reshape(-1, 4)
    whole = (grid.status.ravel()[cells] == PointStatus.OK).all(axis=1)
    arrays = {
        "status": grid.status.ravel(),
        "chart": np.zeros(grid.status.size, dtype=np.int64),
        "reference_px": grid.reference_px.reshape(-1, 2),
        "deformed_position": tracked.deformed.reshape(-1, 3),
        "displacement": aligned - reference,
        "E1": field.e1.ravel(),
        "E2": field.e2.ravel(),
        "sigma_displacement": tracked.sigma_position.ravel(),
        "sigma_E1": field.sigma_e1.ravel(),
        "zncc": grid.zncc.ravel(),
    }
    return Measurement(reference, cells[whole], arrays)


def _identity_warp():
    y, x = np.mgrid[:8, :10]
    return Warp(np.stack([x, y], -1) * 100.0 - 100, np.array([-100.0, -100.0]), 100.0)


def _summary(grid):
    return {
        "verdict": {"level": "WARN", "reasons": ["4 % of the points were lost <script>"]},
        "scorecard": {"valid_share": 0.96, "zncc_median": 0.985, "E1_median": 0.31},
        "status": count_statuses(grid.status),
        "flatten": {"reference": {"flips": 0}, "deformed": {"flips": 0}},
        "seconds": {"flatten": 1.2, "match": 2.5},
        "versions": {"shapemorph": "0.1.0"},
    }


def make_results(spacing=8, lose=True, mesh_size=(61, 41)):
    """Put an analytic run together; a finer spacing gives more points."""
    texture = _speckle()
    flat, faces = _plate(*mesh_size)
    position, _ = _bulge(flat[:, 0], flat[:, 1])
    pair = _pair(flat, faces, texture)
    grid, x, y = _grid(spacing, lose)
    tracked, field = _tracked(grid, x, y), _field(grid, x, y)
    picked = np.random.default_rng(3).permutation(grid.status.size)[:400]
    source = grid.reference_px.reshape(-1, 2)[picked]
    matches = Matches(
        source, source * [1.2, 1.1], _identity_warp(), _identity_warp(),
        {"found": 900, "consistent": 400}, 0.03, 0.4, 0.0,
    )  # fmt: skip
    alignment = Alignment(
        TURN.as_matrix(), SHIFT, "points", 0.006, np.full(20, 0.006), 900, 0.2,
        np.arange(900), "The flange carried the fit.",
    )  # fmt: skip
    morphed = Morphed(pair.reference.calibrated.image, _identity_warp())
    return RunResults(
        pair=pair, matches=matches, morphed=morphed,
        grid=grid, tracked=tracked, alignment=alignment, field=field,
        measurement=_measurement(tracked, grid, field), summary=_summary(grid),
        reference_mesh=_mesh(
            flat, faces, np.concatenate([flat, np.zeros((len(flat), 1))], axis=1), texture, "before"
        ),
        deformed_mesh=_mesh(flat, faces, TURN.inv().apply(position - SHIFT), texture, "after"),
    )  # fmt: skip


@pytest.fixture(scope="session")
def results():
    """About 3700 points of the analytic run, some of them lost for various reasons."""
    return make_results()


@pytest.fixture(scope="session")
def scene():
    """The maker of analytic runs, for tests that need another size."""
    return SimpleNamespace(make=make_results)
