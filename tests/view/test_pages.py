"""What all pages share."""

import pytest
from jinja2 import UndefinedError

from shapemorph.view.pages import mean_and_spread, plain_page

VALUES = {"title": "a & b", "counts": "", "crew": "<i>", "figures": [], "rows": []}


def test_text_is_escaped_and_the_look_is_not():
    page = plain_page("batch.html.j2", **VALUES)
    assert "<title>a &amp; b</title>" in page
    assert "&lt;i&gt;" in page
    assert '"Segoe UI"' in page


def test_every_page_has_one_frame():
    page = plain_page("batch.html.j2", **VALUES)
    for tag in ("<!doctype html>", "<title>", "</style>", "<body>", "</html>"):
        assert page.count(tag) == 1


def test_a_value_that_is_missing_is_an_error():
    with pytest.raises(UndefinedError, match="counts"):
        plain_page("batch.html.j2", title="", crew="", figures=[], rows=[])


def test_mean_and_spread_have_four_digits_and_stay_in_one_line():
    text = mean_and_spread({"mean": -0.00126, "std": 0.1})
    assert text == "-0.0013\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}0.1000"
