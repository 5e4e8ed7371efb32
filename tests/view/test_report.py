import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.view.report import Contents, write_report


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.images, self.headings, self.texts, self._open = [], [], [], []
        self.values = []
        self._value = None

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.images.append(dict(attrs))
        self._open.append(tag)
        self._value = dict(attrs) if "data-key" in dict(attrs) else None

    def handle_data(self, data):
        if self._value:
            self.values.append((self._value["data-key"], self._value["data-value"], data))
            self._value = None
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
    write_report(Contents(results.summary, _figures(tmp_path), results.measurement), path)
    return path


def test_page_needs_nothing_from_outside(page):
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", text)
    assert "http:" not in text
    assert "https:" not in text
    assert "url(" not in text
    assert "@import" not in text


def test_text_of_the_summary_cannot_become_markup(page):
    text = page.read_text(encoding="utf-8")
    assert "4 % of the points were lost &lt;script&gt;" in text
    assert "lost <script>" not in text


def test_figures_stand_in_the_order_of_the_report_with_their_captions(page):
    parsed = _Page()
    parsed.feed(page.read_text(encoding="utf-8"))
    assert len(parsed.images) == 4
    assert "E₁" in parsed.images[0]["alt"]
    assert "E₂" in parsed.images[1]["alt"]
    assert parsed.images[3]["alt"] == "zebra"
    assert parsed.headings == [
        *("The measured shape", "Strain", "Can it be trusted?", "More figures", "All numbers")
    ]


def test_figures_of_a_group_are_shown_at_one_scale(tmp_path):
    figures = []
    for name, width in (("E1", 200), ("E2", 150), ("matches", 400)):
        figures.append(tmp_path / f"{name}.png")
        Image.fromarray(np.zeros((30, width, 3), dtype=np.uint8)).save(figures[-1])
    write_report(Contents({}, figures), tmp_path / "report.html")
    parsed = _Page()
    parsed.feed((tmp_path / "report.html").read_text(encoding="utf-8"))
    shares = [image["style"] for image in parsed.images]
    assert shares == ["--share: 1.0", "--share: 0.75", "--share: 1.0"]


def test_verdict_and_scorecard_stand_before_the_figures(page):
    text = page.read_text(encoding="utf-8")
    assert text.index(">WARN<") < text.index("<img")
    assert text.index("96 %") < text.index("<img")


def test_a_run_without_figures_or_verdict_still_has_a_page(tmp_path):
    write_report(Contents({"points": {"ok": 3}}, []), tmp_path / "report.html")
    assert "NO VERDICT" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_missing_figure_is_named(tmp_path):
    with pytest.raises(DataError, match=r"expected a figure at .*gone\.png"):
        write_report(Contents({}, [tmp_path / "gone.png"]), tmp_path / "report.html")


def _leaves(section, path=""):
    """Numbers, texts and lists of a summary with the keys that lead to them."""
    for key, value in section.items():
        here = f"{path}/{key}" if path else key
        if isinstance(value, dict) and "median" not in value:
            yield from _leaves(value, here)
        else:
            yield here, value


def test_every_number_is_that_of_the_summary(page, results):
    shown = _Page()
    shown.feed(page.read_text(encoding="utf-8"))
    exact = {key: json.loads(value) for key, value, _ in shown.values}
    wanted = dict(_leaves({k: v for k, v in results.summary.items() if k != "verdict"}))
    assert exact == wanted
    for key, value, text in shown.values:
        number = json.loads(value)
        if isinstance(number, int | float) and not isinstance(number, bool):
            read = float(text.removesuffix(" %")) / (100 if text.endswith("%") else 1)
            assert read == pytest.approx(number, rel=6e-4), key


def test_names_from_outside_cannot_become_markup(results, tmp_path):
    evil = "</script><img src=x onerror=alert(1)>{{ 7 * 7 }}'\""
    summary = {
        "verdict": {"level": "PASS", "reasons": [evil]},
        "scorecard": {evil: 1.0},
        "inputs": {"reference": {"name": evil}, "deformed": {"name": evil}},
        evil: {evil: evil},
        "config": {"report": {"title": evil}},
    }
    figure = tmp_path / "<b>.png"
    Image.fromarray(np.zeros((2, 2, 3), dtype=np.uint8)).save(figure)
    write_report(Contents(summary, [figure], results.measurement), tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    shown = _Page()
    shown.feed(text)
    assert "<img src=x" not in text
    assert [image["alt"] for image in shown.images] == ["<b>"]
    assert evil in shown.texts


def test_status_bars_count_every_point(tmp_path):
    statuses = {"OK": 90, "LOW_ZNCC": 10, "OUTSIDE_MASK": 4000}
    summary = {"points": {"total": 100, "ok": 90, "statuses": statuses}}
    write_report(Contents(summary, []), tmp_path / "report.html")
    shown = _Page()
    shown.feed((tmp_path / "report.html").read_text(encoding="utf-8"))
    bars = [value for value in shown.values if value[0] == "points/statuses/LOW_ZNCC"]
    assert {text for _, _, text in bars} == {"10"}
    assert "low ZNCC" in shown.texts
    assert "outside mask" not in shown.texts


def test_title_and_tables_of_good_practice(tmp_path):
    summary = {
        "good_practice": {"hardware": {"camera": "NOT PROVIDED", "lens": "35 mm"}},
        "config": {"report": {"title": "Bulge <7>"}},
    }
    write_report(Contents(summary, []), tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    shown = _Page()
    shown.feed(text)
    assert "<h1>Bulge &lt;7&gt;</h1>" in text
    assert ("good_practice/hardware/lens", '"35 mm"', "35 mm") in shown.values
    assert text.count('class="missing"') == 1
