"""What a measurement owes to its flattening: each pair with every flattening that fits, one table.

    python benchmarks/flattenings.py                     bulge dome indentation
    python benchmarks/flattenings.py dome --faces 40000 --methods auto,profile --keep DIR

Each case is synthesized once and measured with every method in a process of its own. The
errors against the exact truth are interpolated to common material points; the spread is the
standard deviation over the methods there, root mean square of all points and components. A
last row lists what did not fit. Ends with 1 if the spread exceeds 5 µm.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import SynthesizeConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.status import PointStatus
from shapemorph.core.synthetic import Truth
from shapemorph.io.measurement_files import read_vtp
from shapemorph.io.truth_files import read_truth
from shapemorph.methods.synthetic.truth import random_material, truth_at
from shapemorph.pipeline.synthesize import write_case

SPREAD_LIMIT = 0.005  # mm
SAMPLES, RIM = 4000, 2.5  # common material points, and how far inside the rim, mm
LAYS = {
    "auto": (),
    "bff": ("flatten.method=bff",),
    "lscm": ("flatten.method=lscm",),
    "harmonic": ("flatten.method=harmonic",),
    "arap": ("flatten.method=arap",),
    "slim": ("flatten.method=slim",),
    "profile": ("flatten.method=profile",),
    "orthographic": ("flatten.method=orthographic",),
    "equidistant": ("flatten.method=spherical",),
    "equal_area": ("flatten.method=spherical", "flatten.projection=equal_area"),
    "stereographic": ("flatten.method=spherical", "flatten.projection=stereographic"),
}
UNFIT = {
    "bulge": ("orthographic", "equidistant", "equal_area", "stereographic"),
    "dome": ("orthographic",),
    "indentation": ("equidistant", "equal_area", "stereographic"),
}
"""Walls that these would show edge on, from far away or from the middle of a ball."""


def main() -> int:
    options = _options()
    with tempfile.TemporaryDirectory(prefix="shapemorph-bench-") as temporary:
        folder = options.keep or Path(temporary)
        spreads = [_table(case, folder / case, options) for case in options.cases]
    return 0 if max(spreads) <= SPREAD_LIMIT else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=["bulge", "dome", "indentation"])
    parser.add_argument("--methods", default=",".join(LAYS), help="of the flattening")
    parser.add_argument("--faces", type=int, default=20_000, help="triangles of each mesh")
    parser.add_argument("--texture", type=int, default=2048, help="width of the textures")
    parser.add_argument("--keep", type=Path, help="folder to keep cases and runs in")
    return parser.parse_args()


def _table(case: str, folder: Path, options: argparse.Namespace) -> float:
    """Measure one case with all methods, print its table and return the spread, mm."""
    sizes = {"faces": options.faces, "texture": options.texture}
    write_case(SynthesizeConfig.model_validate({"shape": case} | sizes), folder)
    truth = read_truth(folder / "truth.npz")
    fitting = [m for m in options.methods.split(",") if m not in UNFIT.get(case, ())]
    print(f"\n{case}, {options.faces} faces, texture {options.texture}²\n")
    print("| flattening | points OK | error median / p95, µm | from the mean, µm rms | s |")
    print("|" + " --- |" * 5, flush=True)
    found, notes, refused = {}, {}, []
    for method in fitting:
        began = time.perf_counter()
        message = measure(folder, folder / method, LAYS[method])
        if message:
            refused.append(f"{method}: {message}")
            continue
        found[method], notes[method] = errors_at(folder / method, truth)
        notes[method]["seconds"] = time.perf_counter() - began
    spread, apart = spread_of(list(found.values()))
    for method, off in zip(found, apart, strict=True):
        print(_row(method, notes[method], off))
    print(f"\nspread {1000 * spread:.2f} µm rms per component", *refused, sep="\n", flush=True)
    return spread


def _row(method: str, note: dict[str, Any], off: float) -> str:
    return (
        f"| {method} | {note['ok']} of {note['points']} | {1000 * note['median']:.1f} / "
        f"{1000 * note['p95']:.1f} | {1000 * off:.2f} | {note['seconds']:.0f} |"
    )


def measure(case: Path, run: Path, settings: Sequence[str]) -> str:
    """Run `shapemorph measure` on a case; return the message of a failure."""
    command = [sys.executable, "-m", "shapemorph", "measure", str(case / "reference.obj")]
    command += [str(case / "deformed.obj"), "-o", str(run), "--quiet"]
    for setting in (*settings, "report.figures=false"):
        command += ["--set", setting]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = done.stderr.strip().splitlines() or ["no message"]
    return f"exit {done.returncode}: {lines[-1]}" if done.returncode else ""


def errors_at(run: Path, truth: Truth) -> tuple[Floats, dict[str, Any]]:
    """Errors (N, 3) of deformed positions at common material points, and of all points."""
    from scipy.interpolate import LinearNDInterpolator

    measurement, _ = read_vtp(run / "measurement.vtp")
    good = measurement.arrays["status"] == PointStatus.OK
    reference = measurement.reference[good]
    exact = truth_at(truth, reference)
    errors = measurement.arrays["deformed_position"][good] - exact.deformed
    wanted = random_material(truth, SAMPLES, inset=RIM * truth.size / 70.0, seed=0)
    length = np.linalg.norm(errors, axis=1)
    note = {
        "points": len(good),
        "ok": int(good.sum()),
        "median": float(np.median(length)),
        "p95": float(np.percentile(length, 95)),
    }
    at_common: Floats = LinearNDInterpolator(exact.material, errors)(wanted)
    return at_common, note


def spread_of(errors: Sequence[Floats]) -> tuple[float, list[float]]:
    """Standard deviation over the methods (rms over points and components), and each one's part.

    Parameters
    ----------
    errors : sequence of (N, 3)
        NaN where a method has no value; such points do not count.
    """
    stack = np.stack(errors)
    stack = stack[:, np.isfinite(stack).all(axis=(0, 2))]
    apart = stack - stack.mean(axis=0)
    freedom = len(stack) / max(1, len(stack) - 1)
    spread = float(np.sqrt(freedom * (apart**2).mean()))
    return spread, [float(np.sqrt((each**2).mean())) for each in apart]


if __name__ == "__main__":
    sys.exit(main())
