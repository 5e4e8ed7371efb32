"""Accuracy, time and memory of `shapemorph measure` on cases with exact truth, as one table.

    python benchmarks/accuracy_table.py                      rigid bulge indentation hole
    python benchmarks/accuracy_table.py dome freeform tube   others
    python benchmarks/accuracy_table.py --keep DIR --faces 40000

Each case is synthesized into a temporary folder and measured in a process of its own with
default settings; a small case runs first, so that compiled kernels are in the cache. Ends
with 1 if a limit is missed.
"""

import argparse
import datetime as dt
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shapemorph import __version__
from shapemorph.config import SynthesizeConfig
from shapemorph.pipeline.compare import compare
from shapemorph.pipeline.synthesize import write_case

SECONDS_LIMIT, MEMORY_LIMIT = 15.0, 1500.0
LIMITS_SIZE = 70.0  # mm, of the objects that the limits are stated for


@dataclass(frozen=True)
class Limits:
    """What a case must reach: shares, mm on an object of 70 mm, Green-Lagrange strain."""

    coverage: float
    wrong_share: float
    median: float
    p95: float
    strain: float | None = None
    covers: str = "coverage"


LIMITS = {
    "rigid": Limits(0.995, 0.0, 0.006, 0.013, 0.0015),
    "bulge": Limits(0.99, 0.0, 0.008, 0.020, 0.0025),
    "indentation": Limits(0.99, 0.0002, 0.009, 0.025, 0.003),
    "hole": Limits(0.985, 0.0002, 0.008, 0.020, 0.002),
}

HEADER = (
    "| case | covered (≥) | off by > 0.25 mm (≤) | error median / p95, µm (≤) "
    "| \\|ΔE1\\| median (≤) | points OK | s (≤ 15) | s of CPU | MB (≤ 1500) | |"
)


def main() -> int:
    options = _options()
    with tempfile.TemporaryDirectory(prefix="shapemorph-bench-") as temporary:
        folder = options.keep or Path(temporary)
        warm(folder / "warm")
        print(_title(options))
        print(HEADER)
        print("|" + " --- |" * 10, flush=True)
        passed = [_row(case, folder / case, options) for case in options.cases]
    return 0 if all(passed) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=list(LIMITS), help="shapes to measure")
    parser.add_argument("--faces", type=int, default=60_000, help="triangles of each mesh")
    parser.add_argument("--texture", type=int, default=2048, help="width of the textures")
    parser.add_argument("--seed", type=int, default=0, help="of everything random")
    parser.add_argument("--keep", type=Path, help="folder to keep cases and runs in")
    return parser.parse_args()


def _title(options: argparse.Namespace) -> str:
    return (
        f"{dt.date.today().isoformat()}, shapemorph {__version__}, {platform.machine()}, "
        f"{os.cpu_count()} cores; {options.faces} faces, texture {options.texture}², speckle "
        f"0.8 mm on 70 mm, noise 2 grey levels and 6 µm, seed {options.seed}\n"
    )


def case_config(case: str, **options: Any) -> SynthesizeConfig:
    """Settings of a synthetic case."""
    return SynthesizeConfig.model_validate({"shape": case} | options)


def warm(folder: Path) -> None:
    """Run a small case, so that what follows finds its kernels compiled."""
    write_case(case_config("bulge", faces=8000, texture=1024), folder)
    _measure(folder)


def _row(case: str, folder: Path, options: argparse.Namespace) -> bool:
    """Measure one case and print its row; return whether it keeps its limits."""
    size = {"faces": options.faces, "texture": options.texture, "seed": options.seed}
    found, cost = measure_case(case_config(case, **size), folder)
    if found is None:
        print(f"| {case} | {cost.message} |" + " |" * 8, flush=True)
        return False
    limits = LIMITS.get(case)
    missed = _missed_costs(cost) + (missed_limits(found, limits) if limits else [])
    verdict = "missed: " + ", ".join(missed) if missed else "ok"
    costs = [f"{cost.seconds:.1f}", f"{cost.cpu_seconds:.1f}", f"{cost.memory:.0f}"]
    cells = [case, *error_cells(found, limits), *costs, verdict]
    print("| " + " | ".join(cells) + " |", flush=True)
    return not missed


