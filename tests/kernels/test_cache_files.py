"""Functions that are compiled at the same time are not given each other's code."""

import threading

import pytest
from numba.core import caching

from shapemorph.kernels.cache_files import CacheFiles

KEYS = 40


def _clash(kind, folder):
    """Save many keys at the same time; those that are answered with another's code, or none."""
    folder.mkdir(exist_ok=True)
    begin = threading.Barrier(KEYS)

    def save(key):
        files = kind(str(folder), "kernel", "stamp")
        begin.wait()
        files.save(key, f"code of {key}")
        found.append((key, files.load(key)))

    found = []
    threads = [threading.Thread(target=save, args=(key,)) for key in range(KEYS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    files = kind(str(folder), "kernel", "stamp")
    found += [(key, files.load(key)) for key in range(KEYS)]
    return [key for key, code in found if code != f"code of {key}"]


def test_every_signature_gets_its_own_code(tmp_path):
    assert _clash(CacheFiles, tmp_path) == []


def test_without_the_lock_they_clash(tmp_path):
    plain = CacheFiles.__mro__[1]
    # Else the test above says nothing.
    assert any(_clash(plain, tmp_path / str(number)) for number in range(5))


def test_kernels_use_it():
    import shapemorph.kernels  # noqa: F401

    assert caching.IndexDataCacheFile is CacheFiles


def test_a_folder_that_is_not_there_is_no_error(tmp_path):
    assert CacheFiles(str(tmp_path / "absent"), "kernel", "stamp").load(1) is None
    with pytest.raises(OSError, match="absent"):
        CacheFiles(str(tmp_path / "absent"), "kernel", "stamp").save(1, "code")
