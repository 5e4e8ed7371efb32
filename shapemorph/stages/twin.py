"""Stage `twin`: a synthetic experiment in front of two cameras."""

from collections.abc import Iterator

import numpy as np

from shapemorph.config import TwinConfig
from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.spline_map import SplineMap
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.methods.synthetic.dot_plate import DotPlate, random_plate_pose
from shapemorph.methods.synthetic.membrane.blow import Blowing, blow
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.punch import Indentation, clamped_disc, indent
from shapemorph.methods.synthetic.membrane.smooth import fit_map, map_points
from shapemorph.methods.synthetic.photograph import Sheet, Studio, material_at, take_picture
from shapemorph.methods.synthetic.revolution import disc_map, dome, indentation
from shapemorph.methods.synthetic.speckle import scatter_speckle
from shapemorph.methods.synthetic.stereo_rig import MM_PER_PX, stereo_rig

SIZE, THICKNESS, PUNCH = 76.0, 1.0, 13.5  # mm; radius of the tip
DIE, SHEET = 22.5, 1.35  # mm: radius of the die, thickness of the hot sheet
KNOTS = 1.6  # element rings between the coefficients of a map: facets do not show in it
MIDDLE = 0.4  # of the travel: the height that the cameras look at
SAMPLES_OF_ANALYTIC = 60  # rings at which the closed form is sampled
CLEAR = {"membrane": 0.975, "bulge": 0.55}  # of the radius: beyond it clamp, or steep wall
PLATE = DotPlate(columns=11, rows=9, spacing=5.0, diameter=2.4, radius=36.0)
AMBIENT, HARDNESS = 0.25, 30.0
LIGHTS = ((0.30, 0.50, 0.81, 0.40), (-0.40, -0.20, 0.89, 0.35))  # towards each, and strength


def make_twin(config: TwinConfig) -> StereoTwin:
    """Find the shape of the sheet in every state, and place the cameras.

    Raises
    ------
    StageError
        If the finite elements find no equilibrium.
    """
    radius, highest = _size(config)
    travel = np.linspace(0.0, highest, config.steps + 1)
    if config.law == "analytic":
        maps = _analytic(config, travel)
    elif config.kind == "membrane":
        maps = _indented(config, travel)
    else:
        maps, travel = _blown(config, travel)
    rig = stereo_rig(scale=config.scale, target=_target(config))
    return StereoTwin(config.kind, rig, radius, maps, travel)


def twin_pictures(twin: StereoTwin, config: TwinConfig) -> Iterator[tuple[str, int, Greys]]:
    """Photograph all states.

    Yields
    ------
    camera : str
    state : int
    grey : (H, W) float32
    """
    flat = disc_map(twin.radius, lambda material: map_points(twin.maps[0], material))
    diameter = config.speckle_px * MM_PER_PX / config.scale
    speckle = scatter_speckle(flat, diameter=diameter, rng=_stream(config, 0))
    studio = _studio(config)
    for state, mapped in enumerate(twin.maps):
        sheet = Sheet(mapped, twin.radius, speckle)
        for number, (name, camera) in enumerate(zip(twin.rig.names, twin.rig.cameras, strict=True)):
            noise = _stream(config, 10 + 2 * state + number)
            yield name, state, take_picture(sheet, camera, studio, noise)[0]


def calibration_pictures(twin: StereoTwin, config: TwinConfig) -> Iterator[tuple[str, int, Greys]]:
    """Photograph a plate of dots in many places; see :func:`twin_pictures`."""
    studio, pattern = _studio(config), PLATE.pattern()
    target = _target(config)
    for view in range(config.views):
        pose = random_plate_pose(target, _stream(config, 1_000 + view))
        sheet = Sheet(PLATE.placed(pose), PLATE.radius, pattern)
        for number, (name, camera) in enumerate(zip(twin.rig.names, twin.rig.cameras, strict=True)):
            noise = _stream(config, 2_000 + 2 * view + number)
            yield name, view, take_picture(sheet, camera, studio, noise)[0]


