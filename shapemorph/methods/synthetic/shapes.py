"""The material maps by name."""

from shapemorph.core.errors import ConfigError
from shapemorph.methods.synthetic.balloon import balloon
from shapemorph.methods.synthetic.curved import freeform, freeform_of_name, rigid, tube
from shapemorph.methods.synthetic.material import MaterialMap
from shapemorph.methods.synthetic.revolution import bulge, dome, hole, indentation
from shapemorph.methods.synthetic.sheet import sheet_of_name

PLAIN_SHAPES = {
    "dome": dome,
    "bulge": bulge,
    "freeform": freeform,
    "hole": hole,
    "tube": tube,
    "rigid": rigid,
    "balloon": balloon,
}


def material_map(shape: str, *, size: float, offset: float, tilt: float) -> MaterialMap:
    """Make the material map of a shape.

    Parameters
    ----------
    shape : str
        One of the names, or that of a drawn sheet or a turned free form (`sheet_name`,
        `freeform_name`).
    size : float
        Diameter or length of the object, mm.
    offset, tilt : float
        Of the punch of the indentation, mm and radians; the others do not read them.

    Raises
    ------
    ConfigError
        If there is no such shape, or the punch lies too near the clamp.
    """
    if shape == "indentation":
        if abs(offset) > 0.2 * size:
            raise ConfigError(
                f"the punch must stay within 0.2 of the size from the centre, got an offset of "
                f"{offset:g} mm for {size:g} mm: lower synthesize.offset"
            )
        return indentation(size, offset=offset, tilt=tilt)
    directed = sheet_of_name(shape, size) or freeform_of_name(shape, size)
    if directed is not None:
        return directed
    if shape not in PLAIN_SHAPES:
        known = ", ".join(sorted([*PLAIN_SHAPES, "indentation"]))
        raise ConfigError(f"shape must be one of {known}, got {shape!r}")
    return PLAIN_SHAPES[shape](size)
