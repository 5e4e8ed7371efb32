import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.view.report import write_report

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.images, self.headings, self.texts, self._open = [], [], [], []

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.images.append(dict(attrs))
        self._open.append(tag)

    def handle_data(self, data):
        if data.strip():
            (self.headings if self._open[-1] == "h2" else self.texts).append(data.strip())


def _figures(folder):
    paths = []
    for name in ("zebra", "matches", "E2", "E1"):
        paths.append(folder / f"{name}.png")
        Image.fromarray(np.full((30, 50, 3), 90, dtype=np.uint8)).save(paths[-1])
    return paths


@pytest.fixture
def page(results, tmp_path):
    path = tmp_path / "report.html"
    write_report(results.summary, _figures(tmp_path), path)
    return path


def test_page_needs_nothing_from_outside(page):
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)=["'](?!data:)""", text)
    assert "http:" not in text
    assert "https:" not in text
    assert "<script" not in text


def test_text_of_the_summary_cannot_become_markup(page):
    text = page.read_text(encoding="utf-8")
    assert "4 % of the points were lost &lt;script&gt;" in text


def test_figures_stand_in_the_order_of_the_report_with_their_captions(page):
    parsed = _Page()
    parsed.feed(page.read_text(encoding="utf-8"))
    assert len(parsed.images) == 4
    assert "E₁" in parsed.images[0]["alt"]
    assert "E₂" in parsed.images[1]["alt"]
    assert parsed.images[3]["alt"] == "zebra"
    assert parsed.headings == ["Strain", "Can it be trusted?", "More figures", "All numbers"]


def test_verdict_and_scorecard_stand_before_the_figures(page):
    text = page.read_text(encoding="utf-8")
    assert text.index(">WARN<") < text.index("<img")
    assert text.index("96 %") < text.index("<img")


def test_a_run_without_figures_or_verdict_still_has_a_page(tmp_path):
    write_report({"points": {"ok": 3}}, [], tmp_path / "report.html")
    assert "NO VERDICT" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_missing_figure_is_named(tmp_path):
    with pytest.raises(DataError, match=r"expected a figure at .*gone\.png"):
        write_report({}, [tmp_path / "gone.png"], tmp_path / "report.html")


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_browser_shows_the_page_offline(page, tmp_path):
    shot = tmp_path / "shot.png"
    subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--disable-sync",
            f"--user-data-dir={tmp_path / 'profile'}", f"--screenshot={shot}",
            "--window-size=800,1600", page.as_uri(),
        ],
        check=True, capture_output=True, timeout=60,
    )  # fmt: skip
    pixels = np.asarray(Image.open(shot).convert("RGB")).astype(int)
    assert ((pixels == 90).all(axis=-1)).sum() >= 4 * 30 * 50 * 0.95  # all four pictures
