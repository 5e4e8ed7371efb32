"""Page of a reproduced experiment: tables, and the figures beside it."""

from collections.abc import Mapping, Sequence
from typing import Any

from shapemorph.view.panels import PAGE_STYLE
from shapemorph.view.reproduction import WORDS


def page_html(summary: Mapping[str, Any], figures: Sequence[str]) -> str:
    """Write the page as HTML; figures lie beside it."""
    from jinja2 import Environment, select_autoescape

    import shapemorph

    environment = Environment(autoescape=select_autoescape(default=True))
    rows = [_row(name, method) for name, method in summary["methods"].items()]
    return environment.from_string(_PAGE).render(
        kind=summary["kind"],
        rows=rows,
        limits=_LIMITS,
        reach=[(WORDS.get(name, name), value) for name, value in summary["reach"].items()],
        settings=_settings_rows(summary["settings_by_case"]),
        columns=[WORDS.get(name, name) for name in summary["settings_by_case"]],
        figures=figures,
        style=PAGE_STYLE,
        version=shapemorph.__version__,
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

    def text(figures: Mapping[str, float]) -> str:
        return f"{figures['mean']:.4f} ± {figures['std']:.4f}"

    return {
        "name": WORDS.get(name, name),
        "points": method["points"],
        "truth": [text(truth[key]) for key in ("u", "v", "w", "E1", "E2")],
        "largest": f"{max(truth[key]['largest'] for key in 'uvw'):.3f}",
        "other": [text(other[key]) if other else "–" for key in "uvw"],
        "seconds": f"{method['seconds']:.0f}",
        "report": f"{name}/report.html",
    }


_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>shapemorph: {{ kind }}</title>
{{ style|safe }}
</head>
<body>
<h1>The {{ kind }}, by every method, against the truth</h1>
<p>Errors in mm, mean ± standard deviation over all points; strains without unit. Required of
{{ limits }}. The paper printed, against its incremental method: image-morphing w 0.06 ± 0.07,
u 0.03 ± 0.04, v 0.01 ± 0.02; shape-morphing w 0.05 ± 0.03, u 0.02 ± 0.01, v 0.02 ± 0.02.</p>
<div><table>
<thead><tr><th rowspan="2">method</th><th rowspan="2">points</th>
<th colspan="6">against the truth</th><th colspan="3">against incremental</th>
<th rowspan="2">seconds</th></tr>
<tr><th>u</th><th>v</th><th>w</th><th>E₁</th><th>E₂</th><th>largest</th>
<th>u</th><th>v</th><th>w</th></tr></thead>
<tbody>
{% for row in rows %}<tr><td><a href="{{ row.report }}">{{ row.name }}</a></td>
<td>{{ row.points }}</td>{% for text in row.truth %}<td>{{ text }}</td>{% endfor %}
<td>{{ row.largest }}</td>{% for text in row.other %}<td>{{ text }}</td>{% endfor %}
<td>{{ row.seconds }}</td></tr>
{% endfor %}</tbody></table></div>
{% if reach %}<h2>How far each method goes</h2>
<p>Largest stretch up to which nine points in ten are found, with at most a pixel of error
(rms).</p>
<div><table><tbody>
{% for name, stretch in reach %}<tr><td>{{ name }}</td>
<td>{% if stretch %}{{ "%.2f"|format(stretch) }}{% else %}none of the states{% endif %}</td></tr>
{% endfor %}</tbody></table></div>{% endif %}
<h2>Settings</h2>
<div><table>
<thead><tr><th></th>{% for column in columns %}<th>{{ column }}</th>{% endfor %}</tr></thead>
<tbody>
{% for row in settings %}<tr>{% for text in row %}<td>{{ text }}</td>{% endfor %}</tr>
{% endfor %}</tbody></table></div>
<h2>Figures</h2>
{% for figure in figures %}<img src="{{ figure }}" alt="{{ figure }}">
{% endfor %}
<p><a href="summary.json">summary.json</a> · <a href="errors.csv">errors.csv</a> ·
<a href="morph/sequence.gif">morph sequence</a> · shapemorph {{ version }}</p>
</body>
</html>
"""
