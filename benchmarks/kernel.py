"""Print speed and accuracy of the correlation kernel on speckle that is known exactly.

    python benchmarks/kernel.py                 all cases, subset 21, spacing 8
    python benchmarks/kernel.py --quick         fewer cases
    python benchmarks/kernel.py --subset 31

The speckle is that of exact_pictures.py, 1000 x 1000 px. Points start from the exact
displacement rounded to a pixel; timed are Hessians and all iterations, best of several runs,
OK points counted. Errors are those of both
components together over points whose whole warped subset stays inside the deformed picture;
right is within 0.1 px.
"""

import argparse
import datetime as dt
import platform

import numba
import numpy as np
from exact_pictures import (
    SIZE,
    SPACING,
    SPECKLE,
    Case,
    judged_points,
    linear,
    sine,
    slopes_of,
    star,
    take_picture,
    translation,
    turn,
)

from shapemorph.core.status import PointStatus
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetMatches,
    SubsetSettings,
    affine_starts,
    identity_starts,
    match_points,
)
from shapemorph.methods.threads import kernel_threads


def all_cases(*, quick: bool) -> list[Case]:
    """Build the cases of the table."""
    shifts = (0.3, 0.5) if quick else tuple(k / 10 for k in range(1, 10))
    cases = [translation(amount) for amount in shifts]
    cases.append(linear("affine 2 %", [[1.02, 0.01], [-0.01, 0.985]]))
    if not quick:
        cases += [sine(), star(), turn(0, 1.3), turn(25, 1.0), turn(90, 1.0)]
    return cases


def starts_for(case: Case, points: np.ndarray) -> np.ndarray:
    """Whole-pixel starts; with the gradient rounded to 0.05 where it is far from one."""
    where = points + np.round(case.forward(points.astype(np.float64)) - points)
    slopes = slopes_of(case.forward, points.astype(np.float64))
    if np.abs(slopes - np.eye(2)).max() < 0.15:
        starts = identity_starts(len(points))
        starts[:, [0, 6]] = where - points
        return starts
    return affine_starts(points, where, np.round(slopes / 0.05) * 0.05)


def run_case(case: Case, noise: float, options: argparse.Namespace) -> None:
    """Print one line for each order and number of threads."""
    radius = options.subset // 2
    axis = np.arange(3 * SPACING, SIZE - 3 * SPACING, SPACING)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    points = points[judged_points(case.forward, points, radius)]
    truth = case.forward(points.astype(np.float64))
    first = take_picture(lambda p: p, noise, 11, options.speckle)
    second = take_picture(case.back, noise, 12, options.speckle)
    for order in case.orders:
        settings = SubsetSettings(radius, order, 1e-3, 30, 0.5, float(radius))
        reference = prepare_reference(first, allowed=None, pad=settings.pad)
        deformed = prepare_deformed(second, pad=settings.pad)
        starts = starts_for(case, points)
        speeds = []
        for threads in (1, 2):
            with kernel_threads(threads):
                runs = [
                    match_points(reference, deformed, points, starts, settings=settings)
                    for _ in range(options.repeats)
                ]
            best = min(run.seconds for run in runs)
            speeds.append((runs[0].status == PointStatus.OK).sum() / best)
        print_line(case.name, noise, order, runs[0], truth, speeds)


def print_line(
    name: str,
    noise: float,
    order: int,
    found: SubsetMatches,
    truth: np.ndarray,
    speeds: list[float],
) -> None:
    ok = found.status == PointStatus.OK
    error = (found.position - truth)[ok]
    far = np.abs(error).max(axis=1)
    near = error[far < 0.1]
    rms = 1e3 * np.sqrt((near**2).mean()) if len(near) else np.nan
    bias = 1e3 * np.abs(near.mean(axis=0)).max() if len(near) else np.nan
    print(
        f"{name:28s} {noise:5.0f} {order:5d} {speeds[0] / 1e3:8.0f} {speeds[1] / 1e3:8.0f} "
        f"{found.iterations[ok].mean():6.2f} {rms:8.2f} {bias:8.2f} "
        f"{100 * (far < 0.1).sum() / len(ok):8.2f} {100 * (far >= 0.1).sum() / len(ok):8.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer cases")
    parser.add_argument("--subset", type=int, default=21, help="width of a subset, odd, px")
    parser.add_argument("--speckle", type=float, default=SPECKLE, help="size of a speckle, px")
    parser.add_argument("--repeats", type=int, default=7, help="runs, of which the best counts")
    options = parser.parse_args()
    today = dt.datetime.now(tz=dt.UTC).date().isoformat()
    print(f"{today}, {platform.machine()}, {numba.config.NUMBA_NUM_THREADS} cores; ", end="")
    print(f"subset {options.subset} px, spacing {SPACING} px, speckle {options.speckle} px")
    print(f"{'case':28s} noise order   k/s 1T   k/s 2T  iter.  RMS mpx bias mpx   right %  wrong %")
    for case in all_cases(quick=options.quick):
        for noise in (0.0, 2.0):
            run_case(case, noise, options)


if __name__ == "__main__":
    main()
