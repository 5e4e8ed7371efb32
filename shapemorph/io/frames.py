"""Pictures that follow each other: names with numbers, or pages of one file."""

import re
import warnings
from collections import Counter
from dataclasses import dataclass
from glob import glob
from pathlib import Path
from typing import Any

from shapemorph.core.errors import DataError
from shapemorph.io.images import Picture, read_picture


@dataclass(frozen=True, slots=True)
class Frame:
    """One picture of a sequence.

    Attributes
    ----------
    path : Path
    page : int or None
        Which picture of the file; None where it is the only one.
    name : str
        Differs from that of every other frame and makes a good name of a folder.
    """

    path: Path
    page: int | None
    name: str

    @property
    def label(self) -> str:
        """What messages call it."""
        return str(self.path) if self.page is None else f"{self.path} (picture {self.page + 1})"


def whole_pages(path: Path) -> tuple[int, ...]:
    """Numbers of the pictures in a file; reduced copies beside them are left out.

    One for nearly every file; TIFF holds any number. A file that cannot be understood
    counts as one picture: reading it says what is wrong.
    """
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(path) as picture:
                count = int(getattr(picture, "n_frames", 1))
                return tuple(k for k in range(count) if count == 1 or not _is_reduced(picture, k))
        except Exception:  # noqa: BLE001 decoders raise whatever they like
            return (0,)


def read_only_picture(path: Path, channel: str = "luma") -> Picture:
    """Read a file that holds one picture; `channel` of its colours becomes grey.

    Raises
    ------
    DataError
        If it holds several, or cannot be read.
    """
    pages = whole_pages(path)
    if len(pages) > 1:
        raise DataError(
            f"{path}: expected one picture, got {len(pages)}: correlate them as a sequence "
            f"(--sequence {path}), or export the one that is meant"
        )
    return read_picture(path, channel, page=pages[0] if pages else 0)


def list_frames(pattern: str) -> tuple[Frame, ...]:
    """Find the pictures of a sequence, in the natural order of their names.

    Numbers in names count as numbers: frame_9 comes before frame_10. A single file with
    many pages gives one frame a page; among several files each must hold one picture.

    Parameters
    ----------
    pattern : str
        Such as ``frames/*.tif``, or the path of one file.

    Raises
    ------
    DataError
        If there are fewer than two pictures, or a file among several holds many.
    """
    if Path(pattern).is_dir():
        raise DataError(
            f"sequence {pattern}: expected a pattern of files, got a folder: write {pattern}/*.tif"
        )
    found = [pattern] if Path(pattern).is_file() else glob(pattern, recursive=True)  # noqa: PTH207 - may be absolute
    paths = sorted((Path(name) for name in found if Path(name).is_file()), key=natural_key)
    frames = _pages(paths[0]) if len(paths) == 1 else _files(paths)
    if len(frames) < 2:
        raise DataError(
            f"sequence {pattern}: expected two pictures or more, got {len(frames)}: check the "
            "pattern (in quotes, so that the shell leaves it alone)"
        )
    return frames


def read_frame(frame: Frame, channel: str = "luma") -> Picture:
    """Read one frame; errors as :func:`~shapemorph.io.images.read_picture`."""
    return read_picture(frame.path, channel, page=frame.page)


def natural_key(path: Path) -> list[tuple[int, int, str]]:
    """Sort by the numbers in a name, then by the text around them."""
    parts = re.split(r"(\d+)", str(path))
    return [(0, int(part), part) if part.isdigit() else (1, 0, part) for part in parts]


def _pages(path: Path) -> tuple[Frame, ...]:
    pages = whole_pages(path)
    if len(pages) == 1:
        return (Frame(path, None, path.stem),)
    width = len(str(len(pages)))
    return tuple(
        Frame(path, page, f"{path.stem}_{number:0{width}d}")
        for number, page in enumerate(pages, start=1)
    )


def _files(paths: list[Path]) -> tuple[Frame, ...]:
    stems = Counter(path.stem for path in paths)
    frames = []
    for path in paths:
        if (count := len(whole_pages(path))) > 1:
            raise DataError(
                f"sequence: {path} holds {count} pictures: expected one in each of several files, "
                "or a single file with all of them"
            )
        frames.append(Frame(path, None, _unique_name(path, stems)))
    return tuple(frames)


def _unique_name(path: Path, stems: Counter[str]) -> str:
    """Stem of a file, or as much of its path as tells it from the others."""
    return path.stem if stems[path.stem] == 1 else "_".join(path.parts[1:]).replace(" ", "_")


def _is_reduced(picture: Any, page: int) -> bool:
    """Whether a page says that it is a smaller copy of another one (TIFF tag 254)."""
    picture.seek(page)
    return picture.format == "TIFF" and bool(int(picture.tag_v2.get(254, 0)) & 1)
