"""Two calibrated cameras on public photographs: shifts, strains and noise of what did not deform.

    python benchmarks/stereo.py [static] [cylinder] [--data FOLDER]

`static`: a pair of pictures of one state, twice (dice_stereo_static); its calibration file is
that of another rig, so that the cameras are oriented anew. `cylinder`: a rigid cylinder shifted
twice (multidic_cylinder), calibrated from its own boards and dots. The material is followed as
`shapemorph track` does: across from the first left picture to the first right one, then in each
camera from its own first picture, so that the error of the step across is the same in all states.
It is triangulated, and strain is fitted over a window.

The noise floor is the spatial standard deviation after the motion is taken out: in the pictures
(an affine map: displacements in either camera, and the disparity, in px) and in space (a rigid
motion: x, y, z in mm, and in pixels of the size that they have on the object). Along the line of
sight a camera pair magnifies: a change of the disparity by 1 px moves a point by distance /
baseline pixels of its own size, which is printed beside.
The pictures are not part of the repository: give their folder, or set SHAPEMORPH_DATA.
"""

import argparse
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shapemorph.cli.main import main
from shapemorph.config import RunConfig, StrainConfig
from shapemorph.core.camera import Rig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.surface import TrackedSurface
from shapemorph.io.images import read_grey_image
from shapemorph.io.rig_files import read_rig
from shapemorph.methods.cameras.grid_surface import place_grid
from shapemorph.methods.cameras.triangulation import triangulate
from shapemorph.methods.carried_mask import limit_to_carried
from shapemorph.methods.increments import compose_grids, warp_through
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.rigid import fit_rigid
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs
from shapemorph.stages.reconstruct import oriented
from shapemorph.stages.strain import strain


@dataclass(frozen=True)
class Case:
    """Pictures of both cameras, by state, and how they are measured."""

    rig: Rig
    left: list[GreyImage]
    right: list[GreyImage]
    subset: int
    spacing: int
    window: int
    orient: bool


def boxed(path: Path, box: tuple[int, int, int, int]) -> GreyImage:
    """Read a picture, limited to left, top, right and bottom."""
    picture = read_grey_image(path)
    mask = np.zeros(picture.shape, dtype=bool)
    left, top, right, bottom = box
    mask[top:bottom, left:right] = True
    return GreyImage(picture.grey, picture.mask & mask)


def _magnified(rig: Rig, points: np.ndarray) -> float:
    """Distance over baseline."""
    one, other = rig.cameras[:2]
    baseline = np.linalg.norm(one.position - other.position)
    return float(np.nanmedian(points[..., 2]) / baseline)


def follow(first: GreyImage, other: GreyImage, config: RunConfig) -> CorrelationGrid:
    """Follow the points of the first picture into another."""
    clock = Clock(lambda _: None)
    return follow_pictures(first, other, config, picture_law_inputs(config), clock).grid


def measure(case: Case, name: str) -> None:
    """Print what each later state shows against the first."""
    config = RunConfig.model_validate(
        {"correlate": {"subset_size": case.subset, "spacing": case.spacing}}
    )
    across = follow(case.left[0], case.right[0], config)
    rig = oriented(case.rig, across) if case.orient else case.rig
    before = place_grid(rig, across, limit=None, smoothed=None)
    gauge = (case.window - 1) * case.spacing + case.subset
    px_per_mm = rig.cameras[0].focal[0] / np.nanmedian(before.points[..., 2])
    print(
        f"{name}: {int((before.status == 0).sum())} points, {px_per_mm:.2f} px/mm, epipolar "
        f"{np.sqrt(np.nanmean(before.epipolar_px[before.status == 0] ** 2)):.3f} px rms, "
        f"gauge {gauge} px; a pixel of disparity is {_magnified(rig, before.points):.1f} px of z"
    )
    still = identity_warp(case.left[0].shape)
    seen = limit_to_carried(case.right[0], case.left[0], warp_through(across, still))
    for number in range(1, len(case.left)):
        here = follow(case.left[0], case.left[number], config)
        later = follow(seen, case.right[number], config)
        there = compose_grids(across, later, shown=case.right[number].mask)
        _compare(case, rig, before.points, here, there, (number, px_per_mm))
        _in_pictures(across, here, there, later)


def _in_pictures(
    across: CorrelationGrid, here: CorrelationGrid, there: CorrelationGrid, later: CorrelationGrid
) -> None:
    """Print how displacements and disparity scatter about an affine map, px."""
    ok = (here.status == 0) & (there.status == 0)
    left = (here.deformed_px - here.reference_px)[ok]
    right = (there.deformed_px - across.deformed_px)[ok]
    plane = np.column_stack([here.reference_px[ok], np.ones(int(ok.sum()))])
    expected = [np.nanmean(grid.sigma_px[grid.status == 0] ** 2, axis=0) for grid in (here, later)]
    found = {
        "left": (left, expected[0]),
        "right": (right, expected[1]),
        "disparity": (right - left, sum(expected)),
    }
    print("    in the pictures, along and across [px]:")
    for name, (change, variance) in found.items():
        rest = change - plane @ np.linalg.lstsq(plane, change)[0]
        told = ", ".join(f"{s:.4f}" for s in np.sqrt(variance))
        print(f"      {name:10s}{rest[:, 0].std():.4f}, {rest[:, 1].std():.4f} (expected {told})")


