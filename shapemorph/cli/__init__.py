"""The command line: a table of commands."""

from shapemorph.cli.main import main
