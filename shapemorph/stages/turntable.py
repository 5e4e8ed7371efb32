"""Stage `twin`, its turntable: a blown sheet that turns before one camera."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.config import TwinConfig
from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.camera import Camera
from shapemorph.core.laws import RadialProfile
from shapemorph.core.transform import RigidTransform
from shapemorph.core.turn_twin import TurnTwin
from shapemorph.methods.cameras.relative import compose
from shapemorph.methods.synthetic.membrane.blow import Blowing, blow
from shapemorph.methods.synthetic.membrane.flanged import flanged_maps, radial_profile
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.methods.synthetic.photograph import Sheet, Studio, take_picture
from shapemorph.methods.synthetic.photographs import Film, shade_dots
from shapemorph.methods.synthetic.revolution import disc_map, dome
from shapemorph.methods.synthetic.speckle import scatter_speckle
from shapemorph.methods.synthetic.stereo_rig import MM_PER_PX, viewing_distance
from shapemorph.methods.synthetic.turntable import dotted_cone, turntable_camera, turntable_poses

DIE, SHEET = 22.5, 1.35  # mm: radius of the die, thickness of the hot sheet
FLANGE, ROUNDING, BEND = 7.5, 2.0, 0.8  # mm: width, material in the bend at the die, bent up
OTHER_EXPONENT, OTHER_HEIGHT = 0.7, 0.9  # of the law's conditions: wrong on purpose
DARK = 5.0, 0.65  # mm of material around the pole, and share of the light that is lost there
AMBIENT, HARDNESS, GLARE = 0.25, 60.0, 10.0
LIGHTS = ((-0.50, -0.55, -0.67, 0.40), (0.60, -0.20, -0.77, 0.35))  # beside the camera
MEASURED = 28.0  # mm: the masks end there
LANDMARKS = np.deg2rad([20.0, 140.0, 260.0])  # where on the flange
LANDMARK_RADIUS, PICKED = 26.0, 0.05  # mm, and how well a hand finds them
DOT_SAMPLES = 12  # in each pixel of a dot
DOTS = 9  # along a radius, each way
PLACED = (  # part_from_die before and after: the sheet is put onto the table by hand
    RigidTransform(np.eye(3), np.array([0.12, -0.08, 0.05])),
    RigidTransform(
        Rotation.from_euler("zx", [4.0, 0.3], degrees=True).as_matrix(),
        np.array([-0.20, 0.15, 0.10]),
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A picture of the turn.

    Attributes
    ----------
    number : int
    grey : (H, W) float32
    mask : (H, W) bool
        Where the sheet is seen, without the rim of its flange.
    """

    number: int
    grey: Greys
    mask: Bools


def make_turn_twin(config: TwinConfig) -> TurnTwin:
    """Find the shape of the sheet, and place the camera before the turntable.

    Raises
    ------
    StageError
        If the finite elements find no equilibrium.
    """
    edge = DIE + FLANGE
    maps = flanged_maps(_true_profile(config), edge=edge, rounding=ROUNDING, bend=BEND)
    camera = turntable_camera(config.scale)
    return TurnTwin(
        camera=camera,
        poses=turntable_poses(camera, config.frames, viewing_distance()),
        target=dotted_cone(edge),
        radius=DIE,
        edge=edge,
        maps=maps,
        placed=PLACED,
    )


def other_law(config: TwinConfig) -> RadialProfile:
    """Blow the sheet under other conditions: a law that brings the states close, not more."""
    blown = _blown(config.rings, OTHER_EXPONENT, OTHER_HEIGHT * config.height)
    beyond = DIE + FLANGE * np.arange(1, 9) / 8
    return RadialProfile(
        material=np.concatenate([blown.material, beyond]),
        radius=np.concatenate([blown.radius, beyond]),
        height=np.concatenate([blown.height, np.zeros(8)]),
    )


def turn_pictures(twin: TurnTwin, config: TwinConfig, state: int) -> Iterator[Frame]:
    """Photograph one state, 0 or 1, as the table turns.

    The lights stand beside the camera, so that glare wanders over the part.
    """
    flat = disc_map(twin.edge, lambda material: map_points(twin.maps[0], material))
    diameter = config.speckle_px * MM_PER_PX / config.scale
    speckle = scatter_speckle(flat, diameter=diameter, rng=_stream(config, 0))
    dark = (DARK[0], DARK[1] * state)
    sheet = Sheet(twin.maps[state], twin.edge, speckle, dark)
    film = Film(twin.camera)
    for number, pose in enumerate(twin.poses):
        beside = shade_dots(film, pose, twin.target, DOT_SAMPLES)
        camera = twin.camera.placed(compose(pose, twin.placed[state]))
        noise = _stream(config, 10 + 2 * number + state)
        grey, material = take_picture(sheet, camera, _studio(config, camera), noise, beside)
        yield Frame(number, grey, np.linalg.norm(material, axis=-1) <= MEASURED)


def landmarks(twin: TurnTwin, config: TwinConfig) -> tuple[Floats, Floats]:
    """Pick marks on the flange by hand, before and after: (K, 3) in the frame of the part, mm."""
    around = np.stack([np.cos(LANDMARKS), np.sin(LANDMARKS)], axis=1)
    before, after = marks(twin, LANDMARK_RADIUS * around)
    picked = _stream(config, 5).normal(0.0, PICKED, (2, *before.shape))
    return before + picked[0], after + picked[1]


def marks(twin: TurnTwin, material: Floats) -> tuple[Floats, Floats]:
    """Where material points (N, 2) are before and after, (N, 3) in the frame of the part, mm."""
    before, after = (
        placed.apply(map_points(mapped, material)[0])
        for placed, mapped in zip(twin.placed, twin.maps, strict=True)
    )
    return before, after


def dots_on_diameter(twin: TurnTwin) -> Floats:
    """Material coordinates (K, 2) of dots along a diameter, mm."""
    place = np.linspace(-0.9, 0.9, 2 * DOTS + 1) * twin.radius
    return np.column_stack([place, np.zeros_like(place)])


def _studio(config: TwinConfig, camera: Camera) -> Studio:
    """Light that stands beside the camera, given in the world where the sheet lies still."""
    lights = np.array(LIGHTS)
    lights[:, :3] /= np.linalg.norm(lights[:, :3], axis=1, keepdims=True)
    lights[:, :3] = camera.pose.inverse().rotate(lights[:, :3])
    return Studio(
        lights=lights,
        ambient=AMBIENT,
        gloss=GLARE * config.gloss,
        hardness=HARDNESS,
        samples=config.samples,
        blur_px=config.blur_px,
        noise=config.noise,
    )


def _true_profile(config: TwinConfig) -> RadialProfile:
    if config.law == "fe":
        return _blown(config.rings, config.exponent, config.height)
    reach = DIE * np.arange(config.rings + 1) / config.rings
    after, _ = dome(2 * DIE).deformed(np.column_stack([reach, np.zeros_like(reach)]))
    return RadialProfile(reach, np.abs(after[:, 0]), after[:, 2] - after[:, 2].min())


def _blown(rings: int, exponent: float, height: float) -> RadialProfile:
    *_, last = blow(Blowing(DIE, SHEET, exponent), rings, height * DIE)
    return radial_profile(last.nodes, DIE, rings)


def _stream(config: TwinConfig, number: int) -> np.random.Generator:
    """Random numbers of one purpose, so that one option does not shift all the others."""
    return np.random.default_rng([config.seed, number])
