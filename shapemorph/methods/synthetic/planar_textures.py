"""Flat patterns other than speckle: what grows, what is machined, and what repeats."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Greys

SIZE = 2048  # px; patterns repeat beyond it
FALL = 1.2  # amplitude of cloudy patterns falls with frequency to this power


@dataclass(frozen=True, slots=True, eq=False)
class PlanarTexture:
    """A pattern given by its pixels, of mean 0 and standard deviation 1.

    Attributes
    ----------
    pixels : (S, S) float32
        Repeats beyond its edges.
    """

    pixels: Greys

    def at(self, points: Floats) -> Floats:
        """Evaluate the pattern at material points (..., 2), px, by bicubic interpolation."""
        import cv2

        size = self.pixels.shape[0]
        wrapped = np.pad(self.pixels, 4, mode="wrap")
        place = (points % size + 4).astype(np.float32)
        grey: Floats = cv2.remap(wrapped, place[..., 0], place[..., 1], cv2.INTER_CUBIC).astype(
            np.float64
        )
        return grey


def cloudy(*, width: float, seed: int) -> PlanarTexture:
    """Skin-like pattern without a size of its own, 1/f down to details of `width` px."""
    return _filtered(np.hypot, width, seed)


def wood(*, width: float, seed: int) -> PlanarTexture:
    """Make grain six times longer than wide, oblique, with details of `width` px."""

    def frequency(fx: Floats, fy: Floats) -> Floats:
        along, across = 0.8 * fx + 0.6 * fy, -0.6 * fx + 0.8 * fy
        return np.hypot(6 * along, across)

    return _filtered(frequency, width, seed)


def ground_metal(*, width: float, seed: int) -> PlanarTexture:
    """Scratches of random place, length and strength, mostly along one direction."""
    import cv2

    rng = np.random.default_rng(seed)
    picture = np.zeros((SIZE, SIZE), np.float32)
    count = int(1.5 * SIZE**2 / (12 * width**2))
    starts = rng.uniform(-0.05, 1.05, (count, 2)) * SIZE
    angles, lengths = rng.normal(0.3, 0.12, count), width * rng.gamma(2.0, 6.0, count)
    ends = starts + lengths[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    greys = rng.normal(0.0, 1.0, count)
    thick = max(1, round(0.4 * width))
    for corners, grey in zip(np.rint(16 * np.hstack([starts, ends])), greys, strict=True):
        x0, y0, x1, y1 = (int(v) for v in corners)
        cv2.line(picture, (x0, y0), (x1, y1), float(grey), thick, cv2.LINE_8, 4)
    return _standard(cv2.GaussianBlur(picture, (0, 0), 0.3 * width))


def dead_leaves(*, width: float, seed: int) -> PlanarTexture:
    """Discs that hide each other, of all sizes from `width` to 15 times that, px."""
    import cv2

    rng = np.random.default_rng(seed)
    picture = np.zeros((SIZE, SIZE), np.float32)
    low, high = width / 2, 15 * width / 2
    count = int(6 * SIZE**2 / (np.pi * low * high))
    radii = 1 / np.sqrt(rng.uniform(high**-2, low**-2, count))
    centres = rng.uniform(0, SIZE, (count, 2))
    greys = rng.normal(0, 1, count)
    for centre, radius, grey in zip(centres, radii, greys, strict=True):
        place = tuple(int(v) for v in np.rint(16 * centre))
        cv2.circle(picture, place, round(16 * radius), float(grey), -1, cv2.LINE_8, 4)
    return _standard(cv2.GaussianBlur(picture, (0, 0), 0.6))


def printed_dots(*, pitch: float, other: PlanarTexture | None, share: float) -> PlanarTexture:
    """Equal dots on a square grid, with a share (of the amplitude) of something else on it.

    Parameters
    ----------
    pitch : float
        Distance of the dots, px; made a whole part of the repeat.
    other : PlanarTexture or None
    share : float
    """
    number = round(SIZE / pitch)
    phase = np.arange(SIZE) * (number / SIZE)
    offset = np.minimum(phase % 1, 1 - phase % 1)
    distance = np.hypot(offset[:, None], offset[None, :])
    dots = _standard(1 / (1 + np.exp((distance - 0.3) * 20)))
    if other is None:
        return dots
    return _standard((1 - share) * dots.pixels + share * other.pixels)


def _filtered(
    frequency: Callable[[Floats, Floats], Floats], width: float, seed: int
) -> PlanarTexture:
    white = np.random.default_rng(seed).standard_normal((SIZE, SIZE))
    fx, fy = np.fft.rfftfreq(SIZE), np.fft.fftfreq(SIZE)
    radius = frequency(*np.meshgrid(fx, fy))
    radius = np.maximum(radius, 1 / SIZE)
    gain = radius**-FALL * np.exp(-2 * (0.3 * width * np.pi * radius) ** 2)
    return _standard(np.fft.irfft2(np.fft.rfft2(white) * gain, s=(SIZE, SIZE)))


def _standard(picture: Floats | Greys) -> PlanarTexture:
    scaled = (picture - picture.mean()) / picture.std()
    return PlanarTexture(np.ascontiguousarray(scaled, np.float32))
