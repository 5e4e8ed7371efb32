"""Stage `morph`: the deformed picture brought close to the reference, by one of several laws."""

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shapemorph.config import Law, MorphConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import ConfigError, StageError
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.laws import Dots, LawInputs, NodalField
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.morphed import Morphed
from shapemorph.methods.densify import grid_points
from shapemorph.methods.laws.finite_elements import Motion, place_field, place_profile
from shapemorph.methods.laws.identity import identity_warp, rigid_warp
from shapemorph.methods.laws.landmarks import on_a_line, profile_of_dots
from shapemorph.methods.laws.polynomial import PolynomialLaw, fit_polynomial_law
from shapemorph.methods.laws.radial import Profile, RadialPose, law_pairs
from shapemorph.methods.laws.settling import settle_warp
from shapemorph.methods.morphing import morph_image, morph_surface
from shapemorph.methods.rough_start import place_in_picture
from shapemorph.methods.surface_lookup import locate, positions
from shapemorph.methods.warp_fit import fit_warp

log = logging.getLogger(__name__)

POINTS = 2500  # of a picture that a law is asked about
STIFFNESS = 1e-4  # of a warp through points that a law gives: it has no noise
DOTS_STIFFNESS = 1e-3  # of a warp through a few dots
ENOUGH_DOTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """One picture, and the surface that it shows where it shows one.

    Attributes
    ----------
    image : GreyImage
    mesh : TexturedMesh or None
    calibrated : CalibratedImage or None
        Of that mesh.
    """

    image: GreyImage
    mesh: TexturedMesh | None = None
    calibrated: CalibratedImage | None = None

    @property
    def px_per_mm(self) -> float:
        """Scale of the picture; plain pictures are measured in px."""
        return self.calibrated.chart.px_per_mm if self.calibrated else 1.0

    def surface(self, law: str) -> tuple[TexturedMesh, CalibratedImage]:
        """Give mesh and calibrated image, for laws in space."""
        if self.mesh is None or self.calibrated is None:
            raise ConfigError(
                f"{law} needs two textured meshes, got two pictures: choose morph.law=warp, "
                "polynomial or identity, or give morph.dots"
            )
        return self.mesh, self.calibrated


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    """Everything that a law may look at."""

    reference: Side
    deformed: Side
    matches: Matches
    inputs: LawInputs
    config: MorphConfig

    def matches_mm(self) -> tuple[Floats, Floats]:
        """Give the matched points in mm of the two pictures."""
        return (
            self.matches.reference_px / self.reference.px_per_mm,
            self.matches.deformed_px / self.deformed.px_per_mm,
        )


def morph(  # noqa: PLR0913, PLR0917 - two sides, each a mesh with its picture
    reference_mesh: TexturedMesh,
    reference: CalibratedImage,
    deformed_mesh: TexturedMesh,
    deformed: CalibratedImage,
    matches: Matches,
    inputs: LawInputs,
    config: MorphConfig,
) -> Morphed:
    """Make the deformed surface look like the reference picture, straight from its texture.

    Parameters
    ----------
    reference_mesh : TexturedMesh
    reference : CalibratedImage
    deformed_mesh : TexturedMesh
    deformed : CalibratedImage
    matches : Matches
        The law `warp` is made of them. For the others they settle what the law leaves
        open: how the pictures, or shapes, lie over each other.
    inputs : LawInputs
        What is read for laws.
    config : MorphConfig
        Section ``morph`` of the run file.

    Raises
    ------
    ConfigError
        If the law misses what it needs.
    StageError
        If the law is of no use, for itself or for these pictures.
    """
    task = _Task(
        Side(reference.image, reference_mesh, reference),
        Side(deformed.image, deformed_mesh, deformed),
        matches,
        inputs,
        config,
    )
    warp, overruled = _usable_warp(task)
    shown = morph_surface(deformed_mesh, deformed, warp, reference.image.shape)
    return Morphed(shown, warp, overruled)


def morph_pictures(
    reference: GreyImage,
    deformed: GreyImage,
    matches: Matches,
    inputs: LawInputs,
    config: MorphConfig,
) -> Morphed:
    """Make a plain deformed picture look like the reference picture; see :func:`morph`."""
    task = _Task(Side(reference), Side(deformed), matches, inputs, config)
    warp, overruled = _usable_warp(task)
    return Morphed(morph_image(deformed, warp, reference.shape), warp, overruled)


def law_warp(
    reference: Side,
    deformed: Side,
    matches: Matches,
    inputs: LawInputs,
    config: MorphConfig,
    *,
    law: Law,
) -> Warp:
    """Warp that a law describes by itself, however far from the truth."""
    _require_one_page(reference, law)
    return LAWS[law](_Task(reference, deformed, matches, inputs, config))


def _require_one_page(side: Side, law: Law) -> None:
    pages = side.calibrated.chart.page_count if side.calibrated else 1
    if law != "warp" and pages > 1:
        raise StageError(
            f"law {law} needs a reference that lies flat in one piece, got {pages} pages: choose "
            "morph.law=warp, or flatten.charts=1"
        )


def _usable_warp(task: _Task) -> tuple[Warp, int]:
    """Warp of the law, corrected until the pictures agree with it; matches that took over."""
    law = task.config.law
    if law == "warp":
        return task.matches.forward, 0
    warp = law_warp(task.reference, task.deformed, task.matches, task.inputs, task.config, law=law)
    pairs = task.matches.reference_px, task.matches.deformed_px
    settled = settle_warp(task.reference.image, task.deformed.image, warp, pairs)
    log.info("law %s: %.0f %% of the grid found through it", law, 100 * settled.found)
    if settled.added:
        log.warning(
            "law %s leads nowhere at %d matches: there the matches take over", law, settled.added
        )
    return settled.warp, settled.added


