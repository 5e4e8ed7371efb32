import base64

import numpy as np
import pytest

from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.view.measures import MEASURES, measure_values
from shapemorph.view.report import Contents, write_report
from shapemorph.view.style import STATUS_COLOURS, colour_scale
from shapemorph.view.viewer import MOST_QUADS, viewer_data
from tests.view.browser import CHROMIUM, Browser

SHOW = "document.getElementById('view').scrollIntoView()"

in_browser = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


def _array(data, name):
    place = data.about["arrays"][name]
    content = base64.b64decode(data.content)
    kind = np.dtype(f"<{place['kind']}")
    return np.frombuffer(content, kind, place["count"], place["offset"])


def test_arrays_come_back_as_they_were(results):
    data = viewer_data(results.measurement)
    rows, shown = _array(data, "row"), data.about["shown"]
    arrays = results.measurement.arrays
    np.testing.assert_array_equal(_array(data, "value E1"), np.float32(arrays["E1"][rows]))
    np.testing.assert_array_equal(
        _array(data, "displacement").reshape(-1, 3), np.float32(arrays["displacement"][rows])
    )
    quads = _array(data, "quads").reshape(-1, 4)
    np.testing.assert_array_equal(rows[quads], results.measurement.cells)
    status = _array(data, "status")
    assert (status[:shown] == PointStatus.OK).all()
    assert (status[shown:] != PointStatus.OK).all()
    assert np.count_nonzero(arrays["status"]) == len(rows) - shown


def test_ranges_and_maps_are_those_of_the_pictures(results):
    fields = {field["key"]: field for field in viewer_data(results.measurement).about["fields"]}
    for measure in MEASURES:
        scale = colour_scale(measure_values(results.measurement, measure))
        assert fields[measure.key]["range"] == [scale.low, scale.high]
        assert fields[measure.key]["map"] == scale.name


def test_a_large_surface_is_thinned_and_stays_small(scene):
    measurement = scene.make(spacing=1.6, lose=False, mesh_size=(7, 5)).measurement
    assert len(measurement.cells) > 2 * MOST_QUADS
    data = viewer_data(measurement)
    assert data.about["arrays"]["quads"]["count"] <= 4 * MOST_QUADS
    assert len(data.content) < 4e6
    assert data.about["is_thinned"]


