"""One door to all flattenings: by name, or the one that suits best."""

from collections.abc import Callable

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.charting import to_principal_axes, to_unit_scale
from shapemorph.methods.parametrize.arap import parametrise_arap
from shapemorph.methods.parametrize.automatic import (
    Flattening,
    flatten_automatically,
    judge,
    mend_and_judge,
)
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.conformal_lscm import parametrise_lscm
from shapemorph.methods.parametrize.cylindrical import parametrise_cylindrical
from shapemorph.methods.parametrize.disk import Piece, boundary_loops, require_disk
from shapemorph.methods.parametrize.harmonic_disk import parametrise_on_disk
from shapemorph.methods.parametrize.orthographic import parametrise_orthographic
from shapemorph.methods.parametrize.profile import parametrise_profile
from shapemorph.methods.parametrize.slim import parametrise_slim
from shapemorph.methods.parametrize.spherical import parametrise_spherical

FREE: dict[str, Callable[[Floats, Ints], Floats]] = {
    "bff": parametrise_boundary_first,
    "lscm": parametrise_lscm,
    "arap": parametrise_arap,
    "slim": parametrise_slim,
    "harmonic": parametrise_on_disk,
}
"""Flattenings that know no axis: turned and scaled afterwards."""

MOST_CRUDE = 2.0  # shear that a given meridian may add to that of the mesh's own
PROJECTIONS = ("orthographic", "spherical", "cylindrical", "profile")
"""Flattenings that keep their axes and their millimetres."""


def lay_flat(  # noqa: PLR0913 - one for each choice
    vertices: Floats,
    faces: Ints,
    *,
    name: str,
    method: str,
    axis: Floats | None,
    centre: Floats | None,
    projection: str,
    meridian: Floats | None,
    most_lost: float,
    most_anisotropy: float,
    most_reduced: float,
    made: Flattening | None = None,
) -> tuple[Flattening, str]:
    """Flatten one piece by the method that is asked for and say how well it lies.

    Parameters
    ----------
    vertices : (V, 3)
        mm, every one used.
    faces : (F, 3)
        A disk with holes (any surface for a parallel projection).
    name : str
        What errors call the mesh.
    method : str
        ``auto``, or a key of :data:`FREE` or :data:`PROJECTIONS`.
    axis, centre : (3,) or None
        Of the projections, in the frame of the vertices; None: fitted.
    projection : str
        Kind of the spherical map.
    meridian : (K, 2) or None
        r, z of a known meridian, mm; None: measured.
    most_lost, most_anisotropy, most_reduced : float
        When ``auto`` takes a map for sound, see :func:`flatten_automatically`.
    made : Flattening, optional
        The boundary-first map of this piece, if it has been made already.

    Returns
    -------
    Flattening
        In its own unit and orientation, see :func:`place`.
    str
        Why this one, for people.

    Raises
    ------
    DataError
        If the surface cannot lie flat in this way.
    StageError
        If the method finds no map.
    """
    if method == "orthographic":
        plane = parametrise_orthographic(vertices, faces, axis=axis)
        return _as_asked(judge(vertices, faces, plane, method))
    if made is None:
        require_disk(faces, boundary_loops(faces, name=name), name=name)
    if method == "auto":
        return flatten_automatically(
            vertices,
            faces,
            most_lost=most_lost,
            most_anisotropy=most_anisotropy,
            most_reduced=most_reduced,
            made=made,
        )
    if method == "bff" and made is not None:
        return _as_asked(made)
    if method == "profile":
        return _lay_by_profile(vertices, faces, axis, centre, meridian, most_lost)
    if method == "spherical":
        plane = parametrise_spherical(
            vertices, faces, centre=centre, axis=axis, projection=projection
        )
    elif method == "cylindrical":
        plane = parametrise_cylindrical(vertices, faces, centre=centre, axis=axis, name=name)
    else:
        plane = FREE[method](vertices, faces)
    return _as_asked(mend_and_judge(vertices, faces, plane, method))


def _as_asked(flattening: Flattening) -> tuple[Flattening, str]:
    return flattening, f"{flattening.describe()}, as asked"


def _lay_by_profile(
    vertices: Floats,
    faces: Ints,
    axis: Floats | None,
    centre: Floats | None,
    meridian: Floats | None,
    most_lost: float,
) -> tuple[Flattening, str]:
    """Flatten by the given meridian where it is near the mesh's own, else by that one."""
    plane = parametrise_profile(vertices, faces, centre=centre, axis=axis, meridian=None)
    own = mend_and_judge(vertices, faces, plane, "profile")
    if meridian is None:
        return own, f"{own.describe()}, by the meridian of the mesh, as asked"
    plane = parametrise_profile(vertices, faces, centre=centre, axis=axis, meridian=meridian)
    given = mend_and_judge(vertices, faces, plane, "profile")
    if given.lost <= most_lost and given.anisotropy <= MOST_CRUDE * own.anisotropy:
        return given, f"{given.describe()}, by the given meridian, as asked"
    return own, (
        f"{own.describe()}, by the meridian of the mesh (the given one does not fit it: "
        f"{given.describe()})"
    )


def place(vertices: Floats, piece: Piece, flattening: Flattening) -> Floats:
    """Turn and scale a map; a projection keeps its axes and its millimetres.

    Parameters
    ----------
    vertices : (V, 3)
        Of the mesh, mm.
    piece : Piece
        What was flattened.
    flattening : Flattening

    Returns
    -------
    (N, 2)
        mm, x right, y up.

    Raises
    ------
    StageError
        If no triangle lies the right way up.
    """
    scaled = to_unit_scale(vertices, piece, flattening.plane)
    if flattening.method in PROJECTIONS:
        return flattening.plane
    return to_principal_axes(vertices, piece, scaled)
