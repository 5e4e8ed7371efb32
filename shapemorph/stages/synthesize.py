"""Stage `synthesize`: a textured pair with exact truth."""

import numpy as np

from shapemorph.config import DamageConfig, SynthesizeConfig
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.synthetic import DamageSpot, SyntheticPair
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.curved import freeform_name
from shapemorph.methods.synthetic.damage import place_damage
from shapemorph.methods.synthetic.material import MaterialMap
from shapemorph.methods.synthetic.painting import Scene, random_light
from shapemorph.methods.synthetic.shapes import material_map
from shapemorph.methods.synthetic.sheet import sheet_name
from shapemorph.methods.synthetic.sides import Scanner, random_pose, record_side
from shapemorph.methods.synthetic.speckle import Speckle, scatter_speckle
from shapemorph.methods.synthetic.truth import make_truth


def synthesize(config: SynthesizeConfig) -> SyntheticPair:
    """Make two textured meshes of one object and the exact truth about its deformation.

    The speckle belongs to the material; triangulation, atlas, pose, light and noise belong
    to each side. Everything random follows from `config.seed`.

    Parameters
    ----------
    config : SynthesizeConfig
        Section ``synthesize`` of the run file, lengths in mm.

    Raises
    ------
    ConfigError
        If the punch of an indentation lies too near its clamp.
    """
    tilt = float(np.deg2rad(config.tilt))
    shape = _shape(config)
    mapped = material_map(shape, size=config.size, offset=config.offset, tilt=tilt)
    speckle = scatter_speckle(mapped, diameter=config.speckle, rng=_stream(config, 0))
    kinds = damage_kinds(config.damage)
    damage = place_damage(mapped, kinds, size=config.size, rng=_stream(config, 1))
    reference_pose = random_pose(config.size, _stream(config, 2))
    deformed_pose = random_pose(config.size, _stream(config, 3))
    truth = make_truth(
        shape,
        size=config.size,
        offset=config.offset,
        tilt=tilt,
        poses=(reference_pose, deformed_pose),
        damage=damage,
    )
    reference = _side(config, mapped, speckle, (), reference_pose, "reference")
    deformed = _side(config, mapped, speckle, damage, deformed_pose, "deformed")
    return SyntheticPair(reference, deformed, truth)


def damage_kinds(config: DamageConfig) -> tuple[str, ...]:
    """Names of the kinds of damage that are asked for."""
    asked = {
        "print": config.print_at_pole,
        "glare": config.glare,
        "lost_patch": config.lost_patch,
    }
    return tuple(kind for kind, wanted in asked.items() if wanted)


def _shape(config: SynthesizeConfig) -> str:
    """Name of the material map, with the direction that some are drawn in."""
    if config.shape == "freeform":
        return freeform_name(config.direction)
    if config.shape != "sheet":
        return config.shape
    return sheet_name(stretch=config.stretch, direction=config.direction, turn=config.turn)


def _side(
    config: SynthesizeConfig,
    mapped: MaterialMap,
    speckle: Speckle,
    damage: tuple[DamageSpot, ...],
    pose: RigidTransform,
    name: str,
) -> TexturedMesh:
    rng = _stream(config, 4 if name == "reference" else 5)
    scanner = Scanner(
        faces=config.faces,
        texture=None if config.format == "ply" else config.texture,
        grey_noise=config.grey_noise,
        vertex_noise=config.vertex_noise,
    )
    scene = Scene(mapped, speckle, random_light(rng), damage)
    state = mapped.reference if name == "reference" else mapped.deformed
    return record_side(scene, state, pose, scanner, name=name, rng=rng)


def _stream(config: SynthesizeConfig, number: int) -> np.random.Generator:
    """Random numbers of one purpose, so that one option does not shift all the others."""
    return np.random.default_rng([config.seed, number])
