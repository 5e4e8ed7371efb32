"""What the report says about each figure, and where it stands."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Caption:
    """Text under a figure.

    Attributes
    ----------
    group : str
        Heading of the part of the report that it belongs to.
    text : str
    """

    group: str
    text: str


_STRAIN, _DISPLACEMENT, _SHAPES = "Strain", "Displacement", "The two shapes"
CHECKS, _FLAT = "Can it be trusted?", "Flattening"
"""The status of the points is shown under the first."""
_ALONG = (
    "Displacement {} along the {} axis of the reference file, mm: deformed minus reference "
    "position after alignment, drawn on the deformed shape."
)
_ON = " on the tangent plane of the reference surface, no unit, drawn on the deformed shape."

CAPTIONS = {
    "E1": Caption(_STRAIN, "Larger principal Green–Lagrange strain E₁" + _ON),
    "E2": Caption(_STRAIN, "Smaller principal Green–Lagrange strain E₂" + _ON),
    "displacement": Caption(
        _DISPLACEMENT, "Length of the displacement |d| = √(u² + v² + w²), mm, after alignment."
    ),
    "displacement_u": Caption(_DISPLACEMENT, _ALONG.format("u", "x")),
    "displacement_v": Caption(_DISPLACEMENT, _ALONG.format("v", "y")),
    "displacement_w": Caption(_DISPLACEMENT, _ALONG.format("w", "z")),
    "shape_reference": Caption(_SHAPES, "The reference shape with its own pattern."),
    "shape_deformed": Caption(
        _SHAPES, "The deformed shape with its own pattern, laid into the frame of the reference."
    ),
    "correlation": Caption(
        CHECKS,
        "Position of each point in the deformed picture minus that in the reference picture, px; "
        "zero-mean normalised cross-correlation (ZNCC), 1 is best; why points have no value.",
    ),
    "histograms": Caption(
        CHECKS, "How strain (no unit), displacement (mm) and correlation spread over the points."
    ),
    "matches": Caption(
        CHECKS, "Matched features in the two flattened pictures; an even selection is joined."
    ),
    "morph": Caption(
        CHECKS,
        "A detail of the reference picture, of the deformed picture carried onto it by the warp, "
        "and of both in red and cyan: grey where they agree.",
    ),
    "flattening": Caption(
        _FLAT,
        "Area change log₂(σ₁σ₂ / scale²) and anisotropy σ₁/σ₂ of each triangle, no unit; "
        "0 and 1 are ideal.",
    ),
}
"""In the order of the report."""


_FORMING = "Forming"

ON_REQUEST = {
    "fields": Caption(
        _STRAIN,
        "Displacement u, v, w along x, y, z and its length, mm, and principal Green–Lagrange "
        "strains, no unit, over the first left picture.",
    ),
    "forming_limits": Caption(
        _FORMING,
        "Forming-limit diagram: major over minor Hencky strain of every point, the limit curve "
        "where one is given, and the point nearest to it or beyond it.",
    ),
    "limit_margin": Caption(
        _FORMING,
        "Margin to the forming-limit curve, limit(ε₂) − ε₁, Hencky, no unit; negative beyond it; "
        "grey where the curve says nothing.",
    ),
    "thickness": Caption(
        _FORMING,
        "Thickness t = t₀ exp(ε₃) of the sheet, mm, from the nominal thickness t₀ and constant "
        "volume.",
    ),
}
"""Figures of what not every run asks for."""

SECTION = "section_"
"""The names of the figures of sections begin so."""


def caption_of(name: str) -> Caption:
    """Caption of a figure by the name of its file, without suffix; its own name if unknown."""
    if name.startswith(SECTION):
        return Caption(
            _FORMING,
            f"Section {name.removeprefix(SECTION)}: shapes, displacement (mm, after alignment), "
            "principal Green–Lagrange strains and thinning along the cut; bands of two standard "
            "deviations, random part.",
        )
    known = CAPTIONS | ON_REQUEST
    return known.get(name, Caption("More figures", name.replace("_", " ")))


def report_order(name: str) -> tuple[int, str]:
    """Sort key of a figure: known ones in the order of the report, the others after them."""
    names = [*CAPTIONS]
    names[_AFTER_STRAIN:_AFTER_STRAIN] = [*ON_REQUEST, SECTION]
    known = SECTION if name.startswith(SECTION) else name
    return (names.index(known) if known in names else len(names), name)


_AFTER_STRAIN = list(CAPTIONS).index("displacement")
