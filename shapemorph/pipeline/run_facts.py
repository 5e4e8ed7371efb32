"""What a run took and what ran: seconds, memory, versions."""

import contextlib
import platform
import re
import resource
import sys
from collections.abc import Mapping
from importlib import metadata
from typing import Any

import shapemorph

_PACKAGES = (
    *("numpy", "scipy", "numba", "opencv-contrib-python-headless", "libigl", "trimesh"),
    *("open3d", "pyvista", "vtk"),
)
_OTHER_DISTRIBUTIONS = {"open3d": ("open3d-cpu",)}
_AFTER_THE_SUMMARY = ("write summary", "write report")


def run_figures(seconds: Mapping[str, float]) -> dict[str, Any]:
    """Give time, memory and versions.

    Writing the summary and the report can only be timed once the summary is written: in a
    first run they are missing, in a later one they are those of the last time. The total
    leaves them out, so that it means the same in both.
    """
    timed = {name: value for name, value in seconds.items() if name not in _AFTER_THE_SUMMARY}
    return {
        "seconds": {**seconds, "total": sum(timed.values())},
        "peak_memory_mb": peak_memory_mb(),
        "versions": versions(),
    }


def peak_memory_mb() -> float:
    """Largest memory of this process so far, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)


def versions() -> dict[str, str]:
    """Name what made these numbers; nothing is imported, what is not installed is left out."""
    found = {"shapemorph": shapemorph.__version__, "python": platform.python_version()}
    found |= {name: version for name in _PACKAGES if (version := _version(name))}
    return found


def _version(package: str) -> str | None:
    """Version of a package under any name that it is distributed by.

    Looked up in the text of its metadata, of which a parser would read the whole manual.
    """
    for name in (package, *_OTHER_DISTRIBUTIONS.get(package, ())):
        with contextlib.suppress(metadata.PackageNotFoundError):
            text = metadata.distribution(name).read_text("METADATA") or ""
            if found := re.search(r"^Version:\s*(\S+)", text, re.MULTILINE):
                return found[1]
    return None
