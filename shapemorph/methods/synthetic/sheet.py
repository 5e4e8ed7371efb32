"""Material map of a flat sheet, drawn evenly along one direction: as anisotropic as wanted."""

import re

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.material import Embedding, MaterialMap, no_kink
from shapemorph.methods.synthetic.revolution import flat, rectangle

WIDTH = 0.7  # of the sheet over its length
_NAME = re.compile(r"sheet\(([-+.e\d]+), ([-+.e\d]+), ([-+.e\d]+)\)")


def sheet_name(*, stretch: float, direction: float, turn: float) -> str:
    """Name of a drawn sheet that says all about it, for the files of the truth.

    Parameters
    ----------
    stretch : float
    direction, turn : float
        Degrees, as for :func:`sheet`.
    """
    return f"sheet({stretch!r}, {direction!r}, {turn!r})"


def sheet_of_name(name: str, size: float) -> MaterialMap | None:
    """Make the sheet of a name; None if it is the name of something else."""
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    stretch, direction, turn = (float(text) for text in found.groups())
    return sheet(size, stretch=stretch, direction=direction, turn=turn)


def sheet(size: float, *, stretch: float, direction: float, turn: float) -> MaterialMap:
    """Make a flat sheet, stretched to `stretch` along a direction and 1/sqrt of it across.

    Parameters
    ----------
    size : float
        Length of the sheet, mm; its width is 0.7 of that.
    stretch : float
    direction : float
        Of the stretch, from the long side of the sheet, degrees.
    turn : float
        In the plane after stretching, degrees.
    """
    half = np.array([0.5, 0.5 * WIDTH]) * size
    axes = _rotation(direction)
    matrix = _rotation(turn) @ axes @ np.diag([stretch, stretch**-0.5]) @ axes.T

    def rim(material: Floats) -> Floats:
        nearest: Floats = (half - np.abs(material)).min(axis=1)
        return nearest

    return MaterialMap(
        lower=-half,
        upper=half,
        period=None,
        reference=flat,
        deformed=_drawn(matrix),
        rim=rim,
        loops=(rectangle(-half, half),),
        locate=lambda points: points[:, :2].copy(),
        flat=True,
        kink=no_kink,
        kink_loops=(),
        pole=np.zeros(2),
    )


def _drawn(matrix: Floats) -> Embedding:
    """Map the plane z = 0 by a matrix (2, 2)."""

    def embed(material: Floats) -> tuple[Floats, Floats]:
        position, jacobian = flat(material)
        position[:, :2] = material @ matrix.T
        jacobian[:, :2] = matrix
        return position, jacobian

    return embed


def _rotation(degrees: float) -> Floats:
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return np.array([[cosine, -sine], [sine, cosine]])
