"""Errors that a user can act on, each with the exit code of the command line."""


class ShapemorphError(Exception):
    """Root of all errors raised on purpose: expected, got, what to change."""

    exit_code = 1


class ConfigError(ShapemorphError, ValueError):
    """The configuration or the command line asks for something impossible."""

    exit_code = 2


class DataError(ShapemorphError, ValueError):
    """An input file is missing, damaged or not what it should be."""

    exit_code = 3


class StageError(ShapemorphError, RuntimeError):
    """A stage ended with nothing valid."""

    exit_code = 4
