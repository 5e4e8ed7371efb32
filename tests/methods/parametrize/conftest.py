"""Surfaces with closed forms, anywhere in space and of any size."""

import numpy as np
import pytest


def _sheet_faces(rows, cols):
    number = np.arange(rows * cols).reshape(rows, cols)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def _rings(count):
    """Radius in [0, 1], azimuth and faces of a disk: 6 k points on ring k."""
    radius, azimuth, faces, first = [0.0], [0.0], [], 0
    for ring in range(1, count + 1):
        start, inner = len(radius), max(6 * (ring - 1), 1)
        radius += [ring / count] * (6 * ring)
        azimuth += list(np.arange(6 * ring) * 2 * np.pi / (6 * ring))
        for k in range(6 * ring):
            sector, place = divmod(k, ring)
            below = first + (sector * (ring - 1) + place) % inner
            before = first + (sector * (ring - 1) + place - 1) % inner
            faces.append([below, start + k, start + (k + 1) % (6 * ring)])
            if place > 0:
                faces.append([before, start + k, below])
        first = start
    return np.array(radius), np.array(azimuth), np.array(faces)


@pytest.fixture(scope="session")
def revolve():
    """Turn a meridian (function of the way in [0, 1] to r, z) around Z; also the way, azimuth."""

    def make(meridian, count=40):
        way, azimuth, faces = _rings(count)
        r, z = meridian(way)
        points = np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], axis=1)
        return points, faces, way, azimuth

    return make


@pytest.fixture(scope="session")
def ball_cap(revolve):
    """A cap of the unit ball around +Z up to an angle; also its polar angles."""

    def make(half_angle, count=40):
        points, faces, way, _ = revolve(
            lambda way: (np.sin(way * half_angle), np.cos(way * half_angle)), count
        )
        return points, faces, way * half_angle

    return make


@pytest.fixture(scope="session")
def pipe():
    """A patch of a pipe of radius 1 along Z, outer side out; it may wind more than once."""

    def make(turn, height=2.0, rows=21, cols=90, pitch=0.0, seed=1):
        z, angle = np.meshgrid(
            np.linspace(0, height, rows), np.linspace(0.4, 0.4 + turn, cols), indexing="ij"
        )
        jitter = np.random.default_rng(seed).uniform(-0.2, 0.2, angle.shape) * turn / cols
        jitter[:, [0, -1]] = 0
        angle = angle + jitter
        points = np.stack([np.cos(angle), np.sin(angle), z + pitch * angle], axis=-1)
        return (
            points.reshape(-1, 3),
            _sheet_faces(rows, cols),
            angle.ravel(),
            points[..., 2].ravel(),
        )

    return make


@pytest.fixture(scope="session")
def anywhere():
    """Turn, move and scale points; some noise, of the size before scaling."""

    def make(points, scale=1.0, noise=0.0, seed=0):
        from scipy.spatial.transform import Rotation

        rng = np.random.default_rng(seed)
        turn = Rotation.from_rotvec([0.4, -1.3, 0.9])
        return scale * turn.apply(points + noise * rng.standard_normal(points.shape)) + (
            scale * np.array([40.0, -7.0, 11.0])
        )

    return make
