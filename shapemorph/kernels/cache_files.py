"""The files of numba's disk cache, for several processes at a time.

numba writes the index of a function before the code that it names, and chooses the name of
the code from an index that another process may be writing. Two processes that compile at
the same time can so be given the code of another signature, and crash.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from numba.core import caching


class CacheFiles(caching.IndexDataCacheFile):  # type: ignore[misc]
    """Index and code of one function, written and read as one."""

    def save(self, key: Any, data: Any) -> None:
        """Write the code of a signature while nobody reads or writes."""
        with _held(self._cache_path, fcntl.LOCK_EX):
            super().save(key, data)

    def load(self, key: Any) -> Any:
        """Read the code of a signature while nobody writes; None where there is none."""
        with _held(self._cache_path, fcntl.LOCK_SH):
            return super().load(key)


def guard_cache() -> None:
    """Let numba use these files from now on."""
    caching.IndexDataCacheFile = CacheFiles


@contextmanager
def _held(folder: str, how: int) -> Iterator[None]:
    """Hold a folder while the block runs; where the disk has no locks, nothing is held."""
    try:
        lock = os.open(folder, os.O_RDONLY)
    except OSError:
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(lock, how)
        yield
    finally:
        os.close(lock)
