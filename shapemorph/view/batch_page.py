"""The summary page of a batch: one row a case, with a link to its report."""

from collections.abc import Mapping, Sequence
from typing import Any

from shapemorph.view.pages import plain_page
from shapemorph.view.tables import text_of


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
    figures = list(dict.fromkeys(key for row in rows for key in row["scorecard"]))
    return plain_page(
        "batch.html.j2",
        title=f"{len(rows)} cases",
        counts=_counts(rows),
        crew=crew,
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
