"""docs/stereo.md: its commands exist, its YAML is a rig, its pictures are there."""

import re
import shlex
from pathlib import Path

import pytest
import yaml

from shapemorph.cli.cameras import app
from shapemorph.config import RigConfig, TurnConfig
from shapemorph.io.config_files import check_config

PAGE = Path(__file__).parents[2] / "docs" / "stereo.md"
TEXT = PAGE.read_text(encoding="utf-8")
COMMANDS = [line for line in TEXT.splitlines() if line.startswith("shapemorph ")]


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_is_understood(line):
    words = shlex.split(line)[1:]
    command, arguments, _ = app.parse_args(words, exit_on_error=False, print_error=False)
    assert command.__name__ == words[0]
    assert arguments.args


def test_the_rig_files_are_read():
    whole, anchored, turned = (
        yaml.safe_load(block) for block in re.findall(r"^```yaml\n(.*?)^```", TEXT, re.S | re.M)
    )
    config = check_config(whole, RigConfig)
    assert config.targets["board"].spacing == 12.0
    solid = {"cylinder": {"kind": "points", "points": "dots.csv"}}
    config = check_config({**whole, "targets": solid, **anchored}, RigConfig)
    assert config.views[0].anchors["left"][0] == (20, 6, 1214, 446)
    assert check_config(turned, TurnConfig).patches == 21


def test_every_kind_of_target_is_explained():
    for kind in (
        RigConfig.model_fields["targets"]
        .annotation.__args__[1]
        .model_fields["kind"]
        .annotation.__args__
    ):
        assert f"`{kind}`" in TEXT


def test_its_pictures_are_there():
    names = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", TEXT)
    assert len(names) == 2
    for name in names:
        assert (PAGE.parent / name).stat().st_size > 10_000
