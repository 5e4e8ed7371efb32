"""A correlation between two plain pictures as a table."""

import numpy as np

from shapemorph.core.arrays import Codes, Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.planar import PlanarStrain
from shapemorph.core.status import PointStatus

Table = dict[str, Floats | Ints | Codes]


def planar_table(grid: CorrelationGrid, strain: PlanarStrain) -> Table:
    """Columns of a 2D correlation, one row for each point inside the mask.

    Returns
    -------
    dict
        x_px, y_px (integers), u_px, v_px = deformed - reference, du_dx ... dv_dy (its
        derivatives with respect to the reference position), zncc, iterations, status,
        sigma_u_px, sigma_v_px, bias_u_px, bias_v_px (estimate - truth); then the strain:
        E_xx, E_xy, E_yy, E1, E2 (Green-Lagrange), hencky_xx ... hencky_2. NaN
        where there is no value.
    """
    rows = grid.status != PointStatus.OUTSIDE_MASK
    reference = grid.reference_px[rows]
    displacement = grid.deformed_px[rows] - reference
    gradient = grid.gradient[rows] - np.eye(2)
    sigma = grid.sigma_px[rows]
    bias = np.full_like(sigma, np.nan) if grid.bias_px is None else grid.bias_px[rows]
    return {
        "x_px": np.rint(reference[:, 0]).astype(np.int64),
        "y_px": np.rint(reference[:, 1]).astype(np.int64),
        "u_px": displacement[:, 0],
        "v_px": displacement[:, 1],
        "du_dx": gradient[:, 0, 0],
        "du_dy": gradient[:, 0, 1],
        "dv_dx": gradient[:, 1, 0],
        "dv_dy": gradient[:, 1, 1],
        "zncc": grid.zncc[rows],
        "iterations": grid.iterations[rows],
        "status": grid.status[rows],
        "sigma_u_px": sigma[:, 0],
        "sigma_v_px": sigma[:, 1],
        "bias_u_px": bias[:, 0],
        "bias_v_px": bias[:, 1],
        **_strain_columns("E_{}", "E{}", strain.green[rows], strain.green_principal[rows]),
        **_strain_columns(
            "hencky_{}", "hencky_{}", strain.hencky[rows], strain.hencky_principal[rows]
        ),
    }


def _strain_columns(component: str, value: str, tensor: Floats, principal: Floats) -> Table:
    return {
        component.format("xx"): tensor[:, 0, 0],
        component.format("xy"): tensor[:, 0, 1],
        component.format("yy"): tensor[:, 1, 1],
        value.format("1"): principal[:, 0],
        value.format("2"): principal[:, 1],
    }
