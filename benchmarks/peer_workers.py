"""Run another program on a pair of pictures; started by peers.py inside that program's environment.

    python peer_workers.py NAME INPUT.npz OUTPUT.npz

INPUT holds `first`, `second` (uint8), `subset`, `spacing`, `order`, `threads`, `reach` (px that
a search covers) and `rounds`. OUTPUT gets `x, y, u, v` of the points claimed valid, and for
each round the seconds of the whole call and of the correlation alone (NaN where not told).
"""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

INSIDE = 24  # px that the grid stays away from the border


def run_pyvale(task: dict, threads: int) -> dict:
    """Call pyvale; it tells the time of the correlation in its log, which is why it runs apart."""
    from pyvale import dic

    first, second = task["first"], task["second"]
    region = np.zeros(first.shape, dtype=bool)
    margin = INSIDE - task["subset"] // 2
    region[margin:-margin, margin:-margin] = True
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        dic.calculate_2d(
            reference=first, deformed=second, roi_mask=region, seed=[first.shape[1] // 2] * 2,
            subset_size=task["subset"], subset_step=task["spacing"], precision=1e-3,
            shape_function="QUAD" if task["order"] == 2 else "AFFINE", num_threads=threads,
            max_displacement=task["reach"], image_filter_kernel=1, output_basepath=folder,
            output_prefix="found_",
        )  # fmt: skip
        seconds = time.perf_counter() - start
        path = next(Path(folder).glob("found_*.csv"))
        rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    rows = rows[rows[:, 5] > 0]
    return {"x": rows[:, 0], "y": rows[:, 1], "u": rows[:, 2], "v": rows[:, 3], "whole": seconds}


def run_al_dic(task: dict, threads: int) -> dict:
    """Call the local step of al-dic; it has no second order."""
    import numba
    from al_dic.core.config import dicpara_default
    from al_dic.core.data_structures import GridxyROIRange
    from al_dic.core.pipeline import run_aldic

    numba.set_num_threads(threads)
    first, second = (task[name] / 255.0 for name in ("first", "second"))
    height, width = first.shape
    region = GridxyROIRange((INSIDE, width - 1 - INSIDE), (INSIDE, height - 1 - INSIDE))
    settings = dicpara_default(
        winsize=task["subset"] - 1, winstepsize=task["spacing"], tol=1e-3, use_global_step=False,
        reference_mode="accumulative", img_size=first.shape, gridxy_roi_range=region,
        size_of_fft_search_region=task["reach"], winsize_min=task["spacing"], disp_smoothness=0.0,
    )  # fmt: skip
    masks = [np.ones(first.shape)] * 2
    start = time.perf_counter()
    found = run_aldic(settings, [first, second], masks, compute_strain=False)
    seconds = time.perf_counter() - start
    moved = np.asarray(found.result_disp[0].U).reshape(-1, 2)
    places = np.asarray(found.dic_mesh.coordinates_fem)
    ok = np.isfinite(moved).all(axis=1)
    return {
        "x": places[ok, 0], "y": places[ok, 1], "u": moved[ok, 0], "v": moved[ok, 1],
        "whole": seconds,
    }  # fmt: skip


def pyvale_correlation_seconds(log: str) -> list[float]:
    """Read from the log of pyvale how long each correlation took: the last time of each call."""
    calls = re.split(r"Starting Correlation", log)[1:]
    times = [re.findall(r"Time:\s+(\d+):(\d+\.\d+)", call)[-1] for call in calls]
    return [60 * float(minutes) + float(seconds) for minutes, seconds in times]


def main() -> None:
    name, source, target = sys.argv[1:4]
    task = {key: value[()] for key, value in np.load(source).items()}
    task |= {key: int(task[key]) for key in ("subset", "spacing", "order", "reach", "rounds")}
    if (
        len(sys.argv) == 4 and name == "pyvale"
    ):  # its log goes past Python, straight to the terminal
        command = [sys.executable, *sys.argv, "inside"]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        found = dict(np.load(target))
        found["correlation"] = np.array(pyvale_correlation_seconds(done.stdout)[1:])
        np.savez(target, **found)
        return
    run = {"pyvale": run_pyvale, "al-dic": run_al_dic}[name]
    results = [run(task, int(task["threads"])) for _ in range(task["rounds"] + 1)]
    whole = np.array([result.pop("whole") for result in results[1:]])  # the first warms up
    np.savez(target, **results[-1], whole=whole, correlation=np.full(len(whole), np.nan))


if __name__ == "__main__":
    main()
