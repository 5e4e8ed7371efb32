"""What is written where: results to stdout, progress, log and errors to stderr."""

import json
import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from shapemorph.cli.options import Say

if TYPE_CHECKING:
    from shapemorph.pipeline.run import Event

Listener = Callable[["Event"], None]


_UNREMARKABLE = ("inputs", "write run.yaml")


def show(text: str) -> None:
    """Write a result to stdout."""
    sys.stdout.write(text + "\n")


def show_json(content: Any) -> None:
    """Write a result to stdout as JSON."""
    from shapemorph.io.safe_files import without_nan

    show(json.dumps(without_nan(content), indent=2, ensure_ascii=False))


def complain(text: str) -> None:
    """Write one line to stderr."""
    sys.stderr.write(f"shapemorph: {' '.join(text.split())}\n")


def configure_log(say: Say) -> None:
    """Send the log of the package to stderr; warnings of libraries only with --debug."""
    level = logging.DEBUG if say.debug else logging.WARNING
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("%(name)s: %(message)s"))
    log = logging.getLogger("shapemorph")
    log.handlers = [handler]
    log.setLevel(level)
    logging.captureWarnings(capture=True)
    warnings = logging.getLogger("py.warnings")
    warnings.handlers = [handler]
    warnings.setLevel(logging.DEBUG if say.debug else logging.ERROR)


@contextmanager
def watching(say: Say) -> Iterator[Listener]:
    """Give a listener: a progress bar on a terminal, a line for each stage elsewhere."""
    if say.quiet:
        yield lambda event: None  # noqa: ARG005
    elif sys.stderr.isatty():
        with _progress_bar() as listener:
            yield listener
    else:
        yield _write_event


def _write_event(event: "Event") -> None:
    if event.name in _UNREMARKABLE:
        return
    if event.state == "finished":
        sys.stderr.write(f"{event.name}: {event.seconds:.2f} s\n")
    elif event.state == "kept":
        sys.stderr.write(f"{event.name}: up to date\n")
    sys.stderr.flush()


@contextmanager
def _progress_bar() -> Iterator[Listener]:
    """Show the running step and the time; finished steps stay above it."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("reading", total=None)

        def listen(event: "Event") -> None:
            if event.state == "started":
                progress.update(task, description=event.name)
            else:
                seconds = f"{event.seconds:6.2f} s" if event.state == "finished" else "up to date"
                progress.console.print(f"{event.name:18s} {seconds}", highlight=False)

        yield listen
