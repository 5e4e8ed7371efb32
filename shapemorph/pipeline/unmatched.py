"""What a failed match leaves behind: a picture of what looked alike."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import UnmatchedError

PICTURE = "failed_match.png"
Images = Callable[[], tuple[GreyImage, GreyImage]]


@contextmanager
def showing_failed_match(folder: Path, images: Images) -> Iterator[None]:
    """Draw the two pictures into a folder if they cannot be matched, and say where.

    A picture that an earlier attempt left there is removed first.

    Parameters
    ----------
    folder : Path
        Made where it is missing.
    images : callable
        Gives reference and deformed picture; called only after a failure.

    Raises
    ------
    StageError
        In place of the `UnmatchedError`, with the path of the picture.
    """
    (folder / PICTURE).unlink(missing_ok=True)
    try:
        yield
    except UnmatchedError as error:
        from shapemorph.view.failed_match import failed_match_figure
        from shapemorph.view.figures import encoded, write_pictures

        figure = failed_match_figure(*images(), error.reference_px, error.deformed_px)
        write_pictures(encoded(iter([(Path(PICTURE).stem, figure)])), folder)
        raise StageError(f"{error}; what looked alike: {folder / PICTURE}") from error