def _compare(
    case: Case,
    rig: Rig,
    before: np.ndarray,
    here: CorrelationGrid,
    there: CorrelationGrid,
    label: tuple[int, float],
) -> None:
    ok = (here.status == 0) & (there.status == 0) & np.isfinite(before).all(axis=-1)
    pixels = np.stack([here.deformed_px[ok], there.deformed_px[ok]])
    sigma = np.stack([here.sigma_px[ok], there.sigma_px[ok]])
    after = np.full(before.shape, np.nan)
    after[ok] = triangulate(rig.cameras, pixels, sigma).points
    motion = fit_rigid(before[ok], after[ok], np.ones(int(ok.sum())))
    moved = after[ok] - before[ok]
    noise = after[ok] - motion.apply(before[ok])
    tracked = TrackedSurface(
        np.where(np.isfinite(before), before, 0.0),
        after,
        np.zeros(before.shape),
        np.zeros(before.shape),
        np.where(ok, 0.01, np.nan),
        np.where(ok, 0, 6).astype(np.uint8),
        np.zeros(2),
    )
    found = strain(tracked, here, StrainConfig(window=case.window))
    tensor = found.tensor[np.isfinite(found.tensor).all(axis=(-2, -1))]
    number, px_per_mm = label
    spread = noise.std(axis=0)
    print(
        f"  state {number}: shift {np.linalg.norm(moved.mean(axis=0)):.4f} mm; strain rms "
        f"{', '.join(f'{s:.1e}' for s in _rms(tensor))} (Exx, Eyy, Exy)"
    )
    print("    in space:")
    for name, s in zip("xyz", spread, strict=True):
        print(f"      {name:10s}{s:.5f} mm = {s * px_per_mm:.4f} px")


def _rms(tensor: np.ndarray) -> list[float]:
    return [float(np.sqrt((tensor[:, i, j] ** 2).mean())) for i, j in ((0, 0), (1, 1), (0, 1))]


def static(data: Path) -> Case:
    """One state twice; 1280 x 800 px."""
    folder = data / "dice_stereo_static"
    rig = read_rig(folder / "cal.xml", (1280, 800))
    box = (160, 300, 1100, 540)
    left = [boxed(folder / "images" / f"img_000{k}_0.tif", box) for k in (0, 5)]
    right = [read_grey_image(folder / "images" / f"img_000{k}_1.tif") for k in (0, 5)]
    return Case(rig, left, right, subset=27, spacing=9, window=25, orient=True)


def cylinder(data: Path) -> Case:
    """A rigid cylinder in three places."""
    folder = data / "multidic_cylinder"
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "rig.yaml"
        path.write_text(RIG.format(data=folder))
        main(["calibrate", str(path), "-o", scratch, "--set", "report.figures=false"])
        rig = read_rig(Path(scratch) / "calibration.json", (1, 1))
    box = (920, 600, 1440, 2450)
    left = [boxed(folder / f"speckle/201/201_{k}.jpg", box) for k in (1, 2, 3)]
    right = [read_grey_image(folder / f"speckle/202/202_{k}.jpg") for k in (1, 2, 3)]
    return Case(rig, left, right, subset=41, spacing=12, window=21, orient=False)


RIG = """
cameras: ["201", "202"]
targets:
  board: {{kind: chessboard, columns: 19, rows: 14, spacing: 10}}
  cylinder:
    kind: points
    points: {data}/calibration_cylinder/calibrationObjectCoordinates.csv
    dot_diameter: 4
    dot_shape: square
views:
  - target: board
    simultaneous: false
    pictures:
      "201": {data}/checkerboard/201/201_*.jpg
      "202": {data}/checkerboard/202/202_*.jpg
  - target: cylinder
    pictures:
      "201": {data}/calibration_cylinder/201.jpg
      "202": {data}/calibration_cylinder/202.jpg
    anchors:
      "201": [[20, 6, 1214, 446], [1, 6, 1214, 2606]]
      "202": [[20, 8, 1110, 410], [1, 8, 1076, 2580]]
"""


def run() -> None:
    """Measure the cases that are asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", nargs="*", default=["static", "cylinder"])
    parser.add_argument("--data", type=Path)
    given = parser.parse_args()
    data = given.data or Path(os.environ.get("SHAPEMORPH_DATA", "../shared/data"))
    for name in given.cases:
        measure({"static": static, "cylinder": cylinder}[name](data), name)


if __name__ == "__main__":
    run()
