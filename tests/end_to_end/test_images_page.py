"""docs/images.md: every command on the page runs, on small pictures."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from shapemorph.cli import main
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[2] / "docs" / "images.md"
TEXT = PAGE.read_text(encoding="utf-8")
SHAPE = (160, 200)


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)


COMMANDS = [line for line in TEXT.splitlines() if line.startswith("shapemorph ")]


def picture(seed, material_at):
    exposure = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=0.5, seed=seed, blur=0.8)
    grey = take_picture(
        planar_speckle(diameter=4.5, seed=4), SHAPE, exposure,
        material_at=material_at, inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    ).grey  # fmt: skip
    return Image.fromarray(np.rint(255 * grey).astype(np.uint8))


def star(points):
    x, y = np.moveaxis(points, -1, 0)
    period = 10 + 140 * x / (SHAPE[1] - 1)
    found = y.copy()
    for _ in range(60):
        found = y - 0.5 * np.cos(2 * np.pi * (found - 79.5) / period)
    return np.stack([x, found], axis=-1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with everything that the page names."""
    folder = tmp_path_factory.mktemp("page")
    still = [picture(seed, lambda p: p) for seed in (1, 2, 3)]
    moved = [picture(9 + k, lambda p, k=k: p * (1 - 0.01 * k) - 0.7 * k) for k in range(3)]
    still[0].save(folder / "before.png")
    still[1].save(folder / "again.png")
    moved[1].save(folder / "after.png")
    mask = np.zeros(SHAPE, dtype=np.uint8)
    mask[20:140, 20:180] = 255
    Image.fromarray(mask).save(folder / "mask.png")
    (folder / "frames").mkdir()
    for k, each in enumerate(moved):
        each.save(folder / "frames" / f"frame_{k}.png")
    pages = [each.copy() for each in moved]
    pages[0].save(folder / "stack.tif", save_all=True, append_images=pages[1:])
    still[0].save(folder / "star_reference.png")
    picture(5, star).save(folder / "star_deformed.png")
    still[2].save(folder / "star_noise.png")
    (folder / "field.yaml").write_text(blocks("yaml")[0], encoding="utf-8")
    return folder


def test_the_page_has_commands_of_all_three_kinds():
    assert {shlex.split(command)[1] for command in COMMANDS} == {"correlate", "assess", "morph"}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_of_the_page_runs(folder, monkeypatch, capsys, command):
    monkeypatch.chdir(folder)
    words = shlex.split(command)[1:]
    assert main([*words, "--quiet"]) == 0, capsys.readouterr().err
    if "-o" in words:
        assert (folder / words[words.index("-o") + 1] / "summary.json").is_file()
