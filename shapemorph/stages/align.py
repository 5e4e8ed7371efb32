"""Stage `align`: the rigid motion between the two files."""

import numpy as np

from shapemorph.config import AlignConfig
from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import ConfigError, DataError, StageError
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import Alignment, TrackedSurface
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.face_planes import face_planes, typical_edge
from shapemorph.methods.facet_strain import facet_strain
from shapemorph.methods.grid_average import average_over_window
from shapemorph.methods.icp import fit_icp
from shapemorph.methods.rigid import fit_rigid, refuse_mirrored, residuals_of
from shapemorph.methods.rigid_search import largest_rigid_set
from shapemorph.methods.whereabouts import whereabouts

_SMALLEST_SHARE = 0.05  # of the offered points: a smaller rigid set may be chance
_SOFTNESS_WINDOW = 5  # cells whose strains are averaged to tell stiff from soft
_LEAST_NOISE = 1e-7  # of the size of the object: rounding of noise-free data
_RESIDUAL_SAMPLE = 1000
_SEED = 0


def align(
    tracked: TrackedSurface,
    reference_mesh: TexturedMesh,
    deformed_mesh: TexturedMesh,
    landmarks: Landmarks | None,
    rigid: Bools | None,
    config: AlignConfig,
) -> Alignment:
    """Find the rigid motion that lays the deformed shape over the reference.

    Parameters
    ----------
    tracked : TrackedSurface
        mm.
    reference_mesh, deformed_mesh : TexturedMesh
        mm; ICP lays reference points on the deformed mesh.
    landmarks : Landmarks or None
    rigid : (R, C) bool or None
        Grid points known to have moved rigidly; points and ICP use only these.
    config : AlignConfig

    Returns
    -------
    Alignment

    Raises
    ------
    ConfigError
        If landmarks are asked for and none are given.
    DataError
        If the landmarks are too few, on one line, or mirrored.
    StageError
        If the points that should carry the motion are too few.
    """
    method = config.method
    if method == "none":
        return Alignment.unmoved()
    if method == "auto":
        method = "points" if landmarks is None else "landmarks"
    if method == "points":
        return _by_points(tracked, rigid, reference_mesh.size)
    if method == "icp":
        start = _by_points(tracked, rigid, reference_mesh.size)
    else:
        start = _by_landmarks(landmarks, method)
    if method == "landmarks":
        return start
    return _by_icp(tracked, deformed_mesh, rigid, start, config)


def _by_landmarks(landmarks: Landmarks | None, method: str) -> Alignment:
    if landmarks is None:
        raise ConfigError(
            f"align.method {method} needs landmarks, got none: set inputs.landmarks, or choose "
            "points"
        )
    source, target = landmarks.deformed, landmarks.reference
    transform = fit_rigid(source, target, np.ones(len(source)))
    refuse_mirrored(source, target)
    residuals = residuals_of(transform, source, target)
    worst = landmarks.names[int(residuals.argmax())]
    return _alignment(
        transform,
        "landmarks",
        residuals,
        np.zeros(0, dtype=np.int64),
        1.0,
        f"{len(source)} landmarks, the worst is {worst} with {residuals.max():.4g} mm",
    )


def _by_points(tracked: TrackedSurface, rigid: Bools | None, size: float) -> Alignment:
    """Robust fit to the points that moved rigidly, or least squares over all of them."""
    offered = _offered(tracked, rigid)
    target = tracked.reference.reshape(-1, 3)[offered]
    source = tracked.deformed.reshape(-1, 3)[offered]
    sigma = tracked.sigma_position.ravel()[offered]
    noise = float(np.nanmedian(sigma)) if np.isfinite(sigma).any() else 0.0
    found = largest_rigid_set(
        source,
        target,
        _softness(tracked)[offered],
        noise=max(noise, _LEAST_NOISE * size),
        smallest_share=_SMALLEST_SHARE,
        seed=_SEED,
    )
    where = "of the given rigid region" if rigid is not None else "that were matched"
    if found is None:
        members = np.ones(len(offered), dtype=bool)
        transform = _least_squares(source, target)
        note = (
            f"least squares over all {len(offered)} points {where}: no part of "
            f"{_SMALLEST_SHARE:.0%} or more moved rigidly, so the displacement holds an "
            "arbitrary share of rigid motion (strain does not); landmarks would settle it"
        )
    else:
        members, transform = found.members, found.transform
        note = (
            f"{members.sum()} of {len(offered)} points {where} ({members.mean():.0%}) moved "
            f"rigidly: {whereabouts(target[members])}"
        )
    residuals = residuals_of(transform, source[members], target[members])
    return _alignment(transform, "points", residuals, offered[members], members.mean(), note)


