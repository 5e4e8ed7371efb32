"""What really happened at measured points: evaluated from the closed forms, never interpolated."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.synthetic import DamageSpot, Truth, TruthPoints
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.damage import is_visible
from shapemorph.methods.synthetic.material import (
    MaterialMap,
    area_element,
    nearest_material,
    principal_strains,
    rim_distance,
)
from shapemorph.methods.synthetic.shapes import material_map

TABLE_CELLS = 80
"""Cells of the table along the longer side of the material."""


def make_truth(
    shape: str,
    *,
    size: float,
    offset: float,
    tilt: float,
    poses: tuple[RigidTransform, RigidTransform],
    damage: tuple[DamageSpot, ...],
) -> Truth:
    """Gather what a pair needs to be judged, and tabulate it on a grid of the material.

    Parameters
    ----------
    shape : str
    size, offset : float
        mm.
    tilt : float
        Radians.
    poses : tuple of RigidTransform
        file_from_body of the reference and of the deformed side.
    damage : tuple of DamageSpot
    """
    mapped = material_map(shape, size=size, offset=offset, tilt=tilt)
    grid = _regular_grid(mapped)
    table = _evaluate(mapped, grid[mapped.inside(grid)], poses, damage)
    return Truth(shape, size, offset, tilt, *poses, damage, table)


def truth_map(truth: Truth) -> MaterialMap:
    """Make the material map that a truth was made from."""
    return material_map(truth.shape, size=truth.size, offset=truth.offset, tilt=truth.tilt)


def truth_at(truth: Truth, reference: Floats) -> TruthPoints:
    """Find what really happened at points (N, 3) of the reference file, mm.

    Each stands for the material point of the true reference surface nearest to it.
    """
    mapped = truth_map(truth)
    body = truth.reference_pose.inverse().apply(reference)
    return truth_of_material(truth, nearest_material(mapped, body))


def truth_of_material(truth: Truth, material: Floats) -> TruthPoints:
    """Find what really happened at material coordinates (N, 2), mm."""
    poses = (truth.reference_pose, truth.deformed_pose)
    return _evaluate(truth_map(truth), material, poses, truth.damage)


def true_tensor(truth: Truth, reference: Floats, basis: Floats) -> Floats:
    """Find the true strain in given bases of the reference file.

    Parameters
    ----------
    truth : Truth
    reference : (N, 3)
        Points of the reference file, mm.
    basis : (N, 2, 3)
        Vectors that lie (nearly) in the surface there.

    Returns
    -------
    (N, 2, 2)
        Green-Lagrange strain of the material point nearest to each, in the basis.
    """
    mapped = truth_map(truth)
    body = truth.reference_pose.inverse()
    material = nearest_material(mapped, body.apply(reference))
    before, after = mapped.reference(material)[1], mapped.deformed(material)[1]
    inside = body.rotate(basis) @ np.swapaxes(np.linalg.pinv(before), 1, 2)
    change = np.swapaxes(after, 1, 2) @ after - np.swapaxes(before, 1, 2) @ before
    tensor: Floats = inside @ change @ np.swapaxes(inside, 1, 2) / 2
    return tensor


def random_material(truth: Truth, count: int, *, inset: float, seed: int) -> Floats:
    """Material coordinates (count, 2), even in area on the reference, `inset` mm off the rim."""
    mapped = truth_map(truth)
    rng = np.random.default_rng(seed)
    densest = 1.05 * area_element(mapped.reference(_regular_grid(mapped))[1]).max()
    found: list[Floats] = []
    while sum(map(len, found)) < count:
        trial = rng.uniform(mapped.lower, mapped.upper, (2 * count, 2))
        lot = rng.random(2 * count) * densest
        trial = trial[(lot < area_element(mapped.reference(trial)[1])) & mapped.inside(trial)]
        found.append(trial[rim_distance(mapped, trial) >= inset])
    return np.concatenate(found)[:count]


def _regular_grid(mapped: MaterialMap) -> Floats:
    """Material coordinates (N, 2) over the box of the map."""
    span = mapped.upper - mapped.lower
    counts = np.maximum(np.round(TABLE_CELLS * span / span.max()), 1).astype(np.int64) + 1
    axes = [np.linspace(mapped.lower[k], mapped.upper[k], counts[k]) for k in range(2)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


def _evaluate(
    mapped: MaterialMap,
    material: Floats,
    poses: tuple[RigidTransform, RigidTransform],
    damage: tuple[DamageSpot, ...],
) -> TruthPoints:
    e1, e2 = principal_strains(mapped, material)
    return TruthPoints(
        material=material,
        reference=poses[0].apply(mapped.reference(material)[0]),
        deformed=poses[1].apply(mapped.deformed(material)[0]),
        e1=e1,
        e2=e2,
        rim_distance=rim_distance(mapped, material),
        kink_distance=mapped.kink(material),
        visible=is_visible(mapped, material, damage),
    )
