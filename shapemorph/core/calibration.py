"""What is photographed to calibrate cameras, and what comes of it."""

from dataclasses import dataclass, field

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.camera import Rig
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Points of known coordinates.

    Attributes
    ----------
    name : str
    points : (P, 3) float64
        In the target's own frame, mm.
    normals : (P, 3) float64 or None
        Outward, of the surface at each point; None where all points lie in the plane z = 0.
    dot_radius : float
        Of round dots, mm: the middle of their picture is not the picture of their middle;
        0 for corners.
    lattice : (P, 2) int64 or None
        Row and column of each point, where points were identified by their neighbours.
    symmetries : tuple of (P,) int64
        Renumberings under which the target looks the same.
    """

    name: str
    points: Floats
    normals: Floats | None = None
    dot_radius: float = 0.0
    lattice: Ints | None = None
    symmetries: tuple[Ints, ...] = ()

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or len(self.points) < 4:
            raise DataError(
                f"target {self.name}: expected at least 4 points (x, y, z), got {self.points.shape}"
            )

    @property
    def is_flat(self) -> bool:
        """Whether all points lie in the plane z = 0."""
        return not self.points[:, 2].any()


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """Points of a target in one picture.

    Attributes
    ----------
    camera, view : int
        Which camera saw it, and in which of its places.
    ids : (N,) int64
        Which points of the target.
    pixels : (N, 2) float64
    """

    camera: int
    view: int
    ids: Ints
    pixels: Floats

    def __post_init__(self) -> None:
        if self.pixels.shape != (len(self.ids), 2):
            raise DataError(
                f"a sighting needs a pixel for each of {len(self.ids)} points, got "
                f"{self.pixels.shape}"
            )

    def only(self, kept: Bools | Ints) -> "Sighting":
        """Return the same with some of its points."""
        return Sighting(self.camera, self.view, self.ids[kept], self.pixels[kept])


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A place of a target.

    Attributes
    ----------
    name : str
    target : Target
    """

    name: str
    target: Target


@dataclass(frozen=True, slots=True, eq=False)
class CameraUncertainty:
    """Standard deviations of what was calibrated, of the random part; 0 where it was held.

    Attributes
    ----------
    focal, centre, tangential : (2,) float64
    radial : (3,) float64
    skew : float
    rotation : (3,) float64
        Small turns of the camera about its own axes, radians.
    translation : (3,) float64
        mm.
    """

    focal: Floats
    centre: Floats
    radial: Floats
    tangential: Floats
    skew: float
    rotation: Floats
    translation: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A calibrated rig and how well it explains what was seen.

    Attributes
    ----------
    rig : Rig
    uncertainty : tuple of CameraUncertainty
        One for each camera; empty where the calibration came from elsewhere.
    views : tuple of View
    poses : tuple of RigidTransform
        world_from_target of each view.
    sightings : tuple of Sighting
        What was used.
    residuals : tuple of (N, 2) float64
        Seen minus predicted, px, for each sighting.
    rejected : tuple of (str, str)
        Pictures and views that were not used, and why.
    dropped_points : int
        Single points that contradicted all others.
    covariance : (C * 16, C * 16) float64
        Of the unknowns of all cameras, see
        :class:`~shapemorph.methods.cameras.bundle.Adjusted`; empty where it is not known.
    """

    rig: Rig
    uncertainty: tuple[CameraUncertainty, ...] = ()
    views: tuple[View, ...] = ()
    poses: tuple[RigidTransform, ...] = ()
    sightings: tuple[Sighting, ...] = ()
    residuals: tuple[Floats, ...] = ()
    rejected: tuple[tuple[str, str], ...] = field(default=())
    dropped_points: int = 0
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    def rms(self, camera: int | None = None, view: int | None = None) -> float:
        """Root mean square distance between seen and predicted points, px; NaN without any."""
        squares = [
            (residual**2).sum(axis=1)
            for sighting, residual in zip(self.sightings, self.residuals, strict=True)
            if camera in (None, sighting.camera) and view in (None, sighting.view)
        ]
        return float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else float("nan")
