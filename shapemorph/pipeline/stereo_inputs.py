"""The pictures of two cameras over time, and the rig that took them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from string import digits

from shapemorph.config import RegionConfig, RunConfig
from shapemorph.core.camera import Rig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.image import GreyImage
from shapemorph.io.frames import Frame, list_frames, read_frame
from shapemorph.io.rig_files import read_rig
from shapemorph.pipeline.pictures import limited

SIDES = ("left", "right")


@dataclass(frozen=True, slots=True)
class StereoSequence:
    """What two cameras saw, state by state.

    Attributes
    ----------
    rig : Rig
        Its first two cameras are the left and the right one.
    left, right : tuple of Frame
        One picture for each state, in order.
    region : RegionConfig or None
        Part of the first left picture that is measured.
    channel : str
    """

    rig: Rig
    left: tuple[Frame, ...]
    right: tuple[Frame, ...]
    region: RegionConfig | None
    channel: str

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.left)

    def picture(self, side: str, state: int) -> GreyImage:
        """Read one picture.

        Raises
        ------
        DataError
            If it has not the size that the camera was calibrated with.
        """
        frame = (self.left if side == "left" else self.right)[state]
        read = read_frame(frame, self.channel)
        camera = self.rig.cameras[SIDES.index(side)]
        height, width = read.grey.shape
        if (width, height) != camera.size:
            raise DataError(
                f"{frame.label}: expected {camera.size[0]} x {camera.size[1]} px as the {side} "
                f"camera was calibrated with, got {width} x {height} px"
            )
        return GreyImage(read.grey, read.opaque)

    def pair(self) -> Rig:
        """Left and right camera alone."""
        return Rig(self.rig.cameras[:2], self.rig.names[:2])

    def first(self) -> GreyImage:
        """First left picture, limited to what is measured."""
        return limited(self.picture("left", 0), self.region, None, self.left[0].path)


def stereo_sequence(config: RunConfig) -> StereoSequence:
    """Find the pictures and read the rig that `inputs` names.

    Raises
    ------
    ConfigError
        If one of left, right and rig is not given.
    DataError
        If there are not as many pictures of both cameras, fewer than two, or no rig, or if
        their names say that one is missing.
    """
    inputs = config.inputs
    given = {"left": inputs.left, "right": inputs.right, "rig": inputs.rig}
    missing = [f"inputs.{name}" for name, path in given.items() if path is None]
    if inputs.left is None or inputs.right is None or inputs.rig is None:
        raise ConfigError(
            f"a stereo sequence needs inputs.left, inputs.right and inputs.rig, got no "
            f"{', '.join(missing)}"
        )
    left, right = list_frames(str(inputs.left)), list_frames(str(inputs.right))
    _check_partners(left, right, inputs.left, inputs.right)
    size = read_frame(left[0]).grey.shape
    rig = read_rig(inputs.rig, (size[1], size[0]))
    if len(rig.cameras) < 2:
        raise DataError(
            f"{inputs.rig}: expected two cameras, left and right, got {len(rig.cameras)}"
        )
    channel = "luma" if inputs.channel == "auto" else inputs.channel
    return StereoSequence(rig, left, right, inputs.region, channel)


def _check_partners(
    left: Sequence[Frame], right: Sequence[Frame], left_path: Path, right_path: Path
) -> None:
    """Refuse pictures of one camera without a partner from the other.

    Pictures go together by their order, unless their names say otherwise: what differs among
    the names of one camera is compared with that of the other. Names that have nothing in
    common, such as times, say nothing.
    """
    parts = [_differing_part(side) for side in (left, right)]
    common = set(parts[0]) & set(parts[1])
    if len(left) != len(right) or len(left) < 2:
        alone = [
            frame.path.name
            for side, own in zip((left, right), parts, strict=True)
            for frame, part in zip(side, own, strict=True)
            if common and part not in common
        ]
        named = f": {_some(alone)} has no partner" if alone else ""
        raise DataError(
            f"expected as many left pictures as right ones, two or more, got {len(left)} of "
            f"{left_path} and {len(right)} of {right_path}{named}: is a picture missing?"
        )
    for one, other, here, there in zip(left, right, *parts, strict=True):
        if here != there and (here in common or there in common):
            raise DataError(
                f"expected pictures of both cameras to have numbers alike, got {one.path.name} "
                f"beside {other.path.name}: is a picture missing? Name those of one state alike"
            )


def _differing_part(frames: Sequence[Frame]) -> list[str]:
    """Give what the name of each frame does not share with all others; whole numbers, no zeros."""
    names = [frame.name for frame in frames]
    head = _shared_head(names).rstrip(digits)
    tail = _shared_head([name[len(head) :][::-1] for name in names])[::-1].lstrip(digits)
    parts = [name[len(head) : len(name) - len(tail)] for name in names]
    return [str(int(part)) if part.isdecimal() else part for part in parts]


def _shared_head(texts: Sequence[str]) -> str:
    """Give the letters that all texts begin with."""
    alike = takewhile(lambda letters: len(set(letters)) == 1, zip(*texts, strict=False))
    return "".join(letters[0] for letters in alike)


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
