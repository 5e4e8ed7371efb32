"""Pictures from and to the disk: any bit depth and colour model becomes grey in [0, 1]."""

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Greys
from shapemorph.core.errors import DataError
from shapemorph.core.image import GreyImage
from shapemorph.io.decoding import lenient_pillow
from shapemorph.methods.colour_content import CHANNELS, gradient_content

PICTURE_SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".webp", ".tga")

_MAX_PIXELS = 1 << 29
_PNG_LEVEL = 1  # of zlib; 6 takes three times as long for a tenth less
_MAX_PIXELS_PER_BYTE = 5000  # the best that deflate or run lengths do on real formats
_TIFF_MARKS = (b"II", b"MM")
_OTHER_MARKS = (b"\x89PNG", b"\xff\xd8", b"BM", b"RIFF")  # PNG, JPEG, BMP, WebP
_EXPECTED = "PNG, TIFF, JPEG, BMP, WebP or TGA"


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A decoded picture.

    Attributes
    ----------
    grey : (H, W) float32
        In [0, 1], row 0 on top.
    opaque : (H, W) bool
        Where alpha is at least one half; everywhere without alpha.
    notes : tuple of str
        One sentence each for what a user should know.
    content : tuple of float
        Gradient content of its channels, see
        :func:`~shapemorph.methods.colour_content.gradient_content`; empty for a grey one.
    """

    grey: Greys
    opaque: Bools
    notes: tuple[str, ...]
    content: tuple[float, ...] = ()


def read_grey_image(path: Path) -> GreyImage:
    """Read a plain picture as grey levels; transparent pixels are outside the mask.

    Colour becomes grey by the Rec. 709 luma of the stored values; 16-bit pictures are scaled
    by their full range.

    Raises
    ------
    DataError
        If the file is missing, truncated or not a picture.
    """
    picture = read_picture(path)
    return GreyImage(picture.grey, picture.opaque)


def read_white(path: Path) -> Bools:
    """Read a mask: True where the picture is lighter than middle grey, and opaque.

    Raises
    ------
    DataError
        As :func:`read_grey_image`; and if it is white nowhere.
    """
    picture = read_grey_image(path)
    white: Bools = (picture.grey > 0.5) & picture.mask
    if not white.any():
        raise DataError(f"mask {path}: expected white where to measure, got none")
    return white


def read_picture(path: Path, channel: str = "luma", *, page: int | None = None) -> Picture:
    """Read a picture file with notes on what had to be decided; see :func:`decode_picture`."""
    data = read_bytes(path, what="picture")
    return decode_picture(data, name=path.name, channel=channel, page=page)


def read_bytes(path: Path, *, what: str) -> bytes:
    """Read a whole file, or say what is wrong with its path."""
    if path.is_dir():
        raise DataError(f"expected a {what} file, got the folder {path}: name the file in it")
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise DataError(f"{what} file {path} does not exist: check the path") from None
    except (OSError, ValueError) as error:
        raise DataError(f"{what} file {path} cannot be read ({error})") from None
    if not data:
        raise DataError(f"{what} file {path} is empty: export it again")
    return data


def write_grey_png(path: Path, grey: Greys, mask: Bools) -> None:
    """Write grey levels as an 8-bit PNG; outside the mask it is transparent.

    Parameters
    ----------
    path : Path
    grey : (H, W)
        In [0, 1]; clipped.
    mask : (H, W)
        Pixels that mean something.
    """
    if grey.shape != mask.shape or grey.ndim != 2:
        raise DataError(f"grey and mask must have one shape (H, W), got {grey.shape}, {mask.shape}")
    from PIL import Image

    levels = np.where(mask, np.clip(grey, 0.0, 1.0) * 255.0 + 0.5, 0.0).astype(np.uint8)
    opacity = np.where(mask, 255, 0).astype(np.uint8)
    picture = Image.fromarray(levels if mask.all() else np.stack([levels, opacity], axis=2))
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        picture.save(partial, "PNG", compress_level=_PNG_LEVEL)
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        message = f"cannot write the picture {path} ({error}): choose another place"
        raise DataError(message) from None


def decode_picture(
    data: bytes, *, name: str, channel: str = "luma", page: int | None = None
) -> Picture:
    """Decode the bytes of a picture file.

    Parameters
    ----------
    data : bytes
        A whole PNG, TIFF, JPEG, BMP, WebP or TGA file.
    name : str
        What messages call it.
    channel : str
        What of its colour becomes grey: a name in
        :data:`~shapemorph.methods.colour_content.CHANNELS`.
    page : int or None
        Which picture of a file that holds several, from 0; None: the first, with a note.

    Raises
    ------
    DataError
        If the bytes are truncated, damaged or no picture.
    """
    stored, notes = _stored_values(data, name, page)
    values, opaque = _without_alpha(stored)
    scaled, content, scale_notes = _unit_range(values, name, channel)
    if not opaque.all():
        share = 1.0 - float(opaque.mean())
        notes += (f"{name}: {share:.1%} of its pixels are transparent; used as they are stored",)
    return Picture(scaled, opaque, notes + scale_notes, content)


def _stored_values(
    data: bytes, name: str, page: int | None
) -> tuple[np.ndarray[Any, Any], tuple[str, ...]]:
    """Array (H, W) or (H, W, 2..4) in RGB(A) order as the file stores it."""
    from PIL import Image, UnidentifiedImageError

    with lenient_pillow():
        try:
            with Image.open(io.BytesIO(data)) as picture:
                picture.seek(page or 0)
                _check_claimed_size(picture.size, len(data), name)
                deep = _bits(picture, data) > 8
                _check_checksums(picture.format, data)
                picture.load()
                frames = int(getattr(picture, "n_frames", 1))
                array = _pillow_array(picture)
        except UnidentifiedImageError as error:
            if data[:2] in _TIFF_MARKS:
                return _opencv_array(data, name, page or 0), ()
            raise _unrecognised(data, name) from error
        except DataError:
            raise
        except Exception as error:  # noqa: BLE001 decoders raise whatever they like
            raise _damaged(name, error) from None
    if deep and array.dtype == np.uint8:  # pillow drops the lower byte of deep colour
        array = _opencv_array(data, name, page or 0)
    unasked = frames > 1 and page is None
    many = (f"{name}: first of its {frames} pictures used",) if unasked else ()
    return array, many


def _damaged(name: str, error: object) -> DataError:
    reason = " ".join(str(error).split()) or type(error).__name__
    return DataError(
        f"{name}: expected a whole picture ({_EXPECTED}), got a truncated or damaged "
        f"one ({reason[:120]}): export or copy it again"
    )


def _unrecognised(data: bytes, name: str) -> DataError:
    """Tell a picture that lost its header from a file of another kind."""
    if data.startswith(_OTHER_MARKS):
        return _damaged(name, "its header is incomplete")
    return DataError(f"{name} is not a picture: expected {_EXPECTED}")


def _check_claimed_size(size: tuple[int, int], length: int, name: str) -> None:
    """Refuse a small file that would unpack to gigabytes."""
    pixels = size[0] * size[1]
    if pixels == 0 or pixels > _MAX_PIXELS or pixels > length * _MAX_PIXELS_PER_BYTE:
        raise DataError(
            f"{name}: expected a picture of up to {_MAX_PIXELS / 1e6:.0f} megapixels, got a "
            f"header that claims {size[0]} x {size[1]} px in {length} bytes: export it again"
        )


def _check_checksums(file_format: str | None, data: bytes) -> None:
    """Compare the checksums of a PNG, which decoding alone passes over."""
    from PIL import Image

    if file_format == "PNG":
        with Image.open(io.BytesIO(data)) as again:
            again.verify()


def _bits(picture: Any, data: bytes) -> int:
    """Bits per channel in the file."""
    if picture.format == "PNG":
        return data[24]
    if picture.format == "TIFF":
        bits = picture.tag_v2.get(258, (8,))
        return int(max(bits)) if isinstance(bits, tuple) else int(bits)
    return 8


def _pillow_array(picture: Any) -> np.ndarray[Any, Any]:
    mode = picture.mode
    if mode == "1":
        return np.asarray(picture.convert("L"))
    if mode in ("P", "PA"):
        picture = picture.convert("RGBA" if "transparency" in picture.info else "RGB")
    elif mode not in ("L", "LA", "RGB", "RGBA", "F", "I") and not mode.startswith("I;16"):
        picture = picture.convert("RGB")  # CMYK, YCbCr, Lab, HSV, premultiplied
    array = np.asarray(picture)
    if array.ndim not in (2, 3):
        raise DataError(f"expected rows and columns, got an array of shape {array.shape}")
    return array.astype(np.uint16) if mode.startswith("I;16") else array


def _opencv_array(data: bytes, name: str, page: int) -> np.ndarray[Any, Any]:
    """Decode with OpenCV: deep colour, and what pillow does not know."""
    import cv2

    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(0)
    try:
        array = _opencv_page(np.frombuffer(data, dtype=np.uint8), page)
    except cv2.error as error:
        raise _damaged(name, error.err) from None
    finally:
        cv2.utils.logging.setLogLevel(level)
    if array is None or array.size == 0:
        raise DataError(
            f"{name}: expected a picture ({_EXPECTED}), got something else or a damaged "
            "file: export it again"
        )
    decoded: np.ndarray[Any, Any] = np.asarray(array)
    if decoded.ndim == 3 and decoded.shape[2] >= 3:
        decoded = decoded[:, :, [2, 1, 0, 3][: decoded.shape[2]]]
    return decoded


def _opencv_page(data: np.ndarray[Any, Any], page: int) -> np.ndarray[Any, Any] | None:
    import cv2

    if page == 0:
        return cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    _, pages = cv2.imdecodemulti(data, cv2.IMREAD_UNCHANGED, range=(page, page + 1))
    return pages[0] if pages else None


def _without_alpha(stored: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], Bools]:
    """Split off the alpha channel of LA and RGBA arrays."""
    if stored.ndim == 3 and stored.shape[2] == 1:
        stored = stored[:, :, 0]
    if stored.ndim == 2:
        return stored, np.ones(stored.shape, dtype=np.bool_)
    if stored.shape[2] == 3:
        return stored, np.ones(stored.shape[:2], dtype=np.bool_)
    alpha = stored[:, :, -1]
    full = np.iinfo(stored.dtype).max if np.issubdtype(stored.dtype, np.integer) else 1.0
    opaque: Bools = alpha >= full / 2
    colour = stored[:, :, 0] if stored.shape[2] == 2 else stored[:, :, :3]
    return colour, opaque


def _unit_range(
    values: np.ndarray[Any, Any], name: str, channel: str
) -> tuple[Greys, tuple[float, ...], tuple[str, ...]]:
    """Grey in [0, 1], content of channels, and a note where the range had to be guessed."""
    if values.dtype == np.bool_:
        values = values.astype(np.uint8) * np.uint8(255)
    if values.dtype in (np.dtype(np.uint8), np.dtype(np.uint16)):
        full = float(np.iinfo(values.dtype).max)
        return *_levels(values, 0.0, full, channel), ()
    finite = np.isfinite(values)
    if not finite.any():
        raise DataError(f"{name}: expected grey levels, got no finite value: export it again")
    low, high = float(values[finite].min()), float(values[finite].max())
    if low >= 0.0 and high <= 1.0:
        floor, full = 0.0, 1.0
    elif low >= 0.0 and high <= 65535.0:
        floor, full = 0.0, 255.0 if high <= 255.0 else 65535.0
    else:
        floor, full = low, high
    note = f"{name}: values {low:.6g} to {high:.6g} taken as grey from {floor:.6g} to {full:.6g}"
    return *_levels(np.where(finite, values, floor), floor, full, channel), (note,)


def _levels(
    values: np.ndarray[Any, Any], floor: float, full: float, channel: str
) -> tuple[Greys, tuple[float, ...]]:
    """Grey, scaled so that floor..full is 0..1, and the content of the channels of colour."""
    from shapemorph.kernels.luma import mix_channels

    weights = np.ones(1) if values.ndim == 2 else CHANNELS[channel]
    grey: Greys = mix_channels(values.reshape(*values.shape[:2], -1), weights, floor, full)
    if values.ndim == 2:
        return grey, ()
    return grey, tuple(float(each) for each in gradient_content(values, full - floor))
