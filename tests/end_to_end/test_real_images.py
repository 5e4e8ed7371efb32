"""Public pictures with an exact field, and with the field of another program."""

import os
from pathlib import Path

import numpy as np
import pytest

from shapemorph.cli import main

pytestmark = pytest.mark.slow

DATA = Path(os.environ.get("SHAPEMORPH_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))


def folder(name):
    if not (DATA / name).is_dir():
        pytest.skip(f"{name} is not on this machine: set SHAPEMORPH_DATA to the folder of data")
    return DATA / name


def correlate(first, second, out, *settings):
    sets = [word for text in settings for word in ("--set", text)]
    words = ["correlate", str(first), str(second), "-o", str(out), *sets, "--no-figures", "--quiet"]
    assert main(words) == 0
    with np.load(out / "correlation.npz") as table:
        ok = table["status"] == 0
        return {name: table[name][ok] for name in table if table[name].shape == ok.shape}, ok.mean()


def test_a_sine_of_a_tenth_of_a_pixel_is_found_in_noise(tmp_path):
    data = folder("dic_challenge_14_sinusoid")
    exact = np.genfromtxt(
        data / "exact_x_uL1_exxL1_uL3_exxL3_uL5_exxL5.csv", delimiter=",", names=True
    )
    found, share = correlate(
        data / "Sample14_Reference.tif", data / "Sample14_L3_Amp0.1b.tif", tmp_path / "out",
        "correlate.subset_size=35", "correlate.spacing=16",
    )  # fmt: skip
    x = found["x_px"]
    off = found["u_px"] - exact["u_L3_px"][x]
    columns = np.array([off[x == each].mean() for each in np.unique(x)])
    assert share > 0.998
    assert np.sqrt((off**2).mean()) < 0.018  # noise of 3.5 levels on speckles of 9 px
    assert np.sqrt((columns**2).mean()) < 0.006
    assert abs(off.mean()) < 0.002


def test_a_plate_with_a_hole_agrees_with_another_program(tmp_path):
    data = folder("dic_challenge_12_oht_cfrp")
    lines = (data / "dice_gold" / "DICe_solution_11.txt").read_text("utf-8").splitlines()
    peer = np.array([line.split(",")[:4] for line in lines if line[:1].isdigit()], dtype=float)
    pictures = [data / "images" / f"oht_cfrp_{number}.tiff" for number in ("00", "11")]
    settings = (
        "correlate.subset_size=27",
        "correlate.spacing=7",
        "inputs.region.polygon=[[38.5, 28.5], [351.5, 28.5], [351.5, 1005.5], [38.5, 1005.5]]",
    )
    found, _ = correlate(*pictures, tmp_path / "out", *settings)
    place = np.stack([found["x_px"], found["y_px"]], axis=-1)
    away = peer[:, None, :2] - place
    nearest = np.abs(away).max(axis=-1).argmin(axis=1)
    step = away[np.arange(len(peer)), nearest]
    assert np.abs(step).max() <= 3  # every point of theirs is there
    slope = np.stack([found[n][nearest] for n in ("du_dx", "du_dy", "dv_dx", "dv_dy")], -1)
    moved = np.stack([found["u_px"], found["v_px"]], axis=-1)[nearest]
    moved = moved + np.einsum("nij,nj->ni", slope.reshape(-1, 2, 2), step)
    off = moved - peer[:, 2:]
    assert np.sqrt((off**2).mean()) < 0.01
    assert np.abs(off).max() < 0.06