def test_charts_whose_pictures_lie_at_one_place_are_thinned_apart(scene):
    one = scene.make(spacing=2.4, lose=False, mesh_size=(7, 5)).measurement
    number = len(one.reference)
    arrays = {name: np.concatenate([values, values]) for name, values in one.arrays.items()}
    arrays["chart"] = np.repeat([0, 1], number)
    twice = Measurement(
        np.concatenate([one.reference, one.reference + np.array([0, 0, 9])]),
        np.concatenate([one.cells[: MOST_QUADS // 2], one.cells[3:] + number]),
        arrays,
    )
    data = viewer_data(twice)
    assert data.about["is_thinned"]
    rows = _array(data, "row")[_array(data, "quads").reshape(-1, 4)]
    assert rows.max() < 2 * number
    chart = arrays["chart"][rows]
    assert (chart == chart[:, :1]).all()


def test_without_quads_there_is_no_view(results):
    measurement = results.measurement
    none = np.zeros((0, 4), dtype=np.int64)
    assert viewer_data(Measurement(measurement.reference, none, measurement.arrays)) is None


@pytest.fixture(scope="module")
def page(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(Contents(results.summary, [], results.measurement), path)
    return path


@pytest.fixture(scope="module")
def browser(page, tmp_path_factory):
    """The page, opened; every test leaves the view as it was."""
    with Browser(tmp_path_factory.mktemp("profile")) as opened:
        opened.open(page.as_uri())
        opened.run(SHOW)
        yield opened


def _near(measurement, x, y):
    """Row of a good point near a place on the plate, mm."""
    away = np.hypot(*(measurement.reference[:, :2] - [x, y]).T)
    return int(np.argmin(np.where(measurement.arrays["status"] == 0, away, np.inf)))


def _set(browser, name, value, event):
    script = f"document.getElementById('viewer-{name}')"
    browser.run(f"{script}.value = {value!r}; {script}.dispatchEvent(new Event('{event}'))")
    browser.settle()


def _readout(browser):
    return dict(
        browser.run(
            "[...document.querySelectorAll('#viewer-values tr')]"
            ".map((row) => [...row.children].map((cell) => cell.textContent))"
        )
    )


def _pixel(picture, place):
    return picture[round(place[1]), round(place[0])].astype(float)


@in_browser
def test_the_page_asks_for_nothing_and_complains_about_nothing(browser, page):
    assert browser.run("shapemorphViewer.painter") == "webgl"
    assert set(browser.requests) == {page.as_uri()}
    assert browser.complaints == []


@in_browser
def test_picking_reads_the_values_of_the_point(browser, results):
    arrays = results.measurement.arrays
    for row in (_near(results.measurement, 36, 10), _near(results.measurement, 20, 8)):
        browser.click(*browser.run(f"shapemorphViewer.place({row})"))
        browser.settle()
        shown = _readout(browser)
        assert shown["Row of measurement.csv, from 0"] == str(row)
        assert shown["Status"] == "OK"
        for label, value in (
            ("Larger principal Green–Lagrange strain E₁", arrays["E1"][row]),
            ("Smaller principal Green–Lagrange strain E₂", arrays["E2"][row]),
            ("Length of displacement |d|, mm", np.linalg.norm(arrays["displacement"][row])),
            ("Uncertainty of strain E₁ σ(E₁)", arrays["sigma_E1"][row]),
        ):
            assert float(shown[label]) == pytest.approx(value, rel=6e-4, abs=1e-7), label
        for label, values in (
            ("Reference position x, y, z, mm", results.measurement.reference),
            ("Displacement u, v, w, mm", arrays["displacement"]),
            (
                "Deformed position, aligned, mm",
                results.measurement.reference + arrays["displacement"],
            ),
        ):
            numbers = [float(number) for number in shown[label].split(", ")]
            np.testing.assert_allclose(numbers, values[row], rtol=6e-4, atol=1e-7)


@in_browser
def test_colours_are_those_of_the_values(browser, results):
    measurement = results.measurement
    rows = [_near(measurement, x, y) for x, y in ((36, 10), (20, 8), (50, 20), (30, 6))]
    places = [browser.run(f"shapemorphViewer.place({row})") for row in rows]
    for key in ("E1", "displacement_w", "zncc"):
        _set(browser, "field", key, "change")
        picture = browser.screenshot()
        values = measurement.arrays.get(key, measurement.arrays["displacement"][:, 2])
        wanted = colour_scale(values).colours(values[rows]).astype(float)
        for place, colour in zip(places, wanted, strict=True):
            seen = _pixel(picture, place)
            light = seen @ colour / (colour @ colour)
            assert 0.7 < light < 1.05
            np.testing.assert_allclose(seen, light * colour, atol=8)
    _set(browser, "field", "E1", "change")


@in_browser
def test_a_narrow_range_saturates_the_colours(browser, results):
    row = _near(results.measurement, 36, 10)
    low = float(results.measurement.arrays["E1"][row]) - 0.01
    _set(browser, "high", str(low), "change")
    seen = _pixel(browser.screenshot(), browser.run(f"shapemorphViewer.place({row})"))
    assert seen[0] > 170  # the yellow end
    assert seen[2] < 80
    assert f"{low:.4g}"[:4] in browser.run("document.getElementById('viewer-high').value")
    browser.run("document.getElementById('viewer-auto').click()")


@in_browser
def test_dragging_turns_and_the_wheel_zooms(browser, results):
    row, other = (_near(results.measurement, x, 20) for x in (5, 55))
    place = f"shapemorphViewer.place({row})"
    across = f"Math.hypot(...[0, 1].map((k) => {place}[k] - shapemorphViewer.place({other})[k]))"
    before, width = browser.run(place), browser.run(across)
    browser.mouse("mousePressed", 400, 500, button="left")
    browser.mouse("mouseMoved", 520, 500, button="left", buttons=1)
    browser.mouse("mouseReleased", 520, 500, button="left")
    browser.settle()
    assert np.hypot(*np.subtract(browser.run(place), before)) > 30
    browser.run("document.getElementById('viewer-reset').click()")
    browser.settle()
    np.testing.assert_allclose(browser.run(place), before, atol=0.01)
    browser.mouse("mouseWheel", 400, 500, deltaX=0, deltaY=-300)
    browser.settle()
    assert browser.run(across) == pytest.approx(width * np.exp(0.45), rel=1e-3)
    browser.run("document.getElementById('viewer-reset').click()")


@in_browser
def test_the_reference_shape_shows_lost_points_in_the_colour_of_their_status(browser, results):
    measurement = results.measurement
    lost = int(np.flatnonzero(measurement.arrays["status"] == PointStatus.LOW_ZNCC)[20])
    _set(browser, "field", "status", "change")
    place = browser.run(f"shapemorphViewer.place({lost})")
    wanted = [int(STATUS_COLOURS[PointStatus.LOW_ZNCC][k : k + 2], 16) for k in (1, 3, 5)]
    np.testing.assert_allclose(_pixel(browser.screenshot(), place), wanted, atol=3)
    browser.click(*place)
    browser.settle()
    shown = _readout(browser)
    assert shown["Status"] == "LOW_ZNCC"
    assert shown["Displacement u, v, w, mm"] == "–, –, –"
    _set(browser, "field", "E1", "change")
    _set(browser, "state", "1", "input")


@in_browser
def test_it_fits_a_phone(browser):
    browser.resize(390, 844, deviceScaleFactor=2, mobile=True)
    browser.settle()
    widest = (
        "[...document.querySelectorAll('main > *, .viewer *')]"
        ".filter((one) => one.getBoundingClientRect().right > 390).map((one) => one.outerHTML)"
    )
    assert browser.run(widest) == []
    assert browser.run("document.documentElement.scrollWidth") <= 390
    assert browser.run("document.getElementById('viewer-canvas').clientWidth") > 300
    browser.resize(1200, 1000)
    browser.settle()


@in_browser
def test_two_fingers_zoom(browser, results):
    row, other = (_near(results.measurement, x, 20) for x in (5, 55))
    places = [f"shapemorphViewer.place({number})" for number in (row, other)]
    width = np.hypot(*np.subtract(*(browser.run(place) for place in places)))
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    for kind, apart in (("touchStart", 50), ("touchMove", 75), ("touchMove", 100)):
        points = [{"x": 400 - apart, "y": 500, "id": 0}, {"x": 400 + apart, "y": 500, "id": 1}]
        browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
    browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    browser.call("Emulation.setTouchEmulationEnabled", enabled=False)
    browser.settle()
    wide = np.hypot(*np.subtract(*(browser.run(place) for place in places)))
    assert wide == pytest.approx(2 * width, rel=0.02)
    browser.run("document.getElementById('viewer-reset').click()")


@in_browser
def test_keys_turn_and_zoom(browser, results):
    place = f"shapemorphViewer.place({_near(results.measurement, 5, 20)})"
    before = browser.run(place)
    browser.run("document.getElementById('viewer-canvas').focus()")
    for key in ("ArrowLeft", "+"):
        now = browser.run(place)
        browser.call("Input.dispatchKeyEvent", type="keyDown", key=key)
        browser.settle()
        assert np.hypot(*np.subtract(browser.run(place), now)) > 2, key
    browser.run("document.getElementById('viewer-reset').click()")
    browser.settle()
    np.testing.assert_allclose(browser.run(place), before, atol=0.01)


@in_browser
def test_paper_shows_what_paper_can_show(browser):
    shown = "getComputedStyle(document.querySelector('{}')).display"
    browser.call("Emulation.setEmulatedMedia", media="print")
    assert browser.run(shown.format(".viewer")) == "none"
    assert browser.run(shown.format("nav")) == "none"
    assert browser.run(shown.format(".verdict")) != "none"
    browser.call("Emulation.setEmulatedMedia", media="")
    pages = base64.b64decode(browser.call("Page.printToPDF")["data"])
    assert pages.startswith(b"%PDF")
    browser.run(SHOW)


@in_browser
def test_without_webgl_the_same_is_drawn_and_picked(browser, page, results, tmp_path):
    with Browser(tmp_path, webgl=False) as plain:
        plain.open(page.as_uri())
        plain.run(SHOW)
        assert plain.run("shapemorphViewer.painter") == "canvas"
        row = _near(results.measurement, 20, 8)
        place = plain.run(f"shapemorphViewer.place({row})")
        np.testing.assert_allclose(place, browser.run(f"shapemorphViewer.place({row})"), atol=0.5)
        difference = plain.screenshot().astype(float) - browser.screenshot()
        assert np.abs(difference).mean() < 4
        plain.click(*place)
        plain.settle()
        assert _readout(plain)["Row of measurement.csv, from 0"] == str(row)
        assert plain.complaints == []
