"""The pictures of two cameras over time, and the rig that took them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

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
        If there are not as many pictures of both cameras, fewer than two, or no rig.
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
    _check_counts(left, right, inputs.left, inputs.right)
    size = read_frame(left[0]).grey.shape
    rig = read_rig(inputs.rig, (size[1], size[0]))
    if len(rig.cameras) < 2:
        raise DataError(
            f"{inputs.rig}: expected two cameras, left and right, got {len(rig.cameras)}"
        )
    channel = "luma" if inputs.channel == "auto" else inputs.channel
    return StereoSequence(rig, left, right, inputs.region, channel)


def _check_counts(
    left: Sequence[Frame], right: Sequence[Frame], left_path: Path, right_path: Path
) -> None:
    if len(left) != len(right) or len(left) < 2:
        raise DataError(
            f"expected as many left pictures as right ones, two or more, got {len(left)} of "
            f"{left_path} and {len(right)} of {right_path}: is a picture missing?"
        )
