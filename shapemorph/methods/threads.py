"""Run compiled loops over blocks of a list in several threads."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager


@contextmanager
def kernel_threads(threads: int | None) -> Iterator[None]:
    """Limit the threads of compiled loops while a block runs; None leaves them alone."""
    import numba

    before = numba.get_num_threads()
    if threads is not None:
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)


def run_blocks(work: Callable[[int, int], object], number: int, *, block: int) -> None:
    """Call ``work(first, last)`` for all blocks of a list of `number` items.

    The blocks do not depend on the number of threads, so that neither does what is done
    in them. `work` must release the interpreter lock and write only what is its own.

    Parameters
    ----------
    work : callable
        Takes the first item and the one after the last.
    number : int
    block : int
        Items at once; with none at all, ``work(0, 0)`` is still called once.
    """
    import numba

    starts = range(0, max(number, 1), block)
    threads = min(numba.get_num_threads(), len(starts))
    if threads == 1:
        for first in starts:
            work(first, min(first + block, number))
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda first: work(first, min(first + block, number)), starts))
