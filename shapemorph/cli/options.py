"""Options that commands share."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

Output = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Directory for the results; a default name if empty."),
]


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class Say:
    """How much is said, and in what form."""

    quiet: Annotated[
        bool, Parameter(negative=(), show_default=False, help="Only results and errors.")
    ] = False
    json: Annotated[
        bool, Parameter(negative=(), show_default=False, help="Results as JSON on stdout.")
    ] = False
    debug: Annotated[
        bool, Parameter(negative=(), show_default=False, help="Log details; traceback on errors.")
    ] = False


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class Settings:
    """Changes to the configuration."""

    set_: Annotated[
        list[str],
        Parameter(
            name="--set",
            negative=(),
            consume_multiple=False,
            show_default=False,
            help="section.key=value, over the configuration; may be repeated.",
        ),
    ] = field(default_factory=list)
