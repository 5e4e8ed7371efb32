"""Sequences of pictures against exact truth."""

import csv
import json

import numpy as np
import pytest

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError, DataError, StageError
from shapemorph.io.frames import list_frames
from shapemorph.io.images import write_grey_png
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture
from shapemorph.pipeline.frames import correlate_frames

SHAPE = (150, 180)
CENTRE = np.array([90.0, 75.0])
FRAMES = 5
RIM = 20  # px; there subsets are cut off


def slope(frame):
    """Gradient of the motion since the first picture: 3 % a picture, sheared and turned."""
    return np.eye(2) + frame * np.array([[0.03, 0.004], [-0.006, -0.01]])


def shift(frame):
    return frame * np.array([2.3, -1.2])


def move(points, frame):
    return (points - CENTRE) @ slope(frame).T + CENTRE + shift(frame)


def picture(frame, mix=0.0, noise=0.5):
    back = np.linalg.inv(slope(frame))
    patterns = [planar_speckle(diameter=4.5, seed=seed) for seed in (1, 2)]

    class Mixed:
        def at(self, points):
            weights = np.cos(mix), np.sin(mix)
            return sum(w * p.at(points) for w, p in zip(weights, patterns, strict=True))

    exposure = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=noise, seed=frame)
    return take_picture(
        Mixed(), SHAPE, exposure,
        material_at=lambda p: (p - CENTRE - shift(frame)) @ back.T + CENTRE,
        inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    )  # fmt: skip


def write(folder, pictures):
    folder.mkdir(exist_ok=True)
    for number, each in enumerate(pictures):
        write_grey_png(folder / f"frame_{number}.png", each.grey, each.mask)
    return str(folder / "frame_*.png")


