"""Several threads: for blocks of a list, and for a few whole jobs."""

import importlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


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
    waiting = iter(starts)  # whoever is free takes the next

    def work_on() -> None:
        for first in waiting:
            work(first, min(first + block, number))

    with ThreadPoolExecutor(threads) as pool:
        for done in [pool.submit(work_on) for _ in range(threads)]:
            done.result()


def run_at_once(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Call ``work(item)`` for each of a few items, all at once where threads allow it.

    An item must not need what another one's call makes. Compiled loops with threads of
    their own may run in several threads only where numba has a pool that allows it
    (OpenMP or TBB); elsewhere, and where one thread is all there is, the items take turns.

    Returns
    -------
    list
        In the order of the items; the first call that raises ends it.
    """
    import numba

    threads = numba.get_num_threads()
    if threads == 1 or len(items) < 2 or not _loops_may_meet():
        return [work(item) for item in items]

    def limited(item: Item) -> Result:
        numba.set_num_threads(threads)  # a setting of each thread
        return work(item)

    with ThreadPoolExecutor(min(threads, len(items))) as pool:
        return list(pool.map(limited, items))


def _loops_may_meet() -> bool:
    """Whether numba has a pool of threads that may be entered from several threads."""
    for pool in ("omppool", "tbbpool"):
        try:
            importlib.import_module(f"numba.np.ufunc.{pool}")
        except ImportError:
            continue
        return True
    return False
