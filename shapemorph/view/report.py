"""The page that a run ends with: one file that opens anywhere, offline."""

import base64
from collections.abc import Iterable, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

from shapemorph.core.errors import DataError
from shapemorph.view.captions import caption_of, report_order
from shapemorph.view.tables import Table, label_of, section_table, text_of

_TITLES = {
    "points": "Points and why some have no value",
    "coverage": "Part of the surface that is covered",
    "strain": "Strain",
    "displacement_mm": "Length of the displacement, mm",
    "sigma_displacement_mm": "Standard deviation of one component of the displacement, mm",
    "align": "Alignment",
    "correlate": "Correlation",
    "match": "Matches",
    "flatten": "Distortion by the flattening",
    "lift": "Lifting",
    "inputs": "What was read",
    "seconds": "Seconds",
    "peak_memory_mb": "Memory",
    "versions": "Versions",
    "config": "Settings",
}
_HONOURED = ("verdict", "scorecard")


def write_report(summary: dict[str, Any], figures: list[Path], path: Path) -> None:
    """Write the report of a run as one self-contained HTML page.

    Parameters
    ----------
    summary : dict
        What `summary.json` holds. ``verdict`` (``level``, ``reasons``) and ``scorecard``
        stand on top; every other section becomes a table.
    figures : list of Path
        PNG files; their names choose caption and place.
    path : Path
        The page.

    Raises
    ------
    DataError
        A figure cannot be read.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("shapemorph.view", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    page = environment.get_template("report.html.j2").render(
        subject=_subject(summary),
        verdict=_verdict(summary),
        scorecard=[
            (label_of(key), text_of(key, value))
            for key, value in summary.get("scorecard", {}).items()
        ],
        groups=_groups(figures),
        tables=list(_tables(summary)),
        version=summary.get("versions", {}).get("shapemorph", ""),
    )
    path.write_text(page, encoding="utf-8")


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


def _tables(summary: Mapping[str, Any]) -> Iterable[Table]:
    """Every section that has no place of honour, the known ones first."""
    names = [name for name in _TITLES if name in summary]
    names += [name for name in summary if name not in (*_HONOURED, *_TITLES)]
    for name in names:
        title = _TITLES.get(name, label_of(name).capitalize())
        yield section_table(name, title, summary[name])


def _groups(figures: Iterable[Path]) -> list[dict[str, Any]]:
    """Figures under their headings, in the order of the report."""
    ordered = sorted(figures, key=lambda path: report_order(path.stem))
    shown = [(caption_of(path.stem), path) for path in ordered]
    return [
        {
            "title": title,
            "figures": [
                {"name": path.stem, "source": _data_uri(path), "text": caption.text}
                for caption, path in members
            ],
        }
        for title, members in groupby(shown, key=lambda pair: pair[0].group)
    ]


def _data_uri(path: Path) -> str:
    """Contents of a PNG file as an address."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DataError(f"expected a figure at {path}, got {error.strerror}") from error
    return "data:image/png;base64," + base64.b64encode(data).decode("ascii")
