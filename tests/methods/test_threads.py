"""A few jobs at once."""

import threading

import numba
import pytest

from shapemorph.methods import threads
from shapemorph.methods.threads import kernel_threads, run_at_once


def test_results_come_in_the_order_of_the_items():
    gate = threading.Event()

    def work(item):
        if item == "first" and numba.get_num_threads() > 1 and threads._loops_may_meet():
            assert gate.wait(30)  # runs only if the second does, too
        gate.set()
        return item.upper()

    assert run_at_once(work, ("first", "second")) == ["FIRST", "SECOND"]


@pytest.mark.parametrize("pools", [True, False])
def test_one_thread_takes_turns(monkeypatch, pools):
    monkeypatch.setattr(threads, "_loops_may_meet", lambda: pools)
    limit = 1 if pools else None
    with kernel_threads(limit):
        names = run_at_once(lambda _: threading.current_thread().name, "ab")
    assert names == [threading.current_thread().name] * 2


def test_every_thread_keeps_the_limit_of_the_caller():
    with kernel_threads(2):
        assert run_at_once(lambda _: numba.get_num_threads(), "ab") == [numba.get_num_threads()] * 2


def test_the_first_failure_is_raised():
    def fails(item):
        raise ValueError(item)

    with pytest.raises(ValueError, match="a"):
        run_at_once(fails, ("a", "b"))
