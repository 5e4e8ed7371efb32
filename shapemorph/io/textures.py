"""Textures of a mesh: finding the pictures, bringing UVs into them, refusing blank ones."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PureWindowsPath

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import FileMesh, Wrap
from shapemorph.io.images import PICTURE_SUFFIXES, Picture, read_picture

_LARGEST_UV = 1e4  # beyond it single precision does not resolve texels
_MAX_UNROLLED = 1 << 28  # texels
_SAMPLES = 20_000
_BLANK = 0.5 / 255.0  # standard deviation below half a grey level of 8 bits


def find_picture(named: str, folder: Path) -> tuple[Path, str | None]:
    """Find the picture that a mesh or material file names.

    Parameters
    ----------
    named : str
        As written in the file: relative or absolute, slashes of either kind.
    folder : Path
        Where the naming file lies.

    Returns
    -------
    path : Path
    note : str or None
        If the picture lies elsewhere than the file says.

    Raises
    ------
    DataError
        If there is no such picture.
    """
    windows = PureWindowsPath(named)
    try:
        for candidate in (folder / named, folder / windows.as_posix()):
            if candidate.is_file():
                return candidate, None
        beside = [entry for entry in _listing(folder) if entry.name.lower() == windows.name.lower()]
    except (OSError, ValueError):  # a name that no file can have
        beside = []
    if beside:
        return beside[0], f"texture {named} is not there; {beside[0].name} beside the mesh is used"
    raise DataError(
        f"texture {named!r} does not exist in {folder}: put the picture there or correct its name "
        "in the mesh or material file"
    )


def find_obvious_picture(mesh: Path) -> tuple[Path, str]:
    """Find the picture that must be the texture of a mesh which names none.

    Its name has the stem of the mesh, or contains it, or it is the only picture beside it.

    Returns
    -------
    path : Path
    note : str

    Raises
    ------
    DataError
        If there is none or several would do.
    """
    stem = mesh.stem.lower()
    pictures = [p for p in _listing(mesh.parent) if p.suffix.lower() in PICTURE_SUFFIXES]
    choices = {
        "it has the name of the mesh": [p for p in pictures if p.stem.lower() == stem],
        "its name contains that of the mesh": [p for p in pictures if stem in p.stem.lower()],
        "it is the only picture in the folder": pictures,
    }
    for reason, found in choices.items():
        if len(found) == 1:
            return found[0], f"no material names a texture; {found[0].name} is used: {reason}"
    seen = ", ".join(p.name for p in pictures[:5]) or "none"
    raise DataError(
        f"{mesh.name}: expected a material file with a map_Kd line or one picture named like the "
        f"mesh, got pictures: {seen}; name one {mesh.stem}.png"
    )


def load_textures(paths: Sequence[Path], channel: str) -> tuple[Picture, ...]:
    """Read each picture; a channel of its colour becomes grey."""
    return tuple(read_picture(path, channel) for path in paths)


def into_pictures(mesh: FileMesh, name: str) -> FileMesh:
    """Bring all UVs into [0, 1], the way the picture goes on beyond its border.

    A face that lies beyond is moved back by whole pictures; for faces that cross the border
    the picture itself is continued.

    Raises
    ------
    DataError
        If a UV is not finite, or far beyond what a repeated picture explains.
    """
    _check_uv(mesh.wedge_uv, name)
    slack = np.array([[0.5 / side for side in t.shape[::-1]] for t in mesh.textures])
    beyond = _beyond(mesh.wedge_uv, slack[mesh.face_texture])
    if not beyond.any():
        return replace(mesh, wedge_uv=np.clip(mesh.wedge_uv, 0.0, 1.0))
    count = int(beyond.sum())
    note = f"{count} faces have UVs outside [0, 1]: the texture is taken to {mesh.wrap}"
    if mesh.wrap == "clamp":
        return replace(mesh, wedge_uv=np.clip(mesh.wedge_uv, 0.0, 1.0), notes=(*mesh.notes, note))
    uv = mesh.wedge_uv.copy()
    period = 2.0 if mesh.wrap == "mirror" else 1.0
    uv[beyond] -= np.floor((uv[beyond].min(axis=1) + 1e-9) / period)[:, None, :] * period
    textures = []
    for row, texture in enumerate(mesh.textures):
        mine = mesh.face_texture == row
        top = uv[mine].max(axis=(0, 1), initial=0.0) - slack[row]
        unrolled = _unroll(texture, top, mesh.wrap, name)
        uv[mine] *= np.array(texture.shape[::-1]) / np.array(unrolled.shape[::-1])
        textures.append(unrolled)
    return replace(
        mesh,
        wedge_uv=np.clip(uv, 0.0, 1.0),
        textures=tuple(textures),
        notes=(*mesh.notes, note),
    )


def check_not_blank(mesh: FileMesh, name: str) -> None:
    """Refuse a mesh whose grey is the same everywhere on its surface, and whose colour is."""
    used = _sampled_grey(mesh) if mesh.textures else mesh.corner_grey.ravel()
    spread = float(np.std(used))
    if spread < _BLANK and not max(mesh.content, default=0.0) > 0:
        raise DataError(
            f"{name}: expected a pattern to follow, got a blank {mesh.grey_source} (standard "
            f"deviation {spread * 255:.2f} grey levels of 255 where the surface uses it): check "
            "that the right texture belongs to the mesh"
        )


def _listing(folder: Path) -> list[Path]:
    return sorted(entry for entry in folder.iterdir() if entry.is_file())


def _check_uv(uv: Floats, name: str) -> None:
    largest = float(np.abs(uv).max(initial=0.0))
    if not largest <= _LARGEST_UV:
        raise DataError(
            f"{name}: expected texture coordinates near [0, 1], got {largest:.3g}: export the "
            "mesh with normalised UVs"
        )


def _beyond(uv: Floats, slack: Floats) -> Bools:
    """Faces with a corner more than half a texel outside the picture."""
    one, two, three = np.moveaxis(uv, 1, 0)
    low = np.minimum(np.minimum(one, two), three)
    high = np.maximum(np.maximum(one, two), three)
    outside = (low < -slack) | (high > 1.0 + slack)
    either: Bools = outside[:, 0] | outside[:, 1]
    return either


def _unroll(texture: Greys, top: Floats, wrap: Wrap, name: str) -> Greys:
    """Continue a picture to the right and upwards so that it covers [0, top]."""
    height, width = texture.shape
    columns = max(width, int(np.ceil(top[0] * width)))
    rows = max(height, int(np.ceil(top[1] * height)))
    if (rows, columns) == (height, width):
        return texture
    if rows * columns > _MAX_UNROLLED:
        raise DataError(
            f"{name}: expected faces that cover a few repeats of the texture, got one that needs "
            f"{columns / width:.0f} x {rows / height:.0f}: export the mesh with UVs in [0, 1]"
        )
    up = _continued(rows, height, wrap)[::-1]  # rows counted from the bottom, stored from the top
    across = _continued(columns, width, wrap)
    return np.ascontiguousarray(texture[np.ix_(height - 1 - up, across)])


def _continued(count: int, period: int, wrap: Wrap) -> Ints:
    """Index into one period of each of `count` places of the continued picture."""
    place = np.arange(count)
    if wrap == "mirror":
        folded = place % (2 * period)
        return np.minimum(folded, 2 * period - 1 - folded)
    return place % period


def _sampled_grey(mesh: FileMesh) -> Floats:
    """Grey at points spread over the faces."""
    weights = _spread_weights(max(7, -(-_SAMPLES // len(mesh.faces))))
    some = slice(None, None, max(1, len(mesh.faces) // _SAMPLES))
    wedge_uv, face_texture = mesh.wedge_uv[some], mesh.face_texture[some]
    grey = []
    for row, texture in enumerate(mesh.textures):
        uv = np.einsum("sk,fkc->fsc", weights, wedge_uv[face_texture == row])
        height, width = texture.shape
        column = np.clip((uv[..., 0] * width).astype(np.int64), 0, width - 1)
        line = np.clip(((1.0 - uv[..., 1]) * height).astype(np.int64), 0, height - 1)
        grey.append(texture[line, column].ravel().astype(np.float64))
    return np.concatenate(grey)


def _spread_weights(count: int) -> Floats:
    """Barycentric weights (count, 3) spread evenly over a triangle (additive recurrence)."""
    steps = np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])
    pair = steps % 1.0
    folded = np.where(pair.sum(axis=1, keepdims=True) > 1.0, 1.0 - pair, pair)
    return np.concatenate([folded, 1.0 - folded.sum(axis=1, keepdims=True)], axis=1)
