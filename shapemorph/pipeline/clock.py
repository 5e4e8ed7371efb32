"""Time of named steps."""

import time
from collections.abc import Callable
from typing import TypeVar

from shapemorph.pipeline.run import Event, Listener

Result = TypeVar("Result")


class Clock:
    """Times named steps and tells the listener.

    Attributes
    ----------
    seconds : dict of str to float
        Of every step so far; steps of one name add up.
    """

    def __init__(self, listener: Listener) -> None:
        self.seconds: dict[str, float] = {}
        self._listener = listener

    def run(self, name: str, work: Callable[[], Result]) -> Result:
        """Do one step."""
        self._listener(Event(name, "started"))
        begin = time.perf_counter()
        result = work()
        took = time.perf_counter() - begin
        self.seconds[name] = self.seconds.get(name, 0.0) + took
        self._listener(Event(name, "finished", took))
        return result
