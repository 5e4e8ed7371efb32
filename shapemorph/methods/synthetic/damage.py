"""What goes wrong with the pattern between two recordings: glare, loss, foreign marks."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.synthetic import DamageSpot
from shapemorph.methods.synthetic.material import MaterialMap

RADIUS = {"glare": 0.06, "lost_patch": 0.045, "print": 0.05}
"""Radius of each kind over the size of the specimen."""


def place_damage(
    material_map: MaterialMap, kinds: tuple[str, ...], *, size: float, rng: np.random.Generator
) -> tuple[DamageSpot, ...]:
    """Place one spot of each kind: a print at the pole, others at random, apart, inside."""
    spots: list[DamageSpot] = []
    for kind in kinds:
        radius = RADIUS[kind] * size
        centre = material_map.pole if kind == "print" else None
        if centre is None:
            centre = _free_place(material_map, spots, radius, rng)
        spots.append(DamageSpot(kind, np.asarray(centre, dtype=np.float64), radius))
    return tuple(spots)


def _free_place(
    material_map: MaterialMap, spots: list[DamageSpot], radius: float, rng: np.random.Generator
) -> Floats:
    """Material coordinates (2,) well inside, clear of the pole and of other spots."""
    places = rng.uniform(material_map.lower, material_map.upper, (2000, 2))
    free = material_map.rim(places) > 1.2 * radius
    taken = [(material_map.pole, radius), *((spot.centre, spot.radius) for spot in spots)]
    for centre, reach in taken:
        free &= spot_distance(material_map, places, centre) > 1.2 * (radius + reach)
    chosen: Floats = places[int(np.argmax(free))]
    return chosen


def spot_distance(material_map: MaterialMap, material: Floats, centre: Floats) -> Floats:
    """Distance (...,) of coordinates (..., 2) from a centre, the short way round, mm."""
    gap = material - centre
    if material_map.period is not None:
        jump = np.round(gap[..., 0] / material_map.period) * material_map.period
        gap = gap - np.stack([jump, np.zeros_like(jump)], axis=-1)
    distance: Floats = np.linalg.norm(gap, axis=-1)
    return distance


def is_visible(material_map: MaterialMap, material: Floats, spots: tuple[DamageSpot, ...]) -> Bools:
    """Whether the pattern at coordinates (N, 2) survived."""
    visible = np.ones(len(material), dtype=bool)
    for spot in spots:
        visible &= spot_distance(material_map, material, spot.centre) > spot.radius
    return visible


def spoil(
    grey: Floats, material: Floats, material_map: MaterialMap, spots: tuple[DamageSpot, ...]
) -> Floats:
    """Grey (N,) at coordinates (N, 2) after the damage; may exceed 1 under glare."""
    for spot in spots:
        reach = spot_distance(material_map, material, spot.centre) / spot.radius
        grey = _SPOILERS[spot.kind](grey, reach)
    return grey


def _glare(grey: Floats, reach: Floats) -> Floats:
    """Light that saturates the middle of the spot and fades out beyond it."""
    brighter: Floats = grey + 1.5 * np.exp(-2.5 * reach**2)
    return brighter


def _lost(grey: Floats, reach: Floats) -> Floats:
    """Bare material of one grey, with a soft edge."""
    kept = np.clip((reach - 0.95) / 0.1, 0.0, 1.0)
    bare: Floats = 0.55 + kept * (grey - 0.55)
    return bare


def _print(grey: Floats, reach: Floats) -> Floats:
    """Two dark rings and a dark dot over the pattern."""
    ring = np.abs(reach - np.array([[0.0], [0.45], [0.85]])).min(axis=0)
    kept = np.clip((ring - 0.12) / 0.05, 0.0, 1.0)
    printed: Floats = 0.08 + kept * (grey - 0.08)
    return printed


_SPOILERS = {"glare": _glare, "lost_patch": _lost, "print": _print}
