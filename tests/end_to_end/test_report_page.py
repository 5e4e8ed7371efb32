"""The report of a measured run: its numbers, in a browser, and what the user adds."""

import json
from html.parser import HTMLParser
from shutil import copytree

import numpy as np
import pytest

from shapemorph.cli import main
from shapemorph.io.measurement_files import read_vtp
from tests.view.browser import CHROMIUM, Browser

LARGEST = 12e6
LONGEST = 2.0


class _Values(HTMLParser):
    """Keys and values that stand behind what a page shows."""

    def __init__(self, text):
        super().__init__()
        self.found = {}
        self.feed(text)

    def handle_starttag(self, tag, attrs):  # noqa: ARG002 (the name is that of the base)
        attributes = dict(attrs)
        if "data-key" in attributes:
            value = json.loads(attributes["data-value"])
            assert self.found.setdefault(attributes["data-key"], value) == value


def _leaves(section, path=""):
    for key, value in section.items():
        here = f"{path}/{key}" if path else key
        if isinstance(value, dict) and "median" not in value:
            yield from _leaves(value, here)
        else:
            yield here, value


def test_every_number_of_the_page_is_that_of_the_summary(measured):
    shown = _Values((measured / "report.html").read_text(encoding="utf-8")).found
    summary = json.loads((measured / "summary.json").read_text(encoding="utf-8"))
    del summary["verdict"]
    settings = {key for key in shown if key.startswith("config/")}
    assert {key: shown[key] for key in shown.keys() - settings} == dict(_leaves(summary))
    assert (measured / "report.html").stat().st_size < LARGEST


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_point_that_is_clicked_has_the_values_of_the_table(measured, tmp_path):
    measurement, _ = read_vtp(measured / "measurement.vtp")
    row = int(np.nanargmax(measurement.arrays["E1"]))
    page = (measured / "report.html").as_uri()
    with Browser(tmp_path / "profile") as browser:
        browser.call("Performance.enable", timeDomain="threadTicks")  # others may work here too
        browser.open(page)
        metrics = browser.call("Performance.getMetrics")["metrics"]
        (busy,) = [metric["value"] for metric in metrics if metric["name"] == "TaskDuration"]
        assert busy < LONGEST
        browser.run("document.getElementById('view').scrollIntoView()")
        browser.click(*browser.run(f"shapemorphViewer.place({row})"))
        browser.settle()
        shown = browser.run("document.getElementById('viewer-values').innerText")
        assert browser.complaints == []
        assert set(browser.requests) == {page}
    assert f"\t{row}\n" in shown
    strain = measurement.arrays["E1"][row]
    assert f"strain E₁\t{float(f'{strain:.4g}'):g}\n" in shown


def test_the_words_of_the_user_come_into_the_page_without_a_new_measurement(measured, tmp_path):
    run = tmp_path / "run"
    copytree(measured, run)
    stages = {p: p.stat().st_mtime_ns for p in run.glob("*/result.json")}
    words = ["--set", "report.equipment.camera=<b>Eye</b> & Co", "--set", "report.title=Test 7"]
    assert main(["run", str(run / "run.yaml"), "-o", str(run), *words, "--quiet"]) == 0
    assert {p: p.stat().st_mtime_ns for p in run.glob("*/result.json")} == stages
    text = (run / "report.html").read_text(encoding="utf-8")
    assert "<h1>Test 7</h1>" in text
    assert "&lt;b&gt;Eye&lt;/b&gt; &amp; Co" in text
    assert "<b>Eye" not in text


def test_a_noise_floor_that_is_none_is_refused_before_any_work(pair, tmp_path, capsys):
    (tmp_path / "noise.json").write_text("{}")
    words = ["measure", str(pair / "reference.obj"), str(pair / "deformed.obj")]
    noise = ["--set", f"report.noise={tmp_path / 'noise.json'}"]
    assert main([*words, "-o", str(tmp_path / "run"), *noise, "--quiet"]) == 3
    assert "expected the noise.json" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
