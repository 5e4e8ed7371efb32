"""A folder that one process at a time works in."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from shapemorph.core.errors import ConfigError

LOCK_FILE = ".lock"


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Hold a folder, made where missing, while the block runs.

    The system lets go of it when the process ends, however it ends. Where the system or
    the disk knows no locks, nothing is held.

    Raises
    ------
    ConfigError
        If another process works in it.
    """
    try:
        import fcntl
    except ImportError:  # not a POSIX system
        yield
        return
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK_FILE).open("w") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ConfigError(
                f"output {folder}: another batch works in it: wait for it, or choose another "
                "directory with -o"
            ) from error
        except OSError:
            pass
        yield
