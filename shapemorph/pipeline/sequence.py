"""The morph sequence of two pictures: how many there are, and what is written of them."""

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from shapemorph.config import MorphConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.io.animations import frames_of, write_gif, write_mp4
from shapemorph.io.images import write_grey_png
from shapemorph.methods.sequence_turn import Turn, turn_between

log = logging.getLogger(__name__)

MOST_STRAIN = 0.15  # from one picture to the next: what a search by whole pixels follows
LEAST_ZNCC = 0.9  # of neighbours, windows shifted only
MOST_IMAGES = 24
ATTEMPTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class MorphSequence:
    """The pictures I_1 ... I_N and how far apart they are.

    Attributes
    ----------
    pictures : tuple of N GreyImage
        Both originals at the ends.
    strain, zncc : (N - 1,) float64
        From each picture to the next.
    turn : Turn
        That they take along an arc.
    reason : str
        One sentence: why so many.
    """

    pictures: tuple[GreyImage, ...]
    strain: Floats
    zncc: Floats
    turn: Turn
    reason: str

    def figures(self) -> dict[str, Any]:
        """Give what the summary says."""
        return {
            "images": len(self.pictures),
            "reason": self.reason,
            "turn_rad": self.turn.angle,
            "strain": self.strain.tolist(),
            "zncc": self.zncc.tolist(),
        }


def make_sequence(
    reference: GreyImage,
    deformed: GreyImage,
    warps: tuple[Warp, Warp],
    config: MorphConfig,
) -> MorphSequence:
    """Draw the way from one picture to the other in as many steps as it takes.

    Parameters
    ----------
    reference, deformed : GreyImage
    warps : two Warp
        Forward and backward.
    config : MorphConfig
        `images` is followed where it is given; else the steps are as few as keep the
        strain and the ZNCC between neighbours within limits.
    """
    from shapemorph.methods.sequence_steps import images_for_strain, points_of

    points = points_of(reference)
    turn = turn_between(points, warps[0])
    if config.images is not None:
        found = _drawn((reference, deformed), warps, turn, config.images)
        return replace(found, reason="as configured")
    images = images_for_strain(
        points, warps, turn, most_strain=MOST_STRAIN, most_images=MOST_IMAGES
    )
    for _ in range(ATTEMPTS):
        found = _drawn((reference, deformed), warps, turn, images)
        if images == MOST_IMAGES or not found.zncc.min() < LEAST_ZNCC:
            break
        images = min(MOST_IMAGES, 2 * -(-3 * images // 4))
    return replace(found, reason=_reason(found))


def write_sequence(folder: Path, sequence: MorphSequence) -> None:
    """Write the pictures, and both animations where this machine can make them."""
    (folder / "sequence").mkdir()
    for number, picture in enumerate(sequence.pictures, start=1):
        path = folder / "sequence" / f"I_{number:02d}.png"
        write_grey_png(path, picture.grey, picture.mask)
    frames = frames_of(sequence.pictures)
    write_gif(folder / "sequence.gif", frames)
    if not write_mp4(folder / "sequence.mp4", frames):
        log.warning("no MP4: this OpenCV has no encoder for it; sequence.gif shows the same")


def _drawn(
    ends: tuple[GreyImage, GreyImage], warps: tuple[Warp, Warp], turn: Turn, images: int
) -> MorphSequence:
    from shapemorph.methods.morph_sequence import morph_sequence
    from shapemorph.methods.sequence_steps import follow_points, neighbour_zncc, points_of
    from shapemorph.methods.subset_choice import choose_subset

    between = morph_sequence(*ends, *warps, images=images, turn=turn)
    pictures = (ends[0], *between, ends[1])
    followed = follow_points(points_of(ends[0]), *warps, images=images, turn=turn)
    size = choose_subset(ends[0], subset_size=None, spacing=None).subset_size
    zncc = neighbour_zncc(pictures, followed, subset_size=size)
    return MorphSequence(pictures, followed.strain, zncc, turn, "")


def _reason(found: MorphSequence) -> str:
    reached = found.strain.max() <= MOST_STRAIN and found.zncc.min() >= LEAST_ZNCC
    worst = f"strain {found.strain.max():.2g}, ZNCC {found.zncc.min():.2f} between neighbours"
    if reached:
        return f"{worst}: within {MOST_STRAIN} and {LEAST_ZNCC}"
    return f"{worst}: not within {MOST_STRAIN} and {LEAST_ZNCC}, most images reached or no gain"
