"""A process of its own that draws the shapes while the run goes on.

Opening a window off screen and loading what draws takes longer than the drawing, and a
fault of a graphics driver ends a process: both are better had beside the run than in it.
"""

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import IO, Any, Self

from shapemorph.core.errors import ShapemorphError, StageError
from shapemorph.view.figures import encoded
from shapemorph.view.shapes import Shapes, shape_figures

Pictures = list[tuple[str, bytes]]


class ShapeProcess:
    """Draws the figures of the shapes; starts to load at once, in a ``with`` block."""

    def __init__(self) -> None:
        self._sender: threading.Thread | None = None
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                process_group=0 if os.name == "posix" else None,
            )
        except OSError as error:
            raise StageError(f"could not start Python to draw the shapes: {error}") from error

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
        if self._sender:
            self._sender.join()
        for stream in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]

    def begin(self, shapes: Shapes) -> None:
        """Hand over what is to be drawn and return at once."""
        self._sender = threading.Thread(target=self._send, args=(shapes,), daemon=True)
        self._sender.start()

    def finish(self) -> Pictures:
        """Wait for the figures.

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
        content = self._process.stdout.read()
        code = self._process.wait()
        if not content:
            raise StageError(
                f"the process that draws the shapes ended with code {code}: run `shapemorph "
                "doctor` to see what is missing, or set report.figures to false"
            )
        answer = pickle.loads(content)
        if isinstance(answer, ShapemorphError):
            raise answer
        pictures: Pictures = answer
        return pictures

    def _send(self, shapes: Shapes) -> None:
        """Write to the process; one that has ended is noticed in `finish`."""
        assert self._process.stdin is not None
        with suppress(OSError):
            pickle.dump(shapes, self._process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()


def draw_shapes(shapes: Shapes) -> Pictures:
    """Draw the figures of the shapes in a process of its own and wait for them.

    Raises
    ------
    StageError
        Off-screen rendering gives nothing, or ended the process.
    """
    with ShapeProcess() as process:
        process.begin(shapes)
        return process.finish()


def _main(source: IO[bytes], sink: IO[bytes]) -> None:
    """Load what draws, then wait for shapes and answer with figures or an error."""
    answer: Any
    try:
        import matplotlib.figure  # noqa: F401 (to have it when the shapes come)

        from shapemorph.view.render import Scene

        with Scene() as scene:
            answer = list(encoded(shape_figures(pickle.load(source), scene)))
    except (EOFError, pickle.UnpicklingError):
        return  # the run has ended before it had shapes to draw
    except ShapemorphError as error:
        answer = error
    with suppress(BrokenPipeError):
        pickle.dump(answer, sink)
        sink.flush()


@contextmanager
def _own_output() -> Iterator[IO[bytes]]:
    """Give stdout for the answer alone: what libraries print goes to stderr."""
    with os.fdopen(os.dup(1), "wb") as sink:
        os.dup2(2, 1)
        yield sink


if __name__ == "__main__":
    with _own_output() as output:
        _main(sys.stdin.buffer, output)
        os._exit(0)  # what libraries do at the end takes time and may fail
