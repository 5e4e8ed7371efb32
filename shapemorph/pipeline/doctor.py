"""What this machine lacks, and the command that mends it."""

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

_PYTHON = ((3, 11), (3, 13))

# Import name -> distribution. Each is really imported: a package may be there and not load.
_PACKAGES = {
    "numpy": "numpy",
    "scipy": "scipy",
    "numba": "numba",
    "trimesh": "trimesh",
    "igl": "libigl",
    "cv2": "opencv-contrib-python-headless",
    "pyvista": "pyvista",
    "matplotlib": "matplotlib",
    "PIL": "pillow",
    "pydantic": "pydantic",
    "yaml": "PyYAML",
    "cyclopts": "cyclopts",
    "rich": "rich",
    "jinja2": "Jinja2",
    "platformdirs": "platformdirs",
}

# Shared library -> Debian package and who needs it.
_LIBRARIES = {
    "libEGL.so.1": ("libegl1", "VTK and Open3D"),
    "libGL.so.1": ("libgl1", "VTK and Open3D"),
    "libX11.so.6": ("libx11-6", "VTK and Open3D"),
    "libusb-1.0.so.0": ("libusb-1.0-0", "Open3D"),
}

_RENDER = """
import numpy as np
from shapemorph.core.errors import StageError
from shapemorph.view.camera import View
from shapemorph.view.render import Scene
corners, (_, up, toward) = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.eye(3)
view = View(toward, up)
try:
    with Scene() as scene:
        scene.add_coloured(corners, np.array([[0, 1, 2]]))
        scene.picture(view, scene.frame(view, width=64, height=64))
except StageError as error:
    raise SystemExit(str(error).partition(": run")[0])
"""

_OPEN3D = """
try:
    import ctypes, libusb_package
    ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)
except (ImportError, OSError):
    pass
import open3d
print(open3d.__version__)
"""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at.

    Attributes
    ----------
    name, detail : str
    ok : bool
    remedy : str
        The one command that mends it; empty where all is well.
    """

    name: str
    ok: bool
    detail: str
    remedy: str = ""


def examine() -> Iterator[Finding]:
    """Yield what was found, one after the other; rendering last."""
    yield _python()
    for module, distribution in _PACKAGES.items():
        yield _package(module, distribution)
    yield _open3d()
    if sys.platform.startswith("linux"):
        for library, (package, users) in _LIBRARIES.items():
            yield _library(library, package, users)
    yield _kernel_cache()
    yield _rendering()


def _python() -> Finding:
    version = sys.version_info[:2]
    found = f"{sys.version.split()[0]} ({sys.executable})"
    if _PYTHON[0] <= version <= _PYTHON[1]:
        return Finding("Python", ok=True, detail=found)
    wanted = " to ".join(".".join(map(str, bound)) for bound in _PYTHON)
    return Finding(
        "Python",
        ok=False,
        detail=f"{found}, expected {wanted}",
        remedy="make setup PYTHON=python3.11",
    )


def _package(module: str, distribution: str) -> Finding:
    tried = _try(f"import {module}")
    if tried is not None:
        return Finding(distribution, ok=False, detail=tried, remedy=_install(distribution))
    return Finding(distribution, ok=True, detail=metadata.version(distribution))


def _open3d() -> Finding:
    tried = _try(_OPEN3D)
    for distribution in ("open3d-cpu", "open3d"):
        try:
            version = metadata.version(distribution)
        except metadata.PackageNotFoundError:
            continue
        if tried is None:
            return Finding("open3d", ok=True, detail=f"{version} ({distribution})")
        return Finding("open3d", ok=False, detail=tried, remedy=_apt(*_debian_packages()))
    return Finding("open3d", ok=False, detail="not installed", remedy=_install("open3d-cpu"))


def _library(library: str, package: str, users: str) -> Finding:
    try:
        ctypes.CDLL(library)
    except OSError:
        if library.startswith("libusb") and _try("import libusb_package") is None:
            return Finding(library, ok=True, detail=f"from libusb-package, for {users}")
        return Finding(
            library, ok=False, detail=f"not found; {users} need it", remedy=_apt(package)
        )
    return Finding(library, ok=True, detail=f"found, for {users}")


def _kernel_cache() -> Finding:
    try:
        import numba

        import shapemorph.kernels  # noqa: F401 - sets the place of the cache
    except ImportError as error:
        return Finding("kernel cache", ok=False, detail=str(error), remedy=_install("numba"))

    place = Path(numba.config.CACHE_DIR)
    probe = place / f".writable-{os.getpid()}"
    try:
        place.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        return Finding(
            "kernel cache",
            ok=False,
            detail=f"{place} cannot be written ({error.strerror}): kernels compile at each start",
            remedy="export NUMBA_CACHE_DIR=$HOME/.numba",
        )
    return Finding("kernel cache", ok=True, detail=f"{place} is writable")


def _rendering() -> Finding:
    tried = _try(_RENDER)
    if tried is None:
        return Finding("off-screen rendering", ok=True, detail="draws a picture")
    return Finding("off-screen rendering", ok=False, detail=tried, remedy=_apt(*_debian_packages()))


def _try(script: str) -> str | None:
    """Run a script in a process of its own; None if it worked, else the reason in one line."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
        )
    except subprocess.TimeoutExpired:
        return "no answer within 120 s"
    if done.returncode == 0:
        return None
    lines = [line for line in done.stderr.strip().splitlines() if line.strip()]
    return lines[-1].strip() if lines else f"ended with code {done.returncode}"


def _debian_packages() -> tuple[str, ...]:
    return tuple(package for package, _ in _LIBRARIES.values())


def _apt(*packages: str) -> str:
    prefix = "" if hasattr(os, "geteuid") and os.geteuid() == 0 else "sudo "
    return f"{prefix}apt-get install --no-install-recommends -y {' '.join(packages)}"


def _install(distribution: str) -> str:
    return f"{sys.executable} -m pip install {distribution}"