def measure_case(config: SynthesizeConfig, folder: Path) -> tuple[dict[str, Any] | None, "Cost"]:
    """Synthesize a case, measure it and compare; None where it could not be measured."""
    write_case(config, folder)
    cost = _measure(folder)
    if cost.message:
        return None, cost
    return compare(folder / "run", folder / "truth.npz"), cost


@dataclass(frozen=True)
class Cost:
    """Wall time, time of all cores (s), peak memory (MB), and the message of a failure."""

    seconds: float
    cpu_seconds: float
    memory: float
    message: str


def _measure(folder: Path) -> Cost:
    """Run `shapemorph measure` on the case in a folder, results beside it."""
    files = [str(folder / "reference.obj"), str(folder / "deformed.obj")]
    command = [sys.executable, "-m", "shapemorph", "measure", *files, "-o", str(folder / "run")]
    log = folder / "measure.log"
    shutil.rmtree(folder / "run", ignore_errors=True)  # nothing may come from a cache
    started = time.perf_counter()
    with log.open("w", encoding="utf-8") as file:
        process = subprocess.Popen([*command, "--quiet"], stdout=file, stderr=file)
        _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    per_kilobyte = 1024 if platform.system() == "Darwin" else 1  # macOS counts bytes
    lines = log.read_text(encoding="utf-8").strip().splitlines() or ["no message"]
    return Cost(
        seconds=seconds,
        cpu_seconds=usage.ru_utime + usage.ru_stime,
        memory=usage.ru_maxrss / per_kilobyte / 1024,
        message=f"exit {process.returncode}: {lines[-1]}" if process.returncode else "",
    )


def _missed_costs(cost: Cost) -> list[str]:
    tests = {"time": cost.seconds <= SECONDS_LIMIT, "memory": cost.memory <= MEMORY_LIMIT}
    return [name for name, kept in tests.items() if not kept]


def missed_limits(found: dict[str, Any], limits: Limits) -> list[str]:
    """Names of the limits that a case does not keep; lengths scale with the object."""
    scale = found["size_mm"] / LIMITS_SIZE
    tests = {
        "coverage": found[limits.covers] >= limits.coverage,
        "wrong points": found["wrong_share"] <= limits.wrong_share,
        "median": found["error_mm"]["median"] <= limits.median * scale,
        "p95": found["error_mm"]["p95"] <= limits.p95 * scale,
        "strain": limits.strain is None or found["dE1"]["median"] <= limits.strain,
    }
    return [name for name, kept in tests.items() if not kept]


def error_cells(found: dict[str, Any], limits: Limits | None) -> list[str]:
    """Cells with coverage, wrong points, errors, strain and points, limits beside them."""
    scale = found["size_mm"] / LIMITS_SIZE
    median, p95 = (1000 * found["error_mm"][name] for name in ("median", "p95"))
    wrong = f"{found['wrong_points']} = {100 * found['wrong_share']:.3f} %"
    covered = found[limits.covers if limits else "coverage"]
    strain = limits.strain if limits else None
    return [
        f"{100 * covered:.2f} %" + _beside(limits and f"{100 * limits.coverage:g}"),
        wrong + _beside(limits and f"{100 * limits.wrong_share:g}"),
        f"{median:.3g} / {p95:.3g}"
        + _beside(
            limits and f"{1000 * limits.median * scale:.3g} / {1000 * limits.p95 * scale:.3g}"
        ),
        f"{found['dE1']['median']:.5f}" + _beside(strain and f"{strain:g}"),
        f"{found['ok_points']} of {found['points']}",
    ]


def _beside(limit: str | None) -> str:
    """The limit in brackets, where there is one."""
    return f" ({limit})" if limit else ""


if __name__ == "__main__":
    sys.exit(main())