def _offered(tracked: TrackedSurface, rigid: Bools | None) -> Ints:
    usable = tracked.status == PointStatus.OK
    if rigid is not None:
        usable = usable & rigid
    offered = np.flatnonzero(usable)
    if len(offered) < 3:
        raise StageError(
            f"expected at least 3 matched points to align by, got {len(offered)}: widen "
            "align.rigid_region, or give landmarks"
        )
    return offered


def _softness(tracked: TrackedSurface) -> Floats:
    """Size of the strain around every grid point, noise averaged, flat."""
    cells = facet_strain(tracked.reference, tracked.deformed).mean(axis=2)
    components = np.stack([cells[..., 0, 0], cells[..., 1, 1], cells[..., 0, 1]], axis=-1)
    smooth = average_over_window(components, window=_SOFTNESS_WINDOW)
    at_points = np.full((*tracked.status.shape, 3), np.nan)
    at_points[:-1, :-1] = smooth
    size: Floats = np.linalg.norm(at_points, axis=-1).ravel()
    return size


def _least_squares(source: Floats, target: Floats) -> RigidTransform:
    try:
        return fit_rigid(source, target, np.ones(len(source)))
    except DataError as error:
        raise StageError(f"the matched points do not settle a rigid motion: {error}") from error


def _by_icp(
    tracked: TrackedSurface,
    deformed_mesh: TexturedMesh,
    rigid: Bools | None,
    start: Alignment,
    config: AlignConfig,
) -> Alignment:
    """Lay the rigid part of the reference on the deformed mesh, from a first guess."""
    points = _icp_points(tracked, rigid, start)
    planes, normals = face_planes(deformed_mesh.vertices, deformed_mesh.faces)
    guess = RigidTransform(start.rotation, start.translation).inverse()
    fit = fit_icp(
        points,
        planes,
        normals,
        guess,
        reach=3 * start.rms + 2 * typical_edge(deformed_mesh.vertices, deformed_mesh.faces),
        iterations=config.icp_iterations,
    )
    if fit.carried < 3:
        raise StageError(
            f"expected the reference to lie near the deformed mesh for ICP, got {fit.carried} "
            f"points in reach: choose another align.method than {config.method}, or check the "
            "landmarks"
        )
    kept = f", {fit.free} of 6 directions kept from the {start.method}" if fit.free else ""
    note = (
        f"{fit.carried} of {len(points)} points of the reference lie on the deformed mesh, rms "
        f"{fit.rms:.4g} mm{kept}: {whereabouts(points)}"
    )
    return Alignment(
        rotation=fit.transform.inverse().rotation,
        translation=fit.transform.inverse().translation,
        method=f"{start.method}+icp",
        rms=fit.rms,
        residuals=start.residuals,
        carried_by=fit.carried,
        carried_share=fit.carried / len(points),
        carrying_points=np.zeros(0, dtype=np.int64),
        note=note,
    )


def _icp_points(tracked: TrackedSurface, rigid: Bools | None, start: Alignment) -> Floats:
    """Choose reference points: the rigid region, else what carried the start, else all."""
    reference = tracked.reference.reshape(-1, 3)
    if rigid is not None:
        chosen = reference[rigid.ravel()]
    elif len(start.carrying_points):
        chosen = reference[start.carrying_points]
    else:
        chosen = reference
    points: Floats = chosen[np.isfinite(chosen).all(axis=1)]
    if len(points) < 3:
        raise StageError(
            f"expected at least 3 reference points for ICP, got {len(points)}: widen "
            "align.rigid_region"
        )
    return points


def _alignment(
    transform: RigidTransform,
    method: str,
    residuals: Floats,
    carrying: Ints,
    share: float,
    note: str,
) -> Alignment:
    step = max(1, len(residuals) // _RESIDUAL_SAMPLE)
    return Alignment(
        rotation=transform.rotation,
        translation=transform.translation,
        method=method,
        rms=float(np.sqrt(np.mean(residuals**2))),
        residuals=residuals if method == "landmarks" else residuals[::step],
        carried_by=len(residuals),
        carried_share=float(share),
        carrying_points=carrying,
        note=note,
    )
