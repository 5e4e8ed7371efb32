"""Run a command and turn what happens into an exit code."""

import errno
import gc
import os
import sys
import textwrap
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from cyclopts import CycloptsError

from shapemorph.cli.console import complain
from shapemorph.cli.sequences import app
from shapemorph.core.errors import ShapemorphError

UNEXPECTED, USAGE, INTERRUPTED = 1, 2, 130
PATIENT = 20_000  # new objects between two searches for cycles; libraries make many at the start


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns
    -------
    int
        0 done, 2 configuration or usage, 3 input data, 4 a stage failed, 1 anything else,
        130 interrupted.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "--debug" in words:
        return _run(words)
    try:
        return _run(words)
    except ShapemorphError as error:
        complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        return _interrupted()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNEXPECTED
    except Exception as error:  # noqa: BLE001 - the door: one line instead of a traceback
        return _interrupted() if _was_interrupted(error) else _failed(error)


def run_and_leave() -> NoReturn:
    """Run the command line and end the process at once.

    All results are on disk by then; tearing down VTK and the compiled loops in good order
    would take another second.
    """
    gc.set_threshold(PATIENT)
    code = main()
    with suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


def _run(words: list[str]) -> int:
    try:
        code = app(
            words,
            exit_on_error=False,
            print_error=False,
            result_action="return_value",
        )
    except CycloptsError as error:
        complain(f"{_plain(error)} (see shapemorph --help)")
        return USAGE
    return code if isinstance(code, int) else 0


def _interrupted() -> int:
    complain("interrupted; finished stages are kept")
    return INTERRUPTED


def _failed(error: Exception) -> int:
    complain(_unexpected(error))
    return UNEXPECTED


def _was_interrupted(error: BaseException) -> bool:
    """Whether it came up while an interrupt was being handled."""
    before = error.__context__
    while before is not None and not isinstance(before, KeyboardInterrupt):
        before = before.__context__
    return before is not None


def _plain(error: CycloptsError) -> str:
    return " ".join(str(error).split())


def _unexpected(error: Exception) -> str:
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        where = f" at {error.filename}" if error.filename else ""
        return f"the disk is full{where}: free some space and run again; finished stages are kept"
    if isinstance(error, MemoryError):
        return "out of memory: lower flatten.max_megapixels or flatten.px_per_mm"
    what = textwrap.shorten(str(error), 200, placeholder=" ...")
    return f"unexpected {type(error).__name__}: {what} (--debug shows where)"
