"""Print how far the star pattern is resolved, and what its bias columns say.

    python benchmarks/star.py

Half a pixel of motion along y in waves of 10 px on the left to 150 px on the right, 1000 x 1000
px, through the command `shapemorph correlate`; MEI (see `shapemorph assess`) is the random error
in a pair without motion, 2 grey levels of noise, times the period of which a tenth is lost.
Right is within 0.1 px of the exact field, as a share of the points whose whole subset stays
inside; told are those of the others whose bias columns reach 0.05 px. Random errors carry
points off, too, which is not for these columns to tell: told+ are those of the others that are
off by more than 0.05 px in pictures without noise.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
from exact_pictures import SIZE, judged_points, star, take_picture

from shapemorph.methods.star_pattern import Star, spatial_resolution

RIGHT, TOLD = 0.1, 0.05
STAR = Star(0.5, 10.0, 10.0 + 140.0 * (SIZE - 1) / SIZE, SIZE, SIZE / 2)
WAYS = ((1, 21, 8), (2, 21, 8), (1, None, None), (2, None, None))


def correlated(folder: Path, pair: tuple[str, str], way: tuple) -> dict[str, np.ndarray]:
    """Table that the command writes of two pictures."""
    order, size, spacing = way
    command = [
        sys.executable, "-m", "shapemorph", "correlate", *(f"{each}.png" for each in pair),
        "-o", "found", "--no-figures", "--quiet", "--set", f"correlate.order={order}",
    ]  # fmt: skip
    if size is not None:
        command += ["--set", f"correlate.subset_size={size}"]
        command += ["--set", f"correlate.spacing={spacing}"]
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    return dict(np.load(folder / "found" / "correlation.npz"))


def resolution(places: np.ndarray, moved: np.ndarray) -> float:
    """Period of which a tenth is lost, px, along the row of points nearest to the full wave."""
    rows = np.unique(places[:, 1])
    row = float(rows[np.abs(rows - STAR.row).argmin()])
    on = places[:, 1] == row
    return spatial_resolution(STAR, places[on, 0].astype(float), row, moved[on])


def run_way(folder: Path, noise: int, way: tuple) -> None:
    """Print one line."""
    order, *_ = way
    table = correlated(folder, (f"first{noise}", f"second{noise}"), way)
    size, spacing = int(table["subset_size"]), int(table["spacing"])
    judged, off = errors_of(table)
    clean = correlated(folder, ("first0", "second0"), (order, size, spacing)) if noise else table
    _, bent = errors_of(clean)
    right, others = judged & (off < RIGHT), judged & (off >= RIGHT)
    bias = np.abs(np.stack([table["bias_u_px"], table["bias_v_px"]])).max(axis=0)
    places = np.stack([table["x_px"], table["y_px"]], axis=1)
    period = resolution(places, table["v_px"])
    still = correlated(folder, ("first2", "still2"), (order, size, spacing))
    random = float(np.nanstd(still["v_px"]))
    print(
        f"{noise:5d} {order:5d} {size:6d} {100 * right.sum() / judged.sum():8.2f}"
        f"{100 * (bias[others] > TOLD).mean():8.2f}"
        f"{100 * (bias[others & (bent > TOLD)] > TOLD).mean():8.2f}"
        f"{100 * (bias[right] > TOLD).mean():8.2f}"
        f"{period:8.1f} {1e3 * random:8.1f} {1e3 * period * random:8.0f}",
        flush=True,
    )


def errors_of(table: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Points that are judged, and the larger error of each, px; NaN where it was lost."""
    case = star()
    points = np.stack([table["x_px"], table["y_px"]], axis=1).astype(np.float64)
    moved = points + np.stack([table["u_px"], table["v_px"]], axis=1)
    judged = judged_points(case.forward, points, int(table["subset_size"]) // 2)
    return judged, np.abs(moved - case.forward(points)).max(axis=1)


def main() -> None:
    case = star()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seen = {"first": lambda p: p, "second": case.back}
        jobs = [(f"{key}{n}", back, n) for n in (0, 2) for key, back in seen.items()]
        for seed, (key, back, noise) in enumerate([*jobs, ("still2", lambda p: p, 2)]):
            levels = np.round(255 * take_picture(back, noise, 20 + seed).grey).astype(np.uint8)
            cv2.imwrite(str(folder / f"{key}.png"), levels)
        print("noise order subset  right %  told %  told+ % falsely %  l10 px  sd mpx  MEI mpx px")
        for noise in (0, 2):
            for way in WAYS:
                run_way(folder, noise, way)


if __name__ == "__main__":
    main()
