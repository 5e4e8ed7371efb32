"""A process of its own that draws while the run goes on.

Opening a window off screen and loading what draws takes longer than the drawing, and a
fault of a graphics driver ends a process: both are better had beside the run than in it.
"""

import gc
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Self

from shapemorph.core.errors import ShapemorphError, StageError
from shapemorph.view.figures import Named, encoded
from shapemorph.view.theme import THEMES

if TYPE_CHECKING:
    from shapemorph.view.render import Scene

Pictures = list[tuple[str, bytes]]
_Job = tuple[Callable[..., Named], tuple[Any, ...], bool]
"""What makes figures, of which nouns, and whether it needs a scene as well."""


class DrawingProcess:
    """Draws figures in the order in which they are asked for, in a ``with`` block.

    It starts to load what draws at once.

    Parameters
    ----------
    theme : str
        Name of one of ``THEMES``.
    """

    def __init__(self, theme: str = "light") -> None:
        self._jobs: queue.SimpleQueue[_Job | None] = queue.SimpleQueue()
        self._sender = threading.Thread(target=self._send, daemon=True)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, theme],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                process_group=0 if os.name == "posix" else None,
            )
        except OSError as error:
            raise StageError(f"could not start Python to draw: {error}") from error
        self._sender.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.wait()
        self._jobs.put(None)
        self._sender.join()
        for stream in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]

    def draw(self, figures: Callable[..., Named], *nouns: object) -> None:
        """Ask for the figures that a function makes of some nouns and return at once.

        Parameters
        ----------
        figures : callable
            Of a module; called there with the nouns.
        """
        self._jobs.put((figures, nouns, False))

    def draw_in_scene(self, figures: Callable[..., Named], *nouns: object) -> None:
        """Ask likewise for figures that a function makes of some nouns and a scene."""
        self._jobs.put((figures, nouns, True))

    def finish(self) -> Pictures:
        """Wait for all figures that were asked for.

        Returns
        -------
        list of (str, bytes)
            Names and contents of PNG files.

        Raises
        ------
        StageError
            Off-screen rendering gives nothing, or ended the process.
        """
        assert self._process.stdout is not None
        self._jobs.put(None)
        content = self._process.stdout.read()
        code = self._process.wait()
        if not content:
            raise StageError(
                f"the process that draws ended with code {code}: run `shapemorph "
                "doctor` to see what is missing, or set report.figures to false"
            )
        answer = pickle.loads(content)
        if isinstance(answer, ShapemorphError):
            raise answer
        pictures: Pictures = answer
        return pictures

    def _send(self) -> None:
        """Pass on what is asked for; a process that has ended is noticed in `finish`."""
        assert self._process.stdin is not None
        with suppress(OSError):
            while job := self._jobs.get():
                pickle.dump(job, self._process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
                self._process.stdin.flush()
            self._process.stdin.close()


def _main(source: IO[bytes], sink: IO[bytes], theme: str) -> None:
    """Load what draws, then answer what is asked for with figures or an error."""
    answer: Any
    try:
        import matplotlib.figure  # noqa: F401 (to have it when the nouns come)

        from shapemorph.view.render import Scene

        with Scene(THEMES[theme].pixel_ratio) as scene:
            answer = [
                picture for job in _jobs(source) for picture in encoded(_figures(job, scene), theme)
            ]
    except pickle.UnpicklingError:
        return  # the run has ended while it asked
    except ShapemorphError as error:
        answer = error
    with suppress(BrokenPipeError):
        pickle.dump(answer, sink)
        sink.flush()


def _jobs(source: IO[bytes]) -> Iterator[_Job]:
    with suppress(EOFError):
        while True:
            yield pickle.load(source)


def _figures(job: _Job, scene: "Scene") -> Named:
    figures, nouns, with_scene = job
    return figures(*nouns, scene) if with_scene else figures(*nouns)


@contextmanager
def _own_output() -> Iterator[IO[bytes]]:
    """Give stdout for the answer alone: what libraries print goes to stderr."""
    with os.fdopen(os.dup(1), "wb") as sink:
        os.dup2(2, 1)
        yield sink


if __name__ == "__main__":
    gc.set_threshold(20_000)  # libraries make many objects that stay
    with _own_output() as output:
        _main(sys.stdin.buffer, output, sys.argv[1])
        os._exit(0)  # what libraries do at the end takes time and may fail
