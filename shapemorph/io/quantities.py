"""What every array of the result files is: symbol, unit, formula, source.

The writers take columns and units from here, and docs/outputs.md is written from it. An
array that is new in a result file gets a line here.
"""

from collections.abc import Sequence
from dataclasses import dataclass

_XYZ, _UVW, _XY = "xyz", "uvw", "xy"


@dataclass(frozen=True, slots=True)
class Quantity:
    """One array with a row for each point.

    Attributes
    ----------
    name : str
        In measurement.vtp, .npz and .mat.
    symbol, formula, source : str
        As docs/outputs.md shows them.
    unit : str
        "mm", "px", or "1" where it has none.
    kind : str
        Type of its numbers.
    only_with : str
        Setting without which it is not there; empty: always there.
    column : str
        Name in measurement.csv; with ``{}`` for the letter of a component, empty where it
        is not in the table.
    letters : sequence of str
        One for each component; empty: a scalar.
    components : int
        1 for scalars.
    """

    name: str
    symbol: str
    unit: str
    formula: str
    source: str
    column: str = ""
    letters: Sequence[str] = ""
    components: int = 1
    kind: str = "float64"
    only_with: str = ""

    @property
    def columns(self) -> tuple[str, ...]:
        """Names in measurement.csv."""
        if not self.column:
            return ()
        letters = self.letters or ("",)
        return tuple(self.column.format(letter) for letter in letters)


_GRID, _LIFT, _STRAIN = "`correlate`", "`lift`", "`strain`: fit over the window"
_LIFTED_NOISE = "`correlate`, `lift`: correlation and mesh noise"
_GREEN = "Green–Lagrange, E = (FᵀF − I)/2 on the tangent plane of the reference"


def _scalar(name: str, symbol: str, formula: str, source: str) -> Quantity:
    return Quantity(name, symbol, "1", formula, source, name)


def _vector(name: str, symbol: str, formula: str, source: str) -> Quantity:
    return Quantity(name, symbol, "1", formula, source, components=3)


def _placed(
    name: str, symbol: str, formula: str, source: str, *, column: str, letters: str
) -> Quantity:
    unit = column.rpartition("_")[2]
    return Quantity(name, symbol, unit, formula, source, column, letters, len(letters))


def _tensor(name: str, symbol: str, formula: str) -> Quantity:
    column = name.removesuffix("_tangent") + "_{}"
    return Quantity(name, symbol, "1", formula, _STRAIN, column, ("11", "22", "12"), 3)


def _noise(name: str, symbol: str, formula: str) -> Quantity:
    return Quantity(name, symbol, "1", f"{formula}; 1 σ, random part", "sigma_E1, sigma_E2")


def _spatial(name: str, symbol: str, formula: str) -> Quantity:
    return Quantity(name, symbol, "mm", formula, _LIFTED_NOISE, components=3)


REFERENCE = _placed(
    *("points", "X", "reference position, frame of the reference file; for lost points too"),
    source="`lift`: calibrated reference image",
    column="{}_ref_mm",
    letters=_XYZ,
)
"""Positions of the points, which are no point array in VTK."""

