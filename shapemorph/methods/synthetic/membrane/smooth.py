"""Smooth maps through nodes: what is drawn and what counts as true."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.spline_map import SplineMap
from shapemorph.kernels import spline_fit
from shapemorph.methods.spline_sampling import sample_vectors

SMOOTHING = 1e-6  # of the bending of the coefficients, per node: it rules beyond the rim only


def fit_map(material: Floats, nodes: Floats, *, spacing: float) -> SplineMap:
    """Fit a bicubic spline to nodes by least squares.

    Parameters
    ----------
    material : (N, 2)
        Material coordinates, mm.
    nodes : (N, 3)
        Where they are, mm.
    spacing : float
        Distance between coefficients, mm; the map is defined so far beyond the nodes.
    """
    low, high = material.min(axis=0) - spacing, material.max(axis=0) + spacing
    cells = np.maximum(np.ceil((high - low) / spacing).astype(np.int64), 1)
    origin = 0.5 * (low + high) - spacing * (0.5 * cells + 1)
    height, width = int(cells[1]) + 3, int(cells[0]) + 3
    first, weights = spline_fit.basis((material - origin) / spacing, height, width)
    band, right = spline_fit.data_equations(
        first, weights, np.ones(len(material)), nodes, height, width
    )
    band = band + SMOOTHING * spline_fit.bending_equations(height, width)
    found = spline_fit.solve(spline_fit.factorise(band), right)
    return SplineMap(found.reshape(height, width, 3), origin, spacing)


def map_points(mapped: SplineMap, material: Floats) -> tuple[Floats, Floats]:
    """Positions (N, 3) and derivatives (N, 3, 2) at material coordinates (N, 2); an embedding.

    NaN outside the support of the spline.
    """
    at = (material - mapped.origin) / mapped.spacing
    position, slope = sample_vectors(mapped.coefficients, at)
    return position, slope / mapped.spacing
