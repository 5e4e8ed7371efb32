"""One door to Open3D, which needs system libraries that not every machine has."""

import ctypes
import warnings
from typing import Any

from shapemorph.core.errors import ShapemorphError


def import_open3d() -> Any:
    """Import Open3D with the libusb of the wheel `libusb-package` already loaded.

    Returns
    -------
    module
        ``open3d``.

    Raises
    ------
    ShapemorphError
        If a system library is missing.
    """
    _load_libusb()
    _keep_numba_from_tbb()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import open3d
    except (ImportError, OSError) as error:
        reason = " ".join(str(error).split())[:160]
        raise ShapemorphError(
            f"expected Open3D to load, got: {reason}; run `shapemorph doctor` for the command "
            "that installs what is missing"
        ) from None
    return open3d


def _keep_numba_from_tbb() -> None:
    """Let kernels started later turn to TBB last: Open3D's copy is too old for numba."""
    import numba

    layers = numba.config.THREADING_LAYER_PRIORITY
    numba.config.THREADING_LAYER_PRIORITY = sorted(layers, key=lambda layer: layer == "tbb")


def _load_libusb() -> None:
    """Offer libusb to libraries loaded later; machines that have their own do not need it."""
    try:
        import libusb_package

        ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)
    except (ImportError, OSError):
        return
