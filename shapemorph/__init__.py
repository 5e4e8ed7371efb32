"""Full-field strain between two textured 3D shapes of one object.

``measure`` and ``load`` are the package as a library (docs/python.md); they are imported
when first used, so that the package itself costs next to nothing.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"
__all__ = ["Result", "__version__", "facet_strain", "load", "measure"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("shapemorph.api"), name)
    raise AttributeError(f"module 'shapemorph' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
