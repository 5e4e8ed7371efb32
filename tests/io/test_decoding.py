"""Settings of pillow while pictures are decoded in several threads."""

import threading
import warnings

import pytest
from PIL import Image

from shapemorph.io.decoding import lenient_pillow


def _limit_is(limit):
    return limit == Image.MAX_IMAGE_PIXELS


def test_the_last_thread_that_ends_takes_the_settings_back():
    limit, filters = Image.MAX_IMAGE_PIXELS, list(warnings.filters)
    other_is_in, first_is_out = threading.Event(), threading.Event()
    seen = []

    def other():
        with lenient_pillow():
            other_is_in.set()
            assert first_is_out.wait(30)
            seen.append(Image.MAX_IMAGE_PIXELS)

    thread = threading.Thread(target=other)
    with lenient_pillow():
        thread.start()
        assert other_is_in.wait(30)
        assert _limit_is(None)
    first_is_out.set()
    thread.join()
    assert seen == [None]
    assert _limit_is(limit)
    assert warnings.filters == filters


def test_a_failure_takes_them_back_too():
    limit = Image.MAX_IMAGE_PIXELS
    with pytest.raises(ValueError, match="damaged"), lenient_pillow():
        raise ValueError("damaged")
    assert _limit_is(limit)
