"""Pictures in a row as an animation: GIF and MP4."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.image import GreyImage

Frames: TypeAlias = NDArray[np.uint8]

LARGEST = 720  # px of the longer side
SECONDS = 2.0  # from the first to the last picture
HOLD = 0.5  # seconds for which the first and the last stand still
RATE = 25  # pictures per second of the film


def frames_of(pictures: Sequence[GreyImage]) -> Frames:
    """(N, H, W) 8-bit pictures of one even size, black outside their masks, reduced to fit."""
    import cv2

    height = max(picture.shape[0] for picture in pictures)
    width = max(picture.shape[1] for picture in pictures)
    scale = min(1.0, LARGEST / max(height, width))
    small = [max(2, int(scale * length) // 2 * 2) for length in (height, width)]
    frames = np.zeros((len(pictures), *small), np.uint8)
    for frame, picture in zip(frames, pictures, strict=True):
        canvas = np.zeros((height, width), np.float32)
        canvas[: picture.shape[0], : picture.shape[1]] = np.where(picture.mask, picture.grey, 0)
        reduced = cv2.resize(canvas, (small[1], small[0]), interpolation=cv2.INTER_AREA)
        frame[:] = np.clip(np.rint(255 * reduced), 0, 255)
    return frames


def write_gif(path: Path, frames: Frames) -> None:
    """Write frames (N, H, W), or (N, H, W, 3) in colours, as a GIF that plays for ever.

    All frames have the colours of the last one, or the nearest to them.
    """
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in frames]
    if pictures[-1].mode == "RGB":
        last = pictures[-1].quantize(255, dither=Image.Dither.NONE)
        pictures = [each.quantize(palette=last, dither=Image.Dither.NONE) for each in pictures]
    times = [int(1000 * seconds) for seconds in _times(len(frames))]
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=times, loop=0)


def write_mp4(path: Path, frames: Frames) -> bool:
    """Write frames (N, H, W), or (N, H, W, 3) in colours, as an MP4 (MPEG-4 part 2).

    Returns
    -------
    bool
        False where this machine has no encoder; then nothing is written.
    """
    import cv2

    code = cv2.VideoWriter.fourcc(*"mp4v")
    writer = cv2.VideoWriter(str(path), code, RATE, frames.shape[2:0:-1], isColor=True)
    if not writer.isOpened():
        path.unlink(missing_ok=True)
        return False
    for frame, seconds in zip(frames, _times(len(frames)), strict=True):
        for _ in range(max(1, round(seconds * RATE))):
            writer.write(_blue_first(frame))
    writer.release()
    return path.is_file() and path.stat().st_size > 0


def _blue_first(frame: Frames) -> Frames:
    """Make what OpenCV writes of a frame (H, W) or (H, W, 3)."""
    if frame.ndim == 2:
        return np.repeat(frame[..., None], 3, axis=2)
    return np.ascontiguousarray(frame[..., ::-1])


def _times(count: int) -> list[float]:
    """Seconds for which each picture stands."""
    times = [SECONDS / max(count - 1, 1)] * count
    times[0] += HOLD
    times[-1] += HOLD
    return times
