"""Meshes that no single piece of the plane holds."""

import numpy as np


def ball(steps=48, radius=20.0):
    """Sphere of quads along meridians, parted into triangles; outward, a vertex per pole."""
    around = 2 * steps
    turn = 2 * np.pi * np.arange(around) / around
    polar = np.pi * np.arange(1, steps) / steps
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rows = [np.column_stack([np.sin(p) * ring, np.full(around, np.cos(p))]) for p in polar]
    vertices = radius * np.concatenate([*rows, [[0, 0, 1.0], [0, 0, -1.0]]])
    faces = [_band(k * around, (k + 1) * around, around) for k in range(steps - 2)]
    first, top, low = np.arange(around), (steps - 1) * around, (steps - 2) * around
    after = (first + 1) % around
    faces.append(np.stack([np.full(around, top), first, after], axis=1))
    faces.append(np.stack([np.full(around, top + 1), low + after, low + first], axis=1))
    return vertices, np.concatenate(faces)


def tube(steps=40, around=120, radius=10.0, length=40.0):
    """Open tube along z, outward."""
    turn = 2 * np.pi * np.arange(around) / around
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    heights = length * np.arange(steps)[::-1] / (steps - 1)
    vertices = np.concatenate([np.column_stack([ring, np.full(around, z)]) for z in heights])
    faces = [_band(k * around, (k + 1) * around, around) for k in range(steps - 1)]
    return vertices, np.concatenate(faces)


def _band(upper, lower, around):
    first = np.arange(around)
    after = (first + 1) % around
    one = np.stack([upper + first, lower + first, lower + after], axis=1)
    other = np.stack([upper + first, lower + after, upper + after], axis=1)
    return np.concatenate([one, other])