QUANTITIES: tuple[Quantity, ...] = (
    _placed(
        *("deformed_position", "x", "deformed position, frame of the deformed file"),
        source="`lift`: calibrated deformed image",
        column="{}_def_mm",
        letters=_XYZ,
    ),
    _placed(
        *("displacement", "u, v, w", "u = R x + t − X; R, t: the alignment"),
        source="`lift`, `align`",
        column="{}_mm",
        letters=_UVW,
    ),
    _placed(
        *("reference_px", "p", "position in the flattened reference image of its chart"),
        source=_GRID,
        column="{}_ref_px",
        letters=_XY,
    ),
    _placed(
        *("deformed_px", "q", "position in the flattened deformed image of its chart"),
        source=_GRID,
        column="{}_def_px",
        letters=_XY,
    ),
    Quantity(
        *("chart", "k", "1", "number of the chart (page) of the point", "`flatten`", "chart"),
        kind="int64",
    ),
    Quantity(
        *("status", "–", "1", "0 = OK; codes in CONVENTIONS.md", "all stages", "status"),
        kind="uint8",
    ),
    _scalar("E1", "E₁", f"larger principal value; {_GREEN}", _STRAIN),
    _scalar("E2", "E₂", f"smaller principal value; {_GREEN}", _STRAIN),
    _scalar("hencky_1", "ε₁", "Hencky (true, logarithmic), ln λ₁", "E1"),
    _scalar("hencky_2", "ε₂", "Hencky (true, logarithmic), ln λ₂", "E2"),
    _scalar("stretch_1", "λ₁", "√(1 + 2 E₁): deformed over reference length", "E1"),
    _scalar("stretch_2", "λ₂", "√(1 + 2 E₂): deformed over reference length", "E2"),
    _scalar("thickness_strain", "ε₃", "−(ε₁ + ε₂): Hencky, constant volume", "E1, E2"),
    _scalar("anisotropy", "D_A", "E₁/E₂; NaN where |E₂| ≤ 3 σ(E₂)", "E1, E2"),
    _scalar("zncc", "ZNCC", "zero-mean normalised cross-correlation of the subsets", _GRID),
    _scalar("iterations", "–", "iterations of IC-GN until it settled", _GRID),
    Quantity(
        "sigma_displacement",
        "σ(u)",
        "mm",
        "1 σ of one component of the displacement, rms over the three; random part",
        _LIFTED_NOISE,
        "sigma_displacement_mm",
    ),
    _scalar("sigma_E1", "σ(E₁)", "1 σ, random part, through the fit", _STRAIN),
    _scalar("sigma_E2", "σ(E₂)", "1 σ, random part, through the fit", _STRAIN),
    _vector(
        "direction_1",
        "N₁",
        "unit direction of E₁ on the reference, frame of its file; NaN where E₁ − E₂ is noise",
        _STRAIN,
    ),
    _vector(
        "direction_1_deformed",
        "n₁",
        "F N₁ / |F N₁| on the deformed shape, frame of its file",
        _STRAIN,
    ),
    _scalar("engineering_1", "λ₁ − 1", "engineering (technical): change over length", "E1"),
    _scalar("engineering_2", "λ₂ − 1", "engineering (technical): change over length", "E2"),
    _scalar("biot_1", "B₁", "Biot, principal value of U − I = √(FᵀF) − I: λ₁ − 1", "E1"),
    _scalar("biot_2", "B₂", "Biot, principal value of U − I = √(FᵀF) − I: λ₂ − 1", "E2"),
    _scalar("almansi_1", "e₁", "Euler–Almansi, e = (I − F⁻ᵀF⁻¹)/2: (1 − λ₁⁻²)/2", "E1"),
    _scalar("almansi_2", "e₂", "Euler–Almansi, e = (I − F⁻ᵀF⁻¹)/2: (1 − λ₂⁻²)/2", "E2"),
    _scalar("shear_max", "E₁₂ max", "largest tensor shear of Green–Lagrange, (E₁ − E₂)/2", "E1"),
    Quantity(
        *("shear_angle", "γ", "rad"),
        "largest change of a right angle: arcsin((λ₁² − λ₂²)/(λ₁² + λ₂²))",
        "E1, E2",
        "shear_angle_rad",
    ),
    _scalar("area_ratio", "J", "λ₁ λ₂: deformed over reference area", "E1, E2"),
    _tensor("E_tangent", "E₁₁, E₂₂, E₁₂", f"{_GREEN}, in the basis tangent_1, tangent_2"),
    _placed(
        *("sigma_uvw", "σ(u), σ(v), σ(w)", "1 σ of each component; alignment taken as exact"),
        source=_LIFTED_NOISE,
        column="sigma_{}_mm",
        letters=_UVW,
    ),
    _tensor("sigma_E_tangent", "σ(E₁₁), σ(E₂₂), σ(E₁₂)", "1 σ, random part, through the fit"),
    _noise("sigma_hencky_1", "σ(ε₁)", "σ(E₁)/λ₁²"),
    _noise("sigma_hencky_2", "σ(ε₂)", "σ(E₂)/λ₂²"),
    _noise("sigma_stretch_1", "σ(λ₁)", "σ(E₁)/λ₁; engineering and Biot strain have the same"),
    _noise("sigma_stretch_2", "σ(λ₂)", "σ(E₂)/λ₂; engineering and Biot strain have the same"),
    _noise("sigma_almansi_1", "σ(e₁)", "σ(E₁)/λ₁⁴"),
    _noise("sigma_almansi_2", "σ(e₂)", "σ(E₂)/λ₂⁴"),
    _noise("sigma_shear_max", "σ(E₁₂ max)", "σ(E₁ − E₂)/2, along fixed axes"),
    _noise("sigma_area_ratio", "σ(J)", "J σ(ε₃)"),
    _noise("sigma_thickness_strain", "σ(ε₃)", "of ε₁ + ε₂, with their covariance"),
    _spatial("sigma_points", "σ(X)", "1 σ of each coordinate: the reference mesh, across it"),
    _spatial(
        *("sigma_deformed_position", "σ(x)"),
        "1 σ of each coordinate, against the true place of the material at the reference position",
    ),
    _scalar("thinning", "1 − t/t₀", "1 − exp(ε₃): share of the thickness that is lost", "E1, E2"),
    Quantity(
        *("thickness", "t", "mm", "t₀ exp(ε₃)", "E1, E2, strain.thickness", "thickness_mm"),
        only_with="strain.thickness",
    ),
    Quantity(
        *("sigma_thickness", "σ(t)", "mm", "t σ(ε₃); t₀ taken as exact"),
        *("sigma_thickness_strain", "sigma_thickness_mm"),
        only_with="strain.thickness",
    ),
    Quantity(
        *("limit_margin", "Δε₁", "1"),
        "limit(ε₂) − ε₁: Hencky strain left before the forming-limit curve; NaN beyond its ends",
        *("hencky_1, hencky_2, forming.limit_curve", "limit_margin"),
        only_with="forming.limit_curve",
    ),
    Quantity(
        *("sigma_limit_margin", "σ(Δε₁)", "1", "1 σ, random part; the curve taken as exact"),
        *("sigma_E1, sigma_E2", "sigma_limit_margin"),
        only_with="forming.limit_curve",
    ),
    _vector("tangent_1", "T₁", "first unit vector of the basis of `E_tangent`, reference", _STRAIN),
    _vector("tangent_2", "T₂", "second unit vector of the basis of `E_tangent`", _STRAIN),
    _vector("direction_2", "N₂", "unit direction of E₂ on the reference, likewise", _STRAIN),
    _vector("direction_2_deformed", "n₂", "F N₂ / |F N₂|, across n₁", _STRAIN),
)

