"""Compare the correlation kernel with other programs on pictures that are known exactly.

    python benchmarks/peers.py                    make environments, run everything interleaved
    python benchmarks/peers.py --quick            one motion, two rounds
    python benchmarks/peers.py --cache FOLDER     where the environments are kept

Every peer lives in an environment of its own, made with venv and pip at the first run. In each
round all programs run one after the other on the same pictures; the medians over the rounds
are printed. Timed are: here Hessians and all iterations, from the exact displacement rounded to
a pixel; of pyvale what its own log says of the correlation; of al-dic the whole call, warmed
up. Only points claimed valid count. Errors are those of both components together.
"""

import argparse
import datetime as dt
import platform
import subprocess
import sys
import tempfile
import venv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from exact_pictures import (
    SIZE,
    SPACING,
    Case,
    judged_points,
    linear,
    sine,
    star,
    take_picture,
    translation,
)
from kernel import starts_for
from platformdirs import user_cache_dir

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import SubsetSettings, match_points
from shapemorph.methods.threads import kernel_threads

PEERS = {"pyvale": "pyvale", "al-dic": "al-dic"}  # name: what pip installs
SECOND_ORDER = ("pyvale",)
SUBSET = 21
REACH = 16  # px that a peer searches
OURS = "shapemorph"
WORKER = Path(__file__).resolve().with_name("peer_workers.py")


@dataclass
class Results:
    """What one program found in all rounds of one task."""

    positions: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    moved: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    whole: list[float] = field(default_factory=list)
    correlation: list[float] = field(default_factory=list)

    def speed(self) -> float:
        """Thousands of points a second, of the correlation alone where that is known."""
        alone = np.array(self.correlation)
        seconds = np.where(np.isfinite(alone), alone, self.whole)
        return len(self.moved) / float(np.median(seconds)) / 1e3


def environment(name: str, cache: Path) -> Path:
    """Python of the environment of a peer, which is made where it does not exist yet."""
    folder = cache / name
    python = folder / "bin" / "python"
    if not (folder / "ready").exists():
        print(f"installing {name} in {folder}", file=sys.stderr)
        venv.create(folder, with_pip=True, clear=True)
        command = [str(python), "-m", "pip", "install", "--quiet", PEERS[name]]
        subprocess.run(command, check=True)
        (folder / "ready").touch()
    return python


def run_peer(name: str, python: Path, source: Path, results: Results) -> None:
    """One round of a peer."""
    target = source.with_suffix(".found.npz")
    command = [str(python), str(WORKER), name, str(source), str(target)]
    subprocess.run(command, check=True, capture_output=True, cwd=source.parent)
    found = np.load(target)
    results.positions = np.column_stack([found["x"], found["y"]])
    results.moved = results.positions + np.column_stack([found["u"], found["v"]])
    results.whole += found["whole"].tolist()
    results.correlation += found["correlation"].tolist()


def run_ours(
    case: Case, pictures: list[GreyImage], order: int, threads: int, results: Results
) -> None:
    """One round of the kernel of this project."""
    radius = SUBSET // 2
    settings = SubsetSettings(radius, order, 1e-3, 30, 0.5, float(radius))
    axis = np.arange(3 * SPACING, SIZE - 3 * SPACING, SPACING)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    reference = prepare_reference(pictures[0], allowed=None, pad=settings.pad)
    deformed = prepare_deformed(pictures[1], pad=settings.pad)
    starts = starts_for(case, points)
    with kernel_threads(threads):
        found = match_points(reference, deformed, points, starts, settings=settings)
    ok = found.status == PointStatus.OK
    results.positions, results.moved = points[ok].astype(np.float64), found.position[ok]
    results.whole.append(found.seconds)
    results.correlation.append(found.seconds)


def run_case(
    case: Case, noise: float, order: int, threads: int, pythons: dict[str, Path], rounds: int
) -> None:
    """Run all programs on one task, interleaved, and print a line for each."""
    pictures = [take_picture(lambda p: p, noise, 11), take_picture(case.back, noise, 12)]
    levels = [np.round(255 * picture.grey).astype(np.uint8) for picture in pictures]
    names = [name for name in pythons if order == 1 or name in SECOND_ORDER]
    results = {name: Results() for name in (OURS, *names)}
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "task.npz"
        np.savez(
            source, first=levels[0], second=levels[1], subset=SUBSET, spacing=SPACING,
            order=order, threads=threads, reach=REACH, rounds=1,
        )  # fmt: skip
        for _ in range(rounds):
            for name in names:
                run_peer(name, pythons[name], source, results[name])
            run_ours(case, pictures, order, threads, results[OURS])
    for name, found in results.items():
        ratio = results[OURS].speed() / found.speed()
        print(f"{case.name:24s} {noise:5.0f} {order:5d} {threads:7d} {name:11s}", end="")
        print(f"{found.speed():8.1f} {ratio:7.1f} {errors(case, found)}", flush=True)


def errors(case: Case, found: Results) -> str:
    """RMS and bias in milli-px, shares of right points and of claimed but wrong ones."""
    inside = judged_points(case.forward, found.positions, SUBSET // 2)
    error = found.moved[inside] - case.forward(found.positions[inside])
    near = np.abs(error).max(axis=1) < 0.1
    axis = np.arange(3 * SPACING, SIZE - 3 * SPACING, SPACING)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    wanted = judged_points(case.forward, grid, SUBSET // 2).sum()
    rms = 1e3 * np.sqrt((error[near] ** 2).mean()) if near.any() else np.nan
    bias = 1e3 * np.abs(error[near].mean(axis=0)).max() if near.any() else np.nan
    right = min(1.0, near.sum() / wanted)
    return f"{rms:8.2f} {bias:8.2f} {100 * right:8.2f} {100 * (~near).sum() / wanted:8.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one motion, two rounds")
    parser.add_argument("--rounds", type=int, default=5, help="rounds, of which the median counts")
    cache = Path(user_cache_dir("shapemorph")) / "peers"
    parser.add_argument("--cache", type=Path, default=cache, help="folder of the environments")
    options = parser.parse_args()
    pythons = {name: environment(name, options.cache) for name in PEERS}
    print(f"{dt.datetime.now(tz=dt.UTC).date().isoformat()}, {platform.processor()}", end="; ")
    print(f"subset {SUBSET} px, spacing {SPACING} px; medians of {options.rounds} rounds")
    print(f"{'motion':24s} noise order threads {'program':11s}", end="")
    print("     k/s   ratio  RMS mpx bias mpx  right %  wrong %")
    shift = translation(0.3)
    if options.quick:
        run_case(shift, 0.0, 1, 1, pythons, 2)
        return
    for threads in (1, 2):
        run_case(shift, 0.0, 1, threads, pythons, options.rounds)
    accuracy = [translation(0.1), translation(0.5), translation(0.7)]
    affine = linear("affine 2 %", [[1.02, 0.01], [-0.01, 0.985]])
    run_case(affine, 0.0, 1, 1, pythons, options.rounds)
    run_case(sine(), 0.0, 1, 1, pythons, options.rounds)
    for case in (shift, sine(), star()):
        run_case(case, 0.0, 2, 1, pythons, options.rounds)
    for case in (shift, *accuracy):
        run_case(case, 2.0, 1, 2, pythons, 1)
    for case in accuracy:
        run_case(case, 0.0, 1, 2, pythons, 1)


if __name__ == "__main__":
    main()
