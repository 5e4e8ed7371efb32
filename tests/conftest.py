"""Patterns that are known exactly at every point."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Pattern = Callable[[np.ndarray], np.ndarray]


@pytest.fixture(scope="session")
def wave_pattern() -> Callable[..., Pattern]:
    """Make a pattern: a sum of plane waves, grey 0.5 +- 0.15, finest details about `size` px."""

    def make(size: float = 5.0, seed: int = 0, waves: int = 120) -> Pattern:
        rng = np.random.default_rng(seed)
        vectors = rng.normal(0, 1.9 / size, size=(waves, 2)).clip(-4.5 / size, 4.5 / size)
        phase = rng.uniform(0, 2 * np.pi, waves)
        scale = 0.15 * np.sqrt(2 / waves)

        def at(points: np.ndarray) -> np.ndarray:
            grey = np.full(points.shape[:-1], 0.5)
            for (kx, ky), start in zip(vectors, phase, strict=True):
                grey += scale * np.cos(kx * points[..., 0] + ky * points[..., 1] + start)
            return grey

        return at

    return make


@pytest.fixture(scope="session")
def pixel_grid() -> Callable[[tuple[int, int]], np.ndarray]:
    """Positions (x, y) of all pixels of a picture of a given height and width."""

    def make(shape: tuple[int, int]) -> np.ndarray:
        rows, cols = np.mgrid[: shape[0], : shape[1]]
        return np.stack([cols, rows], axis=-1).astype(np.float64)

    return make


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Find a folder of real data that is not part of the repository, or skip."""
    default = Path(__file__).parents[1] / ".." / "shared" / "data"
    data = Path(os.environ.get("SHAPEMORPH_DATA", default))

    def find(name: str) -> Path:
        if not (data / name).is_dir():
            pytest.skip(f"{name} is not on this machine: set SHAPEMORPH_DATA to the folder of data")
        return data / name

    return find
