"""Membrane triangles against an axisymmetric solid of FElupe, where that is installed."""

import numpy as np
import pytest

from shapemorph.methods.synthetic.membrane.punch import Indentation, clamped_disc, indent

fem = pytest.importorskip("felupe")

RIM, PUNCH, DEPTH = 38.0, 13.5, 28.0
THIN, SHEAR = 0.2, 0.5  # mm, MPa: thin, so that bending does not count


def solid_force():
    """Force of a frictionless ball on a thin clamped solid disc, N for 1 mm of thickness."""

    class Ball(fem.mechanics.ContactRigidBase):
        def _kinematics(self, away):
            distance = np.linalg.norm(away, axis=1)
            normal = away / distance[:, None]
            outer = np.einsum("ai,aj->aij", normal, normal)
            return distance - PUNCH, normal, (np.eye(2) - outer) / distance[:, None, None]

    mesh = fem.Rectangle(a=(0, 0), b=(THIN, RIM), n=(3, 101))
    below = np.flatnonzero(mesh.x < 1e-9)
    count = mesh.npoints
    mesh.add_points([-PUNCH, 0.0])
    field = fem.FieldContainer([fem.FieldAxisymmetric(fem.RegionQuad(mesh), dim=2)])
    stiff = SHEAR / THIN
    solid = fem.SolidBodyNearlyIncompressible(fem.NeoHooke(mu=stiff), field, bulk=1000 * stiff)
    ball = Ball(field, below, -1, PUNCH, multiplier=5.0, symmetric=False)
    moved = field[0]
    material, centre = np.arange(mesh.npoints) < count, np.arange(mesh.npoints) == count
    held = {
        "axis": fem.Boundary(moved, mask=(mesh.y < 1e-9) & material, skip=(1, 0)),
        "clamp": fem.Boundary(moved, fy=RIM),
        "centre": fem.Boundary(moved, mask=centre, skip=(1, 0)),
        "push": fem.Boundary(moved, mask=centre, skip=(0, 1)),
    }
    ways = np.linspace(0, DEPTH, 29)[1:]
    step = fem.Step([solid, ball], ramp={held["push"]: ways}, boundaries=held)
    fem.Job([step]).evaluate(verbose=0)
    return abs(float(ball.assemble.vector(field).toarray().ravel()[2 * count]))


@pytest.mark.filterwarnings("ignore")
def test_the_force_is_that_of_a_thin_solid():
    case = Indentation(RIM, 1.0, PUNCH, (0.0, 0.0), 0.0, 0.0)
    (state,) = indent(case, clamped_disc(case, 20), np.array([DEPTH]))
    assert state.force == pytest.approx(solid_force(), rel=0.02)