def region_of_first(twin: StereoTwin) -> Bools:
    """Where the first picture of the first camera shows the sheet well inside its rim."""
    camera = twin.rig.cameras[0]
    width, height = camera.size
    rows, columns = np.mgrid[:height, :width].astype(np.float64)
    inner = Sheet(twin.maps[0], CLEAR[twin.kind] * twin.radius, PLATE.pattern())
    seen = material_at(inner, camera, np.stack([columns, rows], axis=-1).reshape(-1, 2))
    return np.isfinite(seen[:, 0]).reshape(height, width)


def _studio(config: TwinConfig) -> Studio:
    lights = np.array(LIGHTS)
    lights[:, :3] /= np.linalg.norm(lights[:, :3], axis=1, keepdims=True)
    return Studio(
        lights=lights,
        ambient=AMBIENT,
        gloss=config.gloss,
        hardness=HARDNESS,
        samples=config.samples,
        blur_px=config.blur_px,
        noise=config.noise,
    )


def _size(config: TwinConfig) -> tuple[float, float]:
    """Radius of the sheet and way of its middle in the end, mm."""
    if config.kind == "membrane":
        return 0.5 * SIZE, config.travel
    return DIE, DIE * (config.height if config.law == "fe" else 3.0 - 0.5 * np.pi)


def _target(config: TwinConfig) -> Floats:
    """Point (3,) that both cameras look at, mm."""
    return np.array([0.0, 0.0, MIDDLE * _size(config)[1]])


def _indented(config: TwinConfig, travel: Floats) -> tuple[SplineMap, ...]:
    case = Indentation(
        radius=0.5 * SIZE,
        thickness=THICKNESS,
        punch=PUNCH,
        offset=(config.offset, 0.0),
        tilt=float(np.deg2rad(config.tilt)),
        gap=0.0,
    )
    states = [state.nodes for state in indent(case, clamped_disc(case, config.rings), travel[1:])]
    return _smooth(config, disc_mesh(case.radius, config.rings)[0], states)


def _blown(config: TwinConfig, heights: Floats) -> tuple[tuple[SplineMap, ...], Floats]:
    """Give maps of the states nearest to some heights, and the heights that these have."""
    case = Blowing(DIE, SHEET, config.exponent)
    states = list(blow(case, config.rings, float(heights[-1])))
    reached = np.array([state.height for state in states])
    chosen = [int(np.abs(reached - height).argmin()) for height in heights[1:]]
    maps = _smooth(
        config, disc_mesh(DIE, config.rings)[0], [states[number].nodes for number in chosen]
    )
    return maps, np.concatenate([[0.0], reached[chosen]])


def _smooth(config: TwinConfig, material: Floats, states: list[Floats]) -> tuple[SplineMap, ...]:
    """Lay maps through the flat sheet and through the nodes of all states."""
    flat = np.column_stack([material, np.zeros(len(material))])
    spacing = KNOTS * _size(config)[0] / config.rings
    return tuple(fit_map(material, nodes, spacing=spacing) for nodes in (flat, *states))


def _analytic(config: TwinConfig, travel: Floats) -> tuple[SplineMap, ...]:
    """Let a shape in closed form grow in proportion."""
    radius, _ = _size(config)
    material, _ = disc_mesh(radius, SAMPLES_OF_ANALYTIC)
    flat = np.column_stack([material, np.zeros(len(material))])
    if config.kind == "membrane":
        tilt = float(np.deg2rad(config.tilt))
        full, _ = indentation(SIZE, offset=config.offset, tilt=tilt).deformed(material)
    else:
        full, _ = dome(2 * DIE).deformed(material)
        full[:, 2] -= full[:, 2].min()
    shares = travel / full[:, 2].max()
    return _smooth(config, material, [flat + share * (full - flat) for share in shares[1:]])


def _stream(config: TwinConfig, number: int) -> np.random.Generator:
    """Random numbers of one purpose, so that one option does not shift all the others."""
    return np.random.default_rng([config.seed, number])
