"""Assessments of pictures with a known pattern, noise and motion."""

import numpy as np
import pytest

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.images import write_grey_png
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture
from shapemorph.pipeline.assess import assess

SHAPE = (161, 420)
PERIODS, AMPLITUDE, ROW = (20.0, 150.0), 0.3, 77


def move(points):
    """Material point that a pixel of the star pattern shows."""
    x, y = np.moveaxis(points, -1, 0)
    period = PERIODS[0] + (PERIODS[1] - PERIODS[0]) * x / (SHAPE[1] - 1)
    found = y.copy()
    for _ in range(60):
        found = y - AMPLITUDE * np.cos(2 * np.pi * (found - ROW) / period)
    return np.stack([x, found], axis=-1)


def write(path, seed, material_at=lambda p: p, noise=1.0):
    exposure = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=noise, seed=seed, blur=0.8)
    picture = take_picture(
        planar_speckle(diameter=4.0, seed=9), SHAPE, exposure,
        material_at=material_at, inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    )  # fmt: skip
    write_grey_png(path, picture.grey, picture.mask)
    return path


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("star")
    return (
        write(folder / "a.png", 1),
        write(folder / "star.png", 2, move),
        write(folder / "still.png", 3),
    )


def test_a_repeated_picture_gives_the_noise(pictures):
    found = assess(pictures[0], pictures[2], None, RunConfig())
    assert found["grey_noise"] == pytest.approx(np.hypot(1.0, 1 / np.sqrt(12)), rel=0.08)
    assert "difference" in found["grey_noise_source"]
    alone = assess(pictures[0], None, None, RunConfig())
    assert "rather too high" in alone["grey_noise_source"]
    figures = alone["reference"]
    assert figures["speckle_px"] == pytest.approx(4.6, abs=1.0)
    assert figures["subset_size_px"] % 2 == 1
    assert 0 < found["reference"]["predicted_sigma_u_px"] < 0.01
    assert not found["advice"]


def test_the_resolution_of_a_star_is_that_of_the_shape_function_or_better(pictures):
    star = {"periods": PERIODS, "amplitude": AMPLITUDE, "row": ROW}
    config = RunConfig.model_validate(
        {"assess": {"star": star}, "correlate": {"subset_size": 15, "spacing": 5}}
    )
    found = assess(*pictures, config)["star"]
    # a mean over 15 rows keeps sin(pi 15 / l) / (15 sin(pi / l)): nine tenths at 59.8 px;
    # what the morph takes of the field, the subsets need not follow
    assert 20.0 < found["resolution_px"] < 1.1 * 59.8
    assert 0.001 < found["sigma_px"] < 0.02
    assert found["mei_px2"] == pytest.approx(found["sigma_px"] * found["resolution_px"])
    assert "static" in found["sigma_source"]
    predicted = assess(pictures[0], pictures[1], None, config)["star"]["sigma_px"]
    assert 0.3 < predicted / found["sigma_px"] < 5


def test_a_coarse_faint_picture_gets_advice(tmp_path):
    exposure = Exposure(gain=0.1, offset=0.0, slope=0.0, noise=2.0, seed=1)
    picture = take_picture(
        planar_speckle(diameter=14.0, seed=9), (300, 300), exposure,
        material_at=lambda p: p, inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    )  # fmt: skip
    write_grey_png(tmp_path / "coarse.png", picture.grey, picture.mask)
    advice = " ".join(assess(tmp_path / "coarse.png", None, None, RunConfig())["advice"])
    assert "finer pattern" in advice
    assert "contrast" in advice


def test_a_star_needs_its_second_picture(pictures):
    config = RunConfig.model_validate({"assess": {"star": {"periods": PERIODS}}})
    with pytest.raises(ConfigError, match="needs two pictures"):
        assess(pictures[0], None, None, config)
    with pytest.raises(ConfigError, match=r"assess\.star\.periods"):
        assess(pictures[0], pictures[1], pictures[2], RunConfig())