FACET_ARRAYS = (
    *("E1", "E2", "hencky_1", "hencky_2", "stretch_1", "stretch_2", "thickness_strain"),
    *("engineering_1", "engineering_2", "biot_1", "biot_2", "almansi_1", "almansi_2"),
    *("shear_max", "shear_angle", "area_ratio"),
)
"""Cell arrays of facets.vtp: the same measures, of one triangle each."""

INTEGER_COLUMNS = ("chart", "status", "iterations")
"""Columns of measurement.csv that are written without a point."""

CALIBRATED = (
    ("gray", "I", "1", "grey level, 0 to 1; NaN outside the mask"),
    ("X", "X", "mm", "position on the surface, frame of the file"),
    ("Y", "Y", "mm", "position on the surface, frame of the file"),
    ("Z", "Z", "mm", "position on the surface, frame of the file"),
    ("face", "–", "1", "face of the mesh under the pixel; −1 outside the mask"),
)
"""Point arrays of flatten/reference.vti and flatten/deformed.vti."""

_PLANE_GREEN = "Green–Lagrange, E = (FᵀF − I)/2; F fitted to u, v over the strain window"

PLANAR = (
    ("x_px", "x", "px", "column in the reference picture, a multiple of the spacing"),
    ("y_px", "y", "px", "row in the reference picture, a multiple of the spacing"),
    ("u_px", "u", "px", "column in the deformed picture − x"),
    ("v_px", "v", "px", "row in the deformed picture − y"),
    ("du_dx", "∂u/∂x", "1", "from the subset shape function"),
    ("du_dy", "∂u/∂y", "1", "from the subset shape function"),
    ("dv_dx", "∂v/∂x", "1", "from the subset shape function"),
    ("dv_dy", "∂v/∂y", "1", "from the subset shape function"),
    ("zncc", "ZNCC", "1", "zero-mean normalised cross-correlation of the subsets"),
    ("iterations", "–", "1", "iterations of IC-GN until it settled"),
    ("status", "–", "1", "0 = OK; codes in CONVENTIONS.md"),
    ("sigma_u_px", "σ(u)", "px", "1 σ from image noise and the gradients of the subset"),
    ("sigma_v_px", "σ(v)", "px", "1 σ from image noise and the gradients of the subset"),
    (
        "bias_u_px",
        "b(u)",
        "px",
        "estimated systematic error, u − truth: shape function, interpolation",
    ),
    ("bias_v_px", "b(v)", "px", "the same of v"),
    ("E_xx", "E_xx", "1", _PLANE_GREEN),
    ("E_xy", "E_xy", "1", "the same; tensor shear, half the engineering shear"),
    ("E_yy", "E_yy", "1", "the same"),
    ("E1", "E₁", "1", "larger principal value of it"),
    ("E2", "E₂", "1", "smaller principal value of it"),
    ("hencky_xx", "ε_xx", "1", "Hencky, ln(FᵀF)/2, of the same F"),
    ("hencky_xy", "ε_xy", "1", "the same; tensor shear"),
    ("hencky_yy", "ε_yy", "1", "the same"),
    ("hencky_1", "ε₁", "1", "ln λ₁"),
    ("hencky_2", "ε₂", "1", "ln λ₂"),
)
"""Columns of correlation.csv and arrays of correlation.npz."""

