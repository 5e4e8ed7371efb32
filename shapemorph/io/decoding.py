"""What must be so while pillow decodes pictures, in however many threads."""

import threading
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

_lock = threading.Lock()
_decoding = 0
_before = ExitStack()


@contextmanager
def lenient_pillow() -> Iterator[None]:
    """Keep pillow's remarks about metadata to itself and lift its limit of size.

    Textures of 16384 px squared are real, and we check ourselves. Both are settings of the
    whole process: the first thread that begins makes them, the last one that ends takes them
    back.
    """
    global _decoding  # noqa: PLW0603 - a count of the process
    with _lock:
        if _decoding == 0:
            _before.enter_context(_quiet())
            _before.enter_context(_any_size())
        _decoding += 1
    try:
        yield
    finally:
        with _lock:
            _decoding -= 1
            if _decoding == 0:
                _before.close()


@contextmanager
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def _any_size() -> Iterator[None]:
    from PIL import Image

    limit = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = limit
