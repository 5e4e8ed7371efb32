"""The command line: a table of commands."""

import gc

gc.set_threshold(50_000, 10, 10)  # loading makes objects that stay: looking through them is idle

from shapemorph.cli.main import main  # noqa: E402 - loads what the line above is about

__all__ = ["main"]
