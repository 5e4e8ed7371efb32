"""Print how `shapemorph correlate` follows large deformations between two plain pictures.

    python benchmarks/large_deformation.py                all cases
    python benchmarks/large_deformation.py --quick        a few of them
    python benchmarks/large_deformation.py --only rubber  cases whose name holds a word

Two pictures of exactly known speckle, 1000 x 1000 px, 2 grey levels of noise, are all that the
command gets: no landmarks, no intermediate pictures, no settings but subset 21 px and spacing
8 px. Right is within 0.1 px of the exact field, as a share of the points whose whole warped
subset stays inside the deformed picture; wrong is every other point that is claimed valid, as a
share of all that are. Seconds are those of the whole command.
"""

import argparse
import datetime as dt
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from exact_pictures import Case, judged_points, rubber, take_picture, turn

SUBSET, SPACING, NOISE, RIGHT = 21, 8, 2.0, 0.1
LIMITS = {"radial": 99.9, "radial 200 %": 99.0, "rubber": 99.5}  # per cent right, at least
MOST_WRONG = 0.1  # per cent


def all_cases(*, quick: bool) -> list[Case]:
    """Build radial stretches with turns, and rubber stretched along several directions."""
    stretches = (0.3, 1.5) if quick else (0.3, 0.6, 1.0, 1.5, 2.0)
    turns = (0, 170) if quick else (0, 25, 90, 170)
    radial = [
        Case(f"radial {100 * s:.0f} %, turn {angle} deg", *_both(turn(angle, 1 + s)))
        for s in stretches
        for angle in turns
    ]
    lambdas = (1.6, 3.5) if quick else (1.3, 1.6, 2.0, 2.5, 3.0, 3.5)
    directions = (0, 30) if quick else (0, 17, 30, 45, 80)
    return radial + [rubber(each, angle) for each in lambdas for angle in directions]


def _both(case: Case) -> tuple:
    return case.forward, case.back


def run_case(case: Case, first: Path, folder: Path) -> bool:
    """Print one line; tell if the limits are kept."""
    second, found = folder / "second.png", folder / "found"
    picture = take_picture(case.back, NOISE, 12)
    cv2.imwrite(str(second), np.round(255 * picture.grey).astype(np.uint8))
    command = [
        sys.executable, "-m", "shapemorph", "correlate", str(first), str(second), "-o", str(found),
        "--no-figures", "--quiet", "--set", f"correlate.subset_size={SUBSET}",
        "--set", f"correlate.spacing={SPACING}",
    ]  # fmt: skip
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    if done.returncode:
        print(f"{case.name:32s} {seconds:7.1f}  {done.stderr.strip().splitlines()[-1]}", flush=True)
        return False
    table = np.load(found / "correlation.npz")
    points = np.stack([table["x_px"], table["y_px"]], axis=1).astype(np.float64)
    moved = points + np.stack([table["u_px"], table["v_px"]], axis=1)
    ok = table["status"] == 0
    off = np.abs(moved - case.forward(points)).max(axis=1)
    judged = judged_points(case.forward, points, SUBSET // 2)
    near = ok & (off < RIGHT)
    right = 100 * (near & judged).sum() / judged.sum()
    wrong = 100 * (ok & ~near).sum() / max(ok.sum(), 1)
    rms = 1e3 * np.sqrt(np.mean((moved - case.forward(points))[near] ** 2)) if near.any() else 0.0
    kept = right >= _limit(case.name) and wrong <= MOST_WRONG
    print(
        f"{case.name:32s} {seconds:7.1f} {judged.sum():7d} {right:8.2f} {wrong:8.3f} {rms:8.1f}"
        f"{'' if kept else '  MISSED'}",
        flush=True,
    )
    return kept


def _limit(name: str) -> float:
    """Least share of right points, from the longest key that the name begins with."""
    return LIMITS[max((start for start in LIMITS if name.startswith(start)), key=len)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer cases")
    parser.add_argument("--only", default="", help="cases whose name holds this")
    options = parser.parse_args()
    today = dt.datetime.now(tz=dt.UTC).date().isoformat()
    print(f"{today}, {platform.machine()}; subset {SUBSET} px, spacing {SPACING} px, ", end="")
    print(f"noise of {NOISE:.0f} grey levels")
    print(f"{'case':32s} seconds  points  right %  wrong %  rms mpx")
    missed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        first = folder / "first.png"
        picture = take_picture(lambda p: p, NOISE, 11)
        cv2.imwrite(str(first), np.round(255 * picture.grey).astype(np.uint8))
        for case in all_cases(quick=options.quick):
            if options.only in case.name:
                missed += not run_case(case, first, folder)
    print(f"{missed} missed" if missed else "all limits kept")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