def _free_warp(task: _Task) -> Warp:
    return task.matches.forward


def _identity(task: _Task) -> Warp:
    """Nothing is deformed; shapes that were laid flat each for itself still turn and shift."""
    shape = task.reference.image.shape
    if task.reference.calibrated is None:
        return identity_warp(shape)
    scale = task.deformed.px_per_mm / task.reference.px_per_mm
    return rigid_warp(shape, task.matches.reference_px, task.matches.deformed_px, scale=scale)


def _polynomial(task: _Task) -> Warp:
    law = _radial_law(task, task.config.coefficients)
    return _radial_warp(task, law.pose, law.profile)


def _radial_law(task: _Task, coefficients: list[float] | None) -> PolynomialLaw:
    centre = task.config.centre
    return fit_polynomial_law(
        *task.matches_mm(),
        order=task.config.order,
        centre=None if centre is None else np.array(centre) / task.reference.px_per_mm,
        coefficients=coefficients,
    )


def _radial_warp(task: _Task, pose: RadialPose, profile: Profile) -> Warp:
    """Warp of a law of revolution, from what it says about a grid of the deformed picture."""
    mask = task.deformed.image.mask
    points = grid_points(mask, _step(mask.sum())) / task.deformed.px_per_mm
    source, target = law_pairs(pose, profile, points)
    return _through(
        task, source * task.reference.px_per_mm, target * task.deformed.px_per_mm, STIFFNESS
    )


def _landmarks(task: _Task) -> Warp:
    """Dots along a diameter: a radial law through them; scattered: a smooth warp."""
    dots = _dots(task)
    if not on_a_line(dots.reference_px):
        return _through(task, dots.reference_px, dots.deformed_px, DOTS_STIFFNESS)
    pose = _radial_law(task, None).pose
    profile = profile_of_dots(
        pose,
        dots.reference_px / task.reference.px_per_mm,
        dots.deformed_px / task.deformed.px_per_mm,
    )
    return _radial_warp(task, pose, profile)


def _dots(task: _Task) -> Dots:
    """Find marks in the pictures: as given, or the landmarks of the shapes."""
    if task.inputs.dots is not None:
        dots = task.inputs.dots
    elif task.inputs.landmarks is not None:
        landmarks = task.inputs.landmarks
        dots = Dots(
            _picture_of(task.reference, landmarks.reference),
            _picture_of(task.deformed, landmarks.deformed),
        )
    else:
        raise ConfigError("law landmarks needs marks: give morph.dots or inputs.landmarks")
    known = np.isfinite(dots.reference_px).all(axis=1) & np.isfinite(dots.deformed_px).all(axis=1)
    if known.sum() < ENOUGH_DOTS:
        raise ConfigError(
            f"law landmarks needs at least {ENOUGH_DOTS} marks on both surfaces, got {known.sum()}"
        )
    return Dots(dots.reference_px[known], dots.deformed_px[known])


def _finite_elements(task: _Task) -> Warp:
    """Where a model sends a grid of the reference: nearest point of the deformed surface."""
    given = task.inputs.finite_elements
    if given is None:
        raise ConfigError("law fe needs a finite element result: give morph.fe")
    before = _places(task.reference, task.matches.reference_px)
    after = _places(task.deformed, task.matches.deformed_px)
    motion: Motion
    if isinstance(given, NodalField):
        motion = place_field(given, before, after)
    else:
        motion = place_profile(given, before, after)
    mask = task.reference.image.mask
    pixels = grid_points(mask, _step(mask.sum()))
    points = _places(task.reference, pixels)
    on = np.isfinite(points).all(axis=1)
    return _through(task, pixels[on], _picture_of(task.deformed, motion(points[on])), STIFFNESS)


def _places(side: Side, pixels: Floats) -> Floats:
    """(N, 3) positions on the surface, mm, of points (N, 2) of its picture."""
    mesh, image = side.surface("law fe")
    return positions(mesh, locate(image, pixels))


def _picture_of(side: Side, points: Floats) -> Floats:
    """(N, 2) places in the picture of the points of its surface nearest to some in space."""
    return place_in_picture(side.surface("a law in space"), points)


def _step(pixels: int) -> float:
    return float(np.sqrt(pixels / POINTS))


def _through(task: _Task, source: Floats, target: Floats, stiffness: float) -> Warp:
    """Smooth warp through what a law says, defined over the whole reference picture."""
    height, width = task.reference.image.shape
    spacing = max(2.0 * _step(task.reference.image.mask.sum()), 4.0)
    high = np.array([width, height]) - 1.0
    near = (source > -spacing).all(axis=1) & (source < high + spacing).all(axis=1)
    if near.sum() < ENOUGH_DOTS:
        raise StageError("the morph law leads out of the reference picture: check its parameters")
    return fit_warp(
        source[near],
        target[near],
        extent=(-np.full(2, spacing), high + spacing),
        spacing=spacing,
        smoothing=stiffness,
    )


LAWS: dict[Law, Callable[[_Task], Warp]] = {
    "warp": _free_warp,
    "polynomial": _polynomial,
    "landmarks": _landmarks,
    "fe": _finite_elements,
    "identity": _identity,
}
