"""Shapes that are hard to flatten or to match, against exact truth, as one table with limits.

    python benchmarks/hard_shapes.py                          everything; half an hour
    python benchmarks/hard_shapes.py tube balloon --seed 1    some rows
    python benchmarks/hard_shapes.py dome --size 3000 --speckle 1.2

Rows: freeform, freeform-17, -45, -80 (the stretch turned against the reference), dome, tube,
balloon, damaged (a bulge with glare, a print and a lost patch; covered is the share of what
is visible), head (the real pair of real_pair.py, whose folder SHAPEMORPH_DATA names),
flattenings and laws (results by every flattening and morph law that fits; spread in um rms).
Lengths (speckle, noise, limits) are those of an object of 70 mm and scale with --size. Ends
with 1 if a limit is missed.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from accuracy_table import (
    LIMITS_SIZE,
    Limits,
    case_config,
    error_cells,
    measure_case,
    missed_limits,
    warm,
)
from real_pair import measure_pair

FREEFORM = Limits(0.99, 0.0005, 0.009, 0.022)
LIMITS = {
    "freeform": FREEFORM,
    "freeform-17": FREEFORM,
    "freeform-45": FREEFORM,
    "freeform-80": FREEFORM,
    "dome": Limits(0.98, 0.0005, 0.008, 0.022),
    "tube": Limits(0.985, 0.0005, 0.009, 0.022),
    "balloon": Limits(0.97, 0.002, 0.012, 0.030),
    "damaged": Limits(0.97, 0.0005, 0.008, 0.022, covers="visible_coverage"),
}
OTHERS = ("head", "flattenings", "laws")
DAMAGE = {"glare": True, "lost_patch": True, "print_at_pole": True}
HEADER = (
    "| case | covered (≥) | off by > 0.25 mm (≤) | error median / p95, µm (≤) "
    "| \\|ΔE1\\| median | points OK | s | s of CPU | MB | |"
)


def main() -> int:
    options = _options()
    unknown = set(options.cases) - {*LIMITS, *OTHERS}
    if unknown:
        print(f"expected rows among {', '.join([*LIMITS, *OTHERS])}, got {', '.join(unknown)}")
        return 2
    with tempfile.TemporaryDirectory(prefix="shapemorph-bench-") as temporary:
        folder = options.keep or Path(temporary)
        shapes = [case for case in options.cases if case in LIMITS]
        passed = _shapes(shapes, folder, options) if shapes else []
    if "head" in options.cases:
        default = Path(os.environ.get("SHAPEMORPH_DATA", "../shared/data"))
        print("\nhead\n", flush=True)
        passed.append(not measure_pair(default / "ict_face_textured_pair"))
    for script in ("flattenings", "laws"):
        if script in options.cases:
            print(f"\n{script}\n", flush=True)
            passed.append(_run(script))
    return 0 if all(passed) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=[*LIMITS, *OTHERS], help="rows")
    parser.add_argument("--faces", type=int, default=60_000, help="triangles of each mesh")
    parser.add_argument("--texture", type=int, default=2048, help="width of the textures")
    parser.add_argument("--speckle", type=float, default=0.8, help="mm on an object of 70 mm")
    parser.add_argument("--size", type=float, default=LIMITS_SIZE, help="of the object, mm")
    parser.add_argument("--seed", type=int, default=0, help="of everything random")
    parser.add_argument("--keep", type=Path, help="folder to keep cases and runs in")
    return parser.parse_args()


def _shapes(cases: list[str], folder: Path, options: argparse.Namespace) -> list[bool]:
    """Print the table of the synthetic shapes; whether each keeps its limits."""
    warm(folder / "warm")
    print(
        f"{options.faces} faces, texture {options.texture}², size {options.size:g} mm; for an "
        f"object of {LIMITS_SIZE:g} mm: speckle {options.speckle:g} mm, noise 2 grey levels and "
        f"6 µm; seed {options.seed}\n"
    )
    print(HEADER)
    print("|" + " --- |" * 10, flush=True)
    return [_row(case, folder / case, options) for case in cases]


def _row(case: str, folder: Path, options: argparse.Namespace) -> bool:
    """Measure one shape and print its row; return whether it keeps its limits."""
    found, cost = measure_case(case_config(**_settings(case, options)), folder)
    if found is None:
        print(f"| {case} | {cost.message} |" + " |" * 8, flush=True)
        return False
    limits = LIMITS[case]
    missed = missed_limits(found, limits)
    costs = [f"{cost.seconds:.0f}", f"{cost.cpu_seconds:.0f}", f"{cost.memory:.0f}"]
    verdict = "missed: " + ", ".join(missed) if missed else "ok"
    cells = [case, *error_cells(found, limits), *costs, verdict]
    print("| " + " | ".join(cells) + " |", flush=True)
    return not missed


def _settings(case: str, options: argparse.Namespace) -> dict[str, Any]:
    """Settings of a row: its shape, and lengths that scale with the object."""
    scale = options.size / LIMITS_SIZE
    shape, _, turn = case.partition("-")
    settings = {
        "case": "bulge" if case == "damaged" else shape,
        "size": options.size,
        "speckle": options.speckle * scale,
        "vertex_noise": 0.006 * scale,
        "faces": options.faces,
        "texture": options.texture,
        "seed": options.seed,
    }
    if case == "damaged":
        settings["damage"] = DAMAGE
    if turn:
        settings["direction"] = float(turn)
    return settings


def _run(script: str) -> bool:
    """Run another benchmark; whether it keeps its limit."""
    path = Path(__file__).with_name(f"{script}.py")
    return subprocess.run([sys.executable, str(path)], check=False).returncode == 0


if __name__ == "__main__":
    sys.exit(main())
