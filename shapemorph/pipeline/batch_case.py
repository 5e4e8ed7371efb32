"""One case of a batch, as a worker runs it: a row comes out, whatever happens."""

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from shapemorph.core.errors import ShapemorphError
from shapemorph.pipeline.cluster import limit_threads, tell
from shapemorph.pipeline.run import Event

Row = dict[str, Any]

CASES = "cases"
"""Folder of the runs in that of a batch."""

_one_at_a_time = threading.Lock()
"""Of a worker that has several threads: drawing and peak memory are those of the process."""


def run_case(payload: dict[str, Any]) -> Row:
    """Bring the run of one case up to date.

    Parameters
    ----------
    payload : dict
        ``name``, ``folder`` of the run, ``config`` (a complete one, JSON-able), ``threads``
        and ``topic``.

    Returns
    -------
    dict
        As :func:`finished_row`, or :func:`failed_row` with the reason.
    """

    def listen(event: Event) -> None:
        tell(payload["topic"], {"case": payload["name"], "step": event.name, "state": event.state})

    with _one_at_a_time:
        listen(Event("begin", "started"))
        limit_threads(payload["threads"])
        return bring_up_to_date(payload["name"], Path(payload["folder"]), payload["config"], listen)


def bring_up_to_date(
    name: str, folder: Path, config: dict[str, Any], listen: Callable[[Event], None]
) -> Row:
    """Measure a pair and describe what came out, as a row of the table."""
    from shapemorph.config import RunConfig
    from shapemorph.pipeline.measure import measure

    begin = time.perf_counter()
    try:
        outcome = measure(RunConfig.model_validate(config), folder, listener=listen)
    except ShapemorphError as error:
        return failed_row(name, str(error))
    except MemoryError:
        return failed_row(name, "out of memory: lower flatten.max_megapixels or cluster.workers")
    except Exception as error:  # noqa: BLE001 - a fault of one case is a row, not the end
        return failed_row(name, f"unexpected {type(error).__name__}: {error}")
    state = "kept" if outcome.did_nothing else "done"
    return finished_row(name, folder, state, time.perf_counter() - begin)


def finished_row(name: str, folder: Path, state: str, seconds: float) -> Row:
    """Describe a finished run: state, verdict with its reasons, time, scorecard.

    The time of a run that was kept is that of the run which made it.
    """
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    if state == "kept":
        seconds = summary["seconds"]["total"]
    level, reasons = summary["verdict"]["level"], summary["verdict"]["reasons"]
    return {
        "case": name,
        "state": state,
        "verdict": level,
        "reason": "; ".join(reason.removeprefix(f"{level}: ") for reason in reasons),
        "seconds": round(seconds, 3),
        "report": f"{CASES}/{name}/report.html",
        "scorecard": summary["scorecard"],
    }


def failed_row(name: str, reason: str) -> Row:
    """Describe a case without a result."""
    return {
        "case": name,
        "state": "failed",
        "verdict": None,
        "reason": " ".join(reason.split()),
        "seconds": None,
        "report": None,
        "scorecard": {},
    }


def waiting_row(name: str) -> Row:
    """Describe a case whose turn has not come."""
    return {**failed_row(name, ""), "state": "waiting"}