@pytest.fixture(scope="module")
def pattern(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    return write(folder, [picture(k) for k in range(FRAMES)])


@pytest.fixture(scope="module")
def fading(tmp_path_factory):
    """The pattern turns into another one: at the end nothing of the first is left."""
    folder = tmp_path_factory.mktemp("fading")
    return write(folder, [picture(k, mix=0.2 * k) for k in range(FRAMES)])


def run(pattern, folder, mask=None, **correlate):
    settings = {"subset_size": 21, "spacing": 8, **correlate}
    config = RunConfig.model_validate({"correlate": settings, "report": {"figures": False}})
    frames = list_frames(pattern)
    return correlate_frames(frames, folder, config, mask=mask, listener=lambda _: None)


def errors(folder, frame, rim=RIM):
    """(N, 2) errors of the points with a value, and the table; those at the rim left out."""
    with np.load(folder / f"frame_{frame}" / "correlation.npz") as arrays:
        table = dict(arrays)
    points = np.stack([table["x_px"], table["y_px"]], -1).astype(float)
    ok = (table["status"] == 0) & (np.abs(points - CENTRE) < CENTRE - rim).all(axis=1)
    points = points[ok]
    moved = points + np.stack([table["u_px"], table["v_px"]], -1)[ok]
    return moved - move(points, frame), table


@pytest.mark.parametrize("mode", ["first", "previous", "auto"])
def test_every_frame_refers_to_the_first_and_is_right(pattern, tmp_path, mode):
    outcome = run(pattern, tmp_path / "out", reference=mode)
    rows = outcome.summary["frames"]
    assert [row["frame"] for row in rows] == [f"frame_{k}" for k in range(1, FRAMES)]
    for frame in range(1, FRAMES):
        off, table = errors(tmp_path / "out", frame)
        assert rows[frame - 1]["ok_share"] > 0.8  # 5 px of motion and 9 % of stretch
        assert np.sqrt((off**2).mean()) < 0.013  # half a grey level of noise, four times
        assert np.abs(errors(tmp_path / "out", frame, rim=0)[0]).max() < 0.45
        green = (slope(frame).T @ slope(frame) - np.eye(2)) / 2
        assert np.nanmedian(table["E_xx"]) == pytest.approx(green[0, 0], abs=1e-3)
        assert np.nanmedian(table["E_xy"]) == pytest.approx(green[0, 1], abs=1e-3)
    names = [row["reference"] for row in rows]
    expected = [f"frame_{k - 1}" if mode == "previous" else "frame_0" for k in range(1, FRAMES)]
    assert names == expected


def test_drift_is_what_the_increments_have_added_up_to(pattern, tmp_path):
    drift = run(pattern, tmp_path / "out", reference="previous").summary["drift"]
    assert 0 < drift["rms_px"] < 0.03
    assert drift["points"] > 100
    assert run(pattern, tmp_path / "one", reference="first").summary["drift"] is None


def test_a_pattern_that_changes_makes_the_reference_move_on(fading, tmp_path):
    outcome = run(fading, tmp_path / "out", reference="auto")
    names = [row["reference"] for row in outcome.summary["frames"]]
    assert names[0] == "frame_0"
    assert names[-1] != "frame_0"
    assert outcome.summary["frames"][-1]["ok_share"] > 0.8
    off, _ = errors(tmp_path / "out", FRAMES - 1)
    assert np.sqrt((off**2).mean()) < 0.2  # a fifth of the pattern is new in each picture
    fixed = run(fading, tmp_path / "fixed", reference="first").summary["frames"][-1]
    assert fixed["ok_share"] < 0.5


def test_the_mask_of_the_first_picture_moves_along(pattern, tmp_path):
    mask = np.zeros(SHAPE, np.float32)
    mask[30:120, 30:140] = 1
    write_grey_png(tmp_path / "mask.png", mask, np.ones(SHAPE, bool))
    outcome = run(pattern, tmp_path / "out", tmp_path / "mask.png", reference="previous")
    off, table = errors(tmp_path / "out", FRAMES - 1, rim=0)
    assert table["x_px"].min() >= 30
    assert table["y_px"].max() < 120
    assert outcome.summary["frames"][-1]["ok_share"] > 0.95
    assert np.sqrt((off**2).mean()) < 0.03  # half subsets at the rim


def test_table_and_summary_say_the_same(pattern, tmp_path):
    run(pattern, tmp_path / "out")
    with (tmp_path / "out" / "frames.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert len(rows) == len(summary["frames"]) == FRAMES - 1
    for row, found in zip(rows, summary["frames"], strict=True):
        assert row["frame"] == found["frame"]
        assert float(row["u_median_px"]) == found["u_median_px"]
        own = json.loads((tmp_path / "out" / row["frame"] / "summary.json").read_text("utf-8"))
        assert own["points"]["ok"] == int(row["ok"])


def test_a_frame_without_the_pattern_is_a_row_with_its_reason(tmp_path):
    blank = picture(1)
    blank.grey[:] = 0.5
    pattern = write(tmp_path / "in", [picture(0), blank, picture(2)])
    rows = run(pattern, tmp_path / "out").summary["frames"]
    assert rows[0]["ok"] == 0
    assert "frame_1" in rows[0]["reason"]
    with np.load(tmp_path / "out" / "frame_1" / "correlation.npz") as table:
        assert np.isnan(table["u_px"]).all()
        assert set(table["status"]) == {2}
    off, _ = errors(tmp_path / "out", 2)
    assert np.sqrt((off**2).mean()) < 0.012


def test_nothing_in_any_frame_is_an_error_and_leaves_nothing(tmp_path):
    blank = picture(1)
    blank.grey[:] = 0.5
    pattern = write(tmp_path / "in", [picture(0), blank, blank])
    with pytest.raises(StageError, match="none of 2"):
        run(pattern, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_frame_of_another_size_is_named(tmp_path):
    pattern = write(tmp_path / "in", [picture(0), picture(1)])
    write_grey_png(
        tmp_path / "in" / "frame_9.png", np.zeros((20, 30), "f4"), np.ones((20, 30), bool)
    )
    with pytest.raises(DataError, match=r"frame_9\.png.*180 x 150 px.*30 x 20"):
        run(pattern, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_unreadable_frame_is_named(tmp_path):
    pattern = write(tmp_path / "in", [picture(0), picture(1)])
    (tmp_path / "in" / "frame_2.png").write_bytes(b"\x89PNG cut off")
    with pytest.raises(DataError, match=r"frame_2\.png"):
        run(pattern, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_region_that_leaves_nothing_is_refused(pattern, tmp_path):
    corners = [[500, 500], [600, 500], [600, 600]]
    config = RunConfig.model_validate({"inputs": {"region": {"polygon": corners}}})
    with pytest.raises(ConfigError, match=r"leave no pixel of .*frame_0\.png"):
        correlate_frames(
            list_frames(pattern), tmp_path / "out", config, mask=None, listener=lambda _: None
        )