FLATTENED = (
    ("grey", "I", "1", "grey level (H, W), 0 to 1"),
    ("mask", "–", "1", "where a face covers the pixel centre (H, W)"),
    ("X", "X", "mm", "position on the surface (H, W); NaN outside the mask"),
    ("Y", "Y", "mm", "position on the surface (H, W); NaN outside the mask"),
    ("Z", "Z", "mm", "position on the surface (H, W); NaN outside the mask"),
    ("triangle", "–", "1", "triangle of the chart under the pixel (H, W); −1 outside the mask"),
    ("barycentric", "β₂, β₃", "1", "weights of its second and third corner (H, W, 2)"),
    ("chart_vertex_ids", "–", "1", "vertex of the mesh that each vertex of the chart copies (N)"),
    ("chart_faces", "–", "1", "triangles in vertices of the chart (M, 3)"),
    ("chart_face_ids", "–", "1", "face of the mesh that each triangle is (M)"),
    ("chart_vertex_px", "x, y", "px", "position of each vertex of the chart (N, 2)"),
    ("chart_page_starts", "–", "px", "first column of each page"),
    ("px_per_mm", "s", "px/mm", "nominal image scale"),
)
"""Arrays of the NPZ file that `shapemorph flatten MESH` writes."""

WARP = (
    ("coefficients", "c", "px", "of a uniform cubic B-spline: target position (R, C, 2)"),
    ("origin", "x₀, y₀", "px", "source position of coefficient [0, 0]"),
    ("spacing", "h", "px", "distance between coefficients in the source"),
)
"""Arrays of warp_forward.npz and warp_backward.npz."""

MATCHES = (
    ("x_ref_px", "x", "px", "column in the reference picture"),
    ("y_ref_px", "y", "px", "row in the reference picture"),
    ("x_def_px", "x′", "px", "column in the deformed picture"),
    ("y_def_px", "y′", "px", "row in the deformed picture"),
)
"""Columns of matches.csv."""
