"""What is read of plain pictures, and the part of the reference that is measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from shapemorph.config import RegionConfig, RunConfig
from shapemorph.core.arrays import Bools
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.image import GreyImage
from shapemorph.io.frames import read_only_picture
from shapemorph.io.images import PICTURE_SUFFIXES, Picture, read_white
from shapemorph.methods.colour_content import best_channel
from shapemorph.pipeline.inputs import region_in_mm


def measures_pictures(config: RunConfig) -> bool:
    """Tell a configuration of plain pictures from one of meshes.

    Raises
    ------
    ConfigError
        If one side is a picture and the other is not.
    """
    inputs = config.inputs
    if inputs.sequence is not None:
        return True
    sides = {"reference": inputs.reference, "deformed": inputs.deformed}
    pictures = [name for name, path in sides.items() if path and _is_picture(path)]
    if len(pictures) == 1:
        other = next(name for name in sides if name not in pictures)
        raise ConfigError(
            f"inputs.{pictures[0]} is a picture, inputs.{other} is {sides[other] or 'empty'}: "
            "expected two pictures or two meshes"
        )
    return len(pictures) == 2


@dataclass(frozen=True, slots=True)
class PicturePair:
    """Two pictures, and what of their colours became grey.

    Attributes
    ----------
    reference, deformed : GreyImage
        The mask of the first is what is measured of it.
    channel, reason : str
    """

    reference: GreyImage
    deformed: GreyImage
    channel: str
    reason: str

    def figures(self) -> dict[str, Any]:
        """Section `inputs` of the summary."""
        return {"channel": self.channel, "channel_reason": self.reason}


def read_picture_pair(
    reference: Path, deformed: Path, config: RunConfig, mask: Path | None
) -> PicturePair:
    """Read two pictures in one channel, and limit the first to what is measured."""
    readers = [partial(read_only_picture, path) for path in (reference, deformed)]
    pictures, channel, reason = in_one_channel(readers, config.inputs.channel)
    left, right = (GreyImage(picture.grey, picture.opaque) for picture in pictures)
    left = limited(left, config.inputs.region, mask, reference)
    return PicturePair(left, right, channel, reason)


def read_picture_single(path: Path, config: RunConfig) -> GreyImage:
    """Read one picture, limited to the region."""
    (picture,), *_ = in_one_channel([partial(read_only_picture, path)], config.inputs.channel)
    return limited(GreyImage(picture.grey, picture.opaque), config.inputs.region, None, path)


def with_sizes(config: RunConfig, picture: GreyImage) -> RunConfig:
    """Settle subset size and spacing by what a picture shows."""
    from shapemorph.methods.subset_choice import choose_subset

    given = config.correlate
    choice = choose_subset(picture, subset_size=given.subset_size, spacing=given.spacing)
    sizes = {"subset_size": choice.subset_size, "spacing": choice.spacing}
    return config.model_copy(update={"correlate": given.model_copy(update=sizes)})


def in_one_channel(
    readers: Sequence[Callable[[str], Picture]], channel: str
) -> tuple[list[Picture], str, str]:
    """Read pictures in the channel that is asked for, or that shows the pattern best.

    Returns
    -------
    list of Picture
    channel, reason : str
    """
    from shapemorph.methods.threads import run_at_once

    first = "luma" if channel == "auto" else channel
    pictures = run_at_once(lambda read: read(first), readers)
    if channel != "auto":
        return pictures, channel, "as inputs.channel says"
    best, reason = best_channel([picture.content for picture in pictures])
    if best != "luma":
        pictures = run_at_once(lambda read: read(best), readers)
    return pictures, best, reason


def limited(
    picture: GreyImage, region: RegionConfig | None, mask: Path | None, path: Path
) -> GreyImage:
    """Take away what a mask and a region do not allow.

    Raises
    ------
    ConfigError
        If the region is a ball, or nothing is left.
    DataError
        If the mask cannot be read, is white nowhere or has another size.
    """
    allowed = picture.mask
    if mask is not None:
        allowed = allowed & _read_mask(mask, picture.shape)
    if region is not None:
        allowed = allowed & _region(region, picture.shape)
    if not allowed.any():
        raise ConfigError(
            f"mask and inputs.region leave no pixel of {path} "
            f"({picture.shape[1]} x {picture.shape[0]} px): check them, corners are (x, y) in px "
            "from the upper left"
        )
    return GreyImage(picture.grey, allowed)


def _region(region: RegionConfig, shape: tuple[int, int]) -> Bools:
    from shapemorph.methods.regions import picture_region

    if region.centre is not None:
        raise ConfigError(
            "inputs.region.centre and radius are a ball around a mesh, got pictures: give "
            "polygon, polygons, holes or mask"
        )
    return picture_region(region_in_mm(region, 1.0), shape, picture="reference picture")


def _read_mask(path: Path, shape: tuple[int, int]) -> Bools:
    white = read_white(path)
    if white.shape != shape:
        raise DataError(
            f"mask {path}: expected the size of the reference, {shape[1]} x {shape[0]} px, got "
            f"{white.shape[1]} x {white.shape[0]} px"
        )
    return white


def _is_picture(path: Path) -> bool:
    return path.suffix.lower() in PICTURE_SUFFIXES
