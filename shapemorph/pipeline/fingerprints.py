"""What a result depends on, as one short text."""

import functools
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import shapemorph
from shapemorph.core.errors import DataError

_FLOORS_THAT_COMPUTE = ("core", "kernels", "methods", "stages", "io", "pipeline")


def fingerprint(*recipe: Any) -> str:
    """Digest of JSON-able values."""
    return hashlib.sha256(json.dumps(recipe, sort_keys=True).encode()).hexdigest()


def file_fingerprint(path: Path) -> str:
    """Digest of the content of a file.

    Raises
    ------
    DataError
        If it cannot be read.
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from error


def files_fingerprint(paths: Sequence[Path]) -> str:
    """Digest of the contents of several files, in their order; where they lie is no matter."""
    return fingerprint(*(file_fingerprint(path) for path in paths))


@functools.cache
def code_fingerprint(*, including_view: bool = False) -> str:
    """Version of the package and digest of the code that makes results, or figures too."""
    home = Path(shapemorph.__file__).parent
    floors = (*_FLOORS_THAT_COMPUTE, "view") if including_view else _FLOORS_THAT_COMPUTE
    sources = [path for floor in floors for path in sorted((home / floor).rglob("*.py"))]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    return fingerprint(shapemorph.__version__, digest)
