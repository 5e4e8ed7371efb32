"""docs/steps.md and docs/stereo_sequences.md: their commands exist, their pictures are there."""

import re
import shlex
from pathlib import Path

import pytest

from shapemorph.cli.main import app

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {name: (DOCS / name).read_text(encoding="utf-8") for name in
         ("steps.md", "stereo_sequences.md")}  # fmt: skip
COMMANDS = sorted(
    {
        line.split("#")[0]
        for text in PAGES.values()
        for line in (*text.splitlines(), *re.findall(r"`(shapemorph [^`]* -o [A-Z]+)`", text))
        if line.startswith("shapemorph ")
    }
)


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_is_understood(line):
    words = shlex.split(line)[1:]
    _, arguments, _ = app.parse_args(words, exit_on_error=False, print_error=False)
    assert arguments.args


@pytest.mark.parametrize("page", PAGES)
def test_pictures_and_places_that_it_points_to_are_there(page):
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", PAGES[page])
    assert len(pictures) >= 6
    for name in pictures:
        assert (DOCS / name).stat().st_size > 10_000
    for name, place in re.findall(r"\]\(([a-z_]+\.md)#?([a-z-]*)\)", PAGES[page]):
        titles = re.findall(r"^#+ (.+)$", (DOCS / name).read_text(encoding="utf-8"), re.MULTILINE)
        assert not place or place in {title.lower().replace(" ", "-") for title in titles}
