"""Page of a reproduced experiment: tables, and the figures beside it."""

from collections.abc import Mapping, Sequence
from typing import Any

from shapemorph.view.pages import mean_and_spread, plain_page
from shapemorph.view.reproduction import WORDS


def page_html(summary: Mapping[str, Any], figures: Sequence[str]) -> str:
    """Write the page as HTML; figures lie beside it."""
    rows = [_row(name, method) for name, method in summary["methods"].items()]
    return plain_page(
        "reproduction.html.j2",
        kind=summary["kind"],
        rows=rows,
        limits=_LIMITS,
        reach=[(WORDS.get(name, name), value) for name, value in summary["reach"].items()],
        settings=_settings_rows(summary["settings_by_case"]),
        columns=[WORDS.get(name, name) for name in summary["settings_by_case"]],
        figures=figures,
    )


_LIMITS = (
    "ours: mean + s.d. at most 0.005 mm in u and v, 0.012 mm in w (incremental twice that), no "
    "point off by more than 0.06 mm, more than 5200 points, at full size"
)


def _settings_rows(by_case: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Tabulate each setting and its value in each case; empty where it has none."""
    names = dict.fromkeys(name for settings in by_case.values() for name in settings)
    return [
        [name.replace("_px", ", px").replace("_", " ")]
        + ["" if settings[name] is None else str(settings[name]) for settings in by_case.values()]
        for name in names
    ]


def _row(name: str, method: Mapping[str, Any]) -> dict[str, Any]:
    truth, other = method["against_truth_mm"], method["against_incremental_mm"]
    return {
        "name": WORDS.get(name, name),
        "points": method["points"],
        "truth": [mean_and_spread(truth[key]) for key in ("u", "v", "w", "E1", "E2")],
        "largest": f"{max(truth[key]['largest'] for key in 'uvw'):.3f}",
        "other": [mean_and_spread(other[key]) if other else "–" for key in "uvw"],
        "seconds": f"{method['seconds']:.0f}",
        "report": f"{name}/report.html",
    }
