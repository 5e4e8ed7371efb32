"""A batch at the command line: read it, watch it, print it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from shapemorph.cli.console import show, show_json
from shapemorph.cli.options import Say, Settings
from shapemorph.cli.words import describe_batch

if TYPE_CHECKING:
    from shapemorph.config import BatchConfig
    from shapemorph.io.batch_files import Case
    from shapemorph.pipeline.batch import BatchEvent, BatchOutcome

Watcher = Callable[["BatchEvent"], None]

BEGIN = "begin"
"""First step of a case; where there is no terminal, the only one that is shown."""

_OF_THE_BATCH = "cluster."


def read_batch(
    path: Path, settings: Settings
) -> "tuple[BatchConfig, tuple[Case, ...], tuple[str, ...]]":
    """Read a batch file and its cases; settings of the cluster go over it.

    Returns
    -------
    BatchConfig
    tuple of Case
    tuple of str
        The other settings, which go over every case.
    """
    from shapemorph.config import BatchConfig
    from shapemorph.io.batch_files import read_cases
    from shapemorph.io.config_files import read_config

    own = [text for text in settings.set_ if text.startswith(_OF_THE_BATCH)]
    config = read_config(path, BatchConfig, own)
    others = tuple(text for text in settings.set_ if text not in own)
    return config, read_cases(config, path), others


@contextmanager
def watching_batch(say: Say) -> Iterator[Watcher]:
    """Give a listener: a live line for each running case on a terminal, a line for each row."""
    if say.quiet:
        yield lambda event: None  # noqa: ARG005
    elif sys.stderr.isatty():
        with _live_lines() as listener:
            yield listener
    else:
        yield _write_event


def print_batch(outcome: "BatchOutcome", say: Say) -> int:
    """Print what a batch found; 1 if a case has no result."""
    if say.json:
        show_json(
            {
                "folder": str(outcome.folder),
                "crew": None if outcome.crew is None else str(outcome.crew),
                "cases": list(outcome.rows),
                "files": [str(path) for path in outcome.files],
                "notes": list(outcome.notes),
            }
        )
    else:
        show("\n".join(describe_batch(outcome.folder, outcome.rows, outcome.notes)))
    return 1 if outcome.failed else 0


def _line_of(event: "BatchEvent") -> str:
    if event.state == "ready":
        return event.text
    if event.state == "ended":
        return f"[{event.ended}/{event.total}] {event.case}: {event.text}"
    return f"{event.case}: {event.text}"


def _write_event(event: "BatchEvent") -> None:
    if event.state == "step" and event.text != BEGIN:
        return
    sys.stderr.write(_line_of(event) + "\n")
    sys.stderr.flush()


@contextmanager
def _live_lines() -> Iterator[Watcher]:
    """Show the step of every running case; ended cases stay above."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        running: dict[str, TaskID] = {}
        ended: set[str] = set()

        def listen(event: "BatchEvent") -> None:
            if event.state == "step":
                if event.case in ended:  # told late
                    return
                if event.case not in running:
                    running[event.case] = progress.add_task(event.case, total=None)
                progress.update(running[event.case], description=_line_of(event))
                return
            ended.add(event.case)
            if event.case in running:
                progress.remove_task(running.pop(event.case))
            progress.console.print(_line_of(event), highlight=False, markup=False)

        yield listen
