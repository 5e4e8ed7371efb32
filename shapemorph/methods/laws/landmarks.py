"""Laws from marks: dots along a diameter give a radial law, scattered dots a smooth warp."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.methods.laws.radial import Profile, RadialPose

ON_A_LINE = 0.05  # ratio of the spreads of dots across and along below which it is a line
SAME_RADIUS = 0.02  # of the largest: dots on both sides of the centre that are averaged


def on_a_line(points: Floats) -> bool:
    """Tell dots (K, 2) along a diameter from scattered ones."""
    along, across = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:2]
    return bool(across < ON_A_LINE * along)


def profile_of_dots(pose: RadialPose, reference: Floats, deformed: Floats) -> Profile:
    """Radial law that rises monotonically through dots along a diameter.

    Parameters
    ----------
    pose : RadialPose
        Where the centres are; only distances from them count.
    reference, deformed : (K, 2)
        The dots in the two pictures, mm.

    Returns
    -------
    callable
        r_m (N,) at radii (N,) of the deformed picture, mm; straight beyond the last dot.

    Raises
    ------
    StageError
        If the dots do not give a rising law.
    """
    from scipy.interpolate import PchipInterpolator

    away = reference - pose.reference_centre
    radius, value = _merged(pose.radii(deformed), np.hypot(away[:, 0], away[:, 1]))
    if len(radius) < 2 or not (np.diff(value) > 0).all():
        raise StageError(
            f"expected dots whose distance from the centre rises in both pictures, got "
            f"{len(radius) - 1} of them in the order {np.round(value[1:], 3).tolist()} mm: check "
            "the landmarks, or give morph.centre"
        )
    curve = PchipInterpolator(radius, value)
    slope = (value[-1] - value[-2]) / (radius[-1] - radius[-2])

    def profile(at: Floats) -> Floats:
        inner = curve(np.minimum(at, radius[-1]))
        beyond: Floats = inner + slope * np.maximum(at - radius[-1], 0.0)
        return beyond

    return profile


def _merged(radius: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Radii from the centre outwards, each once: dots of one radius are averaged."""
    order = np.argsort(radius, kind="stable")
    radius, value = radius[order], value[order]
    near = SAME_RADIUS * radius[-1]
    group = np.cumsum(np.concatenate([[radius[0] > near], np.diff(radius) > near]))
    count = np.bincount(group)
    count[count == 0] = 1
    radius, value = (np.bincount(group, weights=part) / count for part in (radius, value))
    radius[0] = value[0] = 0.0  # the centre goes to the centre, dot or none
    return radius, value
