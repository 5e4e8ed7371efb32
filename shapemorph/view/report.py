"""The page that a run ends with: one file that opens anywhere, offline."""

import re
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from markupsafe import Markup

from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.view.captions import CHECKS, caption_of, report_order
from shapemorph.view.pages import asset, page
from shapemorph.view.style import STATUS_COLOURS, STATUS_WORDS
from shapemorph.view.tables import Table, cell, label_of, section_table
from shapemorph.view.theme import THEMES, Theme, embedded
from shapemorph.view.viewer import viewer_data

_TITLES = {
    "points": "Points and why some have no value",
    "coverage": "Part of the surface that is covered",
    "strain": "Strain",
    "displacement_mm": "Length of the displacement, mm",
    "sigma_displacement_mm": "Standard deviation of one component of the displacement, mm",
    "align": "Alignment",
    "correlate": "Correlation",
    "match": "Matches",
    "morph": "Morph law",
    "flatten": "Distortion by the flattening",
    "lift": "Lifting",
    "inputs": "What was read",
    "seconds": "Seconds",
    "peak_memory_mb": "Memory",
    "versions": "Versions",
    "config": "Settings",
}
_HONOURED = ("verdict", "scorecard", "good_practice")
_PRACTICE = {
    "hardware": "Hardware and set-up",
    "analysis": "Analysis",
    "flattening and matching": "Flattening and matching",
    "definitions": "Definitions",
}
_GENERAL_TITLE = "Measurement of shape and strain"
_SCRIPTS = (
    *("viewer_surface.js", "viewer_webgl.js", "viewer_canvas.js", "viewer_pick.js"),
    *("viewer_gestures.js", "viewer_words.js", "viewer.js"),
)
_ANCHOR = re.compile(r"[^a-z0-9]+")


@dataclass(frozen=True, slots=True, eq=False)
class Contents:
    """What a report is made of.

    Attributes
    ----------
    summary : dict
        What `summary.json` holds, and ``config``. ``verdict`` (``level``, ``reasons``) and
        ``scorecard`` stand on top; every other section becomes a table.
    figures : list of Path
        PNG files; their names choose caption and place.
    measurement : Measurement or None
        For the interactive view; None: without one.
    theme : str
        "light", or "print" for a page in black on white.
    """

    summary: dict[str, Any]
    figures: list[Path]
    measurement: Measurement | None = None
    theme: str = "light"


def write_report(contents: Contents, path: Path) -> None:
    """Write the report of a run as one self-contained HTML page.

    Raises
    ------
    DataError
        A figure cannot be read.
    """
    summary, measurement = contents.summary, contents.measurement
    text = page(
        "report.html.j2",
        theme=contents.theme,
        title=_heading(summary),
        subject=_subject(summary),
        verdict=_verdict(summary),
        scorecard=section_table("scorecard", "Scorecard", summary.get("scorecard", {})).rows,
        statuses=_statuses(summary),
        groups=_groups(contents.figures, THEMES[contents.theme]),
        checks=CHECKS,
        viewer=viewer_data(measurement) if measurement else None,
        practice=list(_practice(summary)),
        tables=list(_tables(summary)),
        version=summary.get("versions", {}).get("shapemorph", ""),
        style=asset("report.css"),
        script=Markup("\n").join(asset(name) for name in _SCRIPTS),
    )
    path.write_text(text, encoding="utf-8")


def _statuses(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Share of the points with each status, for bars; its own colour and number."""
    points = summary.get("points", {})
    counts = {k: n for k, n in points.get("statuses", {}).items() if k != "OUTSIDE_MASK"}
    most = max(counts.values(), default=0)
    return [
        {
            "name": STATUS_WORDS[PointStatus[name]],
            "colour": STATUS_COLOURS[PointStatus[name]],
            "count": cell(name, count, f"points/statuses/{name}"),
            "width": f"{100 * count / most:.3g}%",
        }
        for name, count in counts.items()
    ]


def _verdict(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Level and reasons; without a verdict the page says so."""
    verdict = summary.get("verdict", {})
    level = str(verdict.get("level", "NO VERDICT"))
    return {"level": level, "reasons": [str(reason) for reason in verdict.get("reasons", [])]}


def _subject(summary: Mapping[str, Any]) -> str:
    """Name the two files, where the summary knows them."""
    inputs = summary.get("inputs", {})
    names = [inputs.get(side, {}).get("name", "") for side in ("reference", "deformed")]
    return " → ".join(str(name) for name in names if name) or "two shapes of one object"


def _heading(summary: Mapping[str, Any]) -> str:
    """Title that the user gave, or a general one."""
    return summary.get("config", {}).get("report", {}).get("title") or _GENERAL_TITLE


def _practice(summary: Mapping[str, Any]) -> Iterable[Table]:
    """Tables of the Good Practices Guide."""
    for name, rows in summary.get("good_practice", {}).items():
        yield section_table(f"good_practice/{name}", _PRACTICE.get(name, name), rows)


def _tables(summary: Mapping[str, Any]) -> Iterable[Table]:
    """Every section that has no place of honour, the known ones first."""
    names = [name for name in _TITLES if name in summary]
    names += [name for name in summary if name not in (*_HONOURED, *_TITLES)]
    for name in names:
        title = _TITLES.get(name, label_of(name).capitalize())
        yield section_table(name, title, summary[name])


def _groups(figures: Iterable[Path], theme: Theme) -> list[dict[str, Any]]:
    """Figures under their headings, in the order of the report."""
    ordered = sorted(figures, key=lambda path: report_order(path.stem))
    with ThreadPoolExecutor() as pool:
        parts = list(pool.map(lambda path: _figure(path, theme), ordered))
    return [
        {
            "title": title,
            "anchor": _ANCHOR.sub("-", title.lower()).strip("-"),
            "figures": _to_one_scale(list(members)),
        }
        for title, members in groupby(parts, key=lambda part: caption_of(part["name"]).group)
    ]


def _figure(path: Path, theme: Theme) -> dict[str, Any]:
    """Name, caption, width in px, and the contents of a PNG file as an address."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataError(f"expected a figure at {path}, got {error.strerror}") from error
    source, width = embedded(content, theme)
    return {
        "name": path.stem,
        "text": caption_of(path.stem).text,
        "source": source,
        "width": width,
    }


def _to_one_scale(figures: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Give each figure of a group the share of the page that shows all at one scale."""
    widest = max(figure["width"] for figure in figures)
    return [{**figure, "share": round(figure["width"] / widest, 4)} for figure in figures]
