"""The summary page of a batch: one row a case, with a link to its report."""

from collections.abc import Mapping, Sequence
from typing import Any

import shapemorph
from shapemorph.view.tables import text_of

_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ title }}</title>
<style>
body { margin: 0 auto; max-width: 1400px; padding: 1.5rem 1rem; color: #1d2430; background: #fff;
  font: 15px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.4rem; margin: 0; }
p { color: #5d6673; margin: .3rem 0 1rem; }
div { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .35rem .9rem .35rem 0;
  border-top: 1px solid #dfe3e8; }
thead th { font-weight: 600; font-size: .85rem; vertical-align: bottom; border-top: 0; }
td.reason { min-width: 18rem; max-width: 40rem; overflow-wrap: anywhere; }
.PASS { color: #1b6e3c; } .WARN { color: #8a5a00; } .FAIL, .failed { color: #a3261d; }
.state { font-weight: 700; }
@media print { body { font-size: 9pt; max-width: none; } tr { break-inside: avoid; } }
</style>
</head>
<body>
<h1>{{ title }}</h1>
<p>{{ counts }}{% if crew %} · {{ crew }}{% endif %} · shapemorph {{ version }} ·
<a href="batch.csv">batch.csv</a></p>
<div><table>
<thead><tr><th>case</th><th>verdict</th><th>seconds</th><th>reason</th>
{% for name in figures %}<th>{{ name }}</th>{% endfor %}</tr></thead>
<tbody>
{% for row in rows %}<tr>
<td>{% if row.report %}<a href="{{ row.report }}">{{ row.case }}</a>{% else %}{{ row.case }}
{% endif %}</td>
<td class="state {{ row.word }}">{{ row.word }}</td>
<td>{{ row.seconds }}</td>
<td class="reason">{{ row.reason }}</td>
{% for text in row.figures %}<td>{{ text }}</td>{% endfor %}
</tr>
{% endfor %}</tbody>
</table></div>
</body>
</html>
"""


def batch_page(rows: Sequence[Mapping[str, Any]], crew: str) -> str:
    """Write the page as HTML that needs nothing but the reports beside it.

    Parameters
    ----------
    rows : sequence of mapping
        ``case``, ``state``, ``verdict``, ``reason``, ``seconds``, ``report`` (relative path
        or None) and ``scorecard``.
    crew : str
        Who worked; empty: not known.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined)
    figures = list(dict.fromkeys(key for row in rows for key in row["scorecard"]))
    return environment.from_string(_PAGE).render(
        title=f"{len(rows)} cases",
        counts=_counts(rows),
        crew=crew,
        version=shapemorph.__version__,
        figures=figures,
        rows=[_texts(row, figures) for row in rows],
    )


def _counts(rows: Sequence[Mapping[str, Any]]) -> str:
    """Count the cases of each kind."""
    words = [_word(row) for row in rows]
    return ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))


def _word(row: Mapping[str, Any]) -> str:
    """Verdict of a case, or what it is instead of measured."""
    return str(row["verdict"] or row["state"])


def _texts(row: Mapping[str, Any], figures: Sequence[str]) -> dict[str, Any]:
    score = row["scorecard"]
    return {
        "case": row["case"],
        "word": _word(row),
        "reason": row["reason"],
        "seconds": text_of("seconds", row["seconds"]),
        "report": row["report"],
        "figures": [text_of(name, score.get(name)) for name in figures],
    }
