"""The page docs/outputs.md: every array of the result files."""

from collections.abc import Iterator

from shapemorph.io.quantities import (
    CALIBRATED,
    FACET_ARRAYS,
    FLATTENED,
    MATCHES,
    PLANAR,
    QUANTITIES,
    REFERENCE,
    WARP,
    Quantity,
)

_HEAD = """\
# What the result files hold

Written by `tools/outputs_page.py` from `shapemorph/io/quantities.py`; do not edit by hand.

Lengths are in mm and positions in the frame of the file that they belong to. A value that is \
missing is NaN, and `status` says why ([CONVENTIONS.md](../CONVENTIONS.md)). Uncertainties are \
one standard deviation of the random part. A unit of 1 means none.

## measurement.vtp, .csv, .npz, .mat

One row a point. `measurement.vtp` is PolyData: its points are the reference positions and its \
cells the quads between neighbours that are all OK; configuration, units and version stand in \
the field data. `shapemorph export RUN --format npz` (or `mat`) writes the same arrays under the \
same names with more: `points`, `cells` (row numbers of the four corners, counted from 0; in \
MATLAB add 1), `facets` (of the three) and the arrays of facets.vtp with `facet_` before their \
names. `measurement.csv` has the columns of the last column, in this order.

| array | symbol | unit | numbers | formula | comes from | column |
| --- | --- | --- | --- | --- | --- | --- |
"""

_FACETS = """
## facets.vtp

Strain without any smoothing: two triangles for each quad of measurement.vtp, between the same \
points (its rows), each with the one homogeneous strain that its three corners have. Its strain \
gauge is that of a window of two points, spacing + subset size. Cell arrays, symbols and formulas \
as above: {}.
"""

_GLB = """
## measurement.glb

The deformed shape **in metres**, as glTF asks (frame of the deformed file), coloured by E₁ in \
linear `COLOR_0`; the scalar is the vertex attribute `_E1` (float32), its range and units are in \
the `extras` of the mesh.

## flatten/reference.vti, flatten/deformed.vti

Calibrated images (`_0`, `_1`, … appended where there are several charts); spacing and origin \
in mm, first row at the bottom.
"""

_PLANAR_HEAD = """
## correlation.csv, correlation.npz

What `shapemorph correlate` writes for two pictures; one row a point inside the mask. Strain is \
that of the virtual strain gauge, (window − 1) · spacing + subset size. The NPZ also holds \
`spacing`, `subset_size` and `gauge_px`, px, and `strain_window`, points.
"""

_FLATTENED_HEAD = """
## NAME.npz of `shapemorph flatten`

The calibrated image of one mesh as arrays; NAME is that of the mesh.
"""

_MATCHES_HEAD = """
## matches.csv of `shapemorph morph`

One row a match, px of the two pictures.
"""

_WARP_HEAD = """
## warp_forward.npz, warp_backward.npz of `shapemorph morph`

Reference to deformed and back.
"""

_SMALL = "\n| array | symbol | unit | meaning |\n| --- | --- | --- | --- |\n"

_SECTIONS = (
    (_GLB, CALIBRATED),
    (_PLANAR_HEAD, PLANAR),
    (_FLATTENED_HEAD, FLATTENED),
    (_MATCHES_HEAD, MATCHES),
    (_WARP_HEAD, WARP),
)


def outputs_page() -> str:
    """Write docs/outputs.md."""
    rows = "".join(_row(quantity) for quantity in (REFERENCE, *QUANTITIES))
    sections = (head + _SMALL + "".join(_small_rows(table)) for head, table in _SECTIONS)
    facets = _FACETS.format(", ".join(f"`{name}`" for name in FACET_ARRAYS))
    return _HEAD + rows + facets + "".join(sections)


def _row(quantity: Quantity) -> str:
    columns = ", ".join(f"`{column}`" for column in quantity.columns) or "–"
    numbers = quantity.kind + (f" × {quantity.components}" if quantity.components > 1 else "")
    cells = (f"`{quantity.name}`", quantity.symbol, quantity.unit, numbers)
    condition = f"; only with `{quantity.only_with}`" if quantity.only_with else ""
    return _line(*cells, quantity.formula + condition, quantity.source, columns)


def _small_rows(table: tuple[tuple[str, str, str, str], ...]) -> Iterator[str]:
    for name, symbol, unit, meaning in table:
        yield _line(f"`{name}`", symbol, unit, meaning)


def _line(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"
