"""Time and memory of `shapemorph measure` over the size of the meshes, as one table.

    python benchmarks/cost_table.py                      10^4, 10^5 and 10^6 faces a side
    python benchmarks/cost_table.py --faces 30000 300000
    python benchmarks/cost_table.py --format glb --keep DIR

The case is the bulge. Its texture grows with the mesh: 1024 px wide for 10^4 faces, 2048 for
10^5, 8192 for 10^6. Each is synthesized into a temporary folder and measured in a process of
its own with default settings, figures included; a small case runs first, so that compiled
kernels are in the cache. Memory is that of all processes of the job together, sampled.
Ends with 1 if a case fails, or if 10^6 faces miss the limits of 45 s and 6 GB.
"""

import argparse
import datetime as dt
import json
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

from accuracy_table import case_config, warm

from shapemorph import __version__
from shapemorph.pipeline.compare import compare
from shapemorph.pipeline.synthesize import write_case

TEXTURES = {10_000: 1024, 100_000: 2048, 1_000_000: 8192}
LARGE, SECONDS_LIMIT, MEMORY_LIMIT = 1_000_000, 45.0, 6000.0
SAMPLING = 0.05  # s
STEPS = {
    "read": ("inputs",),
    "flatten": ("flatten",),
    "match": ("match",),
    "morph, correlate": ("morph", "correlate"),
    "lift to strain": ("lift", "align", "strain"),
    "files": ("write flatten", "write measurement"),
    "figures": ("write figures",),
}


@dataclass(frozen=True)
class Cost:
    """Wall and CPU time (s) and peak memory (MB) of a job, and the message of a failure."""

    seconds: float
    cpu_seconds: float
    memory: float
    message: str


def main() -> int:
    options = _options()
    with tempfile.TemporaryDirectory(prefix="shapemorph-bench-") as temporary:
        folder = options.keep or Path(temporary)
        warm(folder / "warm")
        print(
            f"{dt.date.today().isoformat()}, shapemorph {__version__}, {platform.machine()}, "
            f"{os.cpu_count()} cores; bulge, {options.format.upper()}\n"
        )
        print(
            f"| faces a side | texture | {' | '.join(STEPS)} | all, s | CPU, s | MB | error, µm |"
        )
        print("|" + " --- |" * (len(STEPS) + 6), flush=True)
        passed = [_row(faces, folder / str(faces), options.format) for faces in options.faces]
    return 0 if all(passed) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=int, nargs="+", default=list(TEXTURES), help="of each mesh")
    parser.add_argument("--format", choices=("obj", "glb", "ply"), default="obj", help="of files")
    parser.add_argument("--keep", type=Path, help="folder to keep cases and runs in")
    return parser.parse_args()


def _row(faces: int, folder: Path, file_format: str) -> bool:
    """Measure one size and print its row; return whether it keeps its limits."""
    width = min(TEXTURES.items(), key=lambda pair: abs(pair[0] - faces))[1]
    if not (folder / "truth.npz").exists():  # the last file of a case that was kept
        write_case(case_config("bulge", faces=faces, texture=width, format=file_format), folder)
    cost = _measure(folder, file_format)
    if cost.message:
        print(f"| {faces} | {width}² | {cost.message} |", flush=True)
        return False
    seconds = json.loads((folder / "run" / "summary.json").read_text(encoding="utf-8"))["seconds"]
    error = 1000 * compare(folder / "run", folder / "truth.npz")["error_mm"]["median"]
    print(
        "| " + " | ".join([f"{faces}", f"{width}²", *_cells(seconds, cost, error)]) + " |",
        flush=True,
    )
    return faces < LARGE or (cost.seconds <= SECONDS_LIMIT and cost.memory <= MEMORY_LIMIT)


def _cells(seconds: dict[str, float], cost: Cost, error: float) -> list[str]:
    steps = [sum(seconds.get(name, 0.0) for name in names) for names in STEPS.values()]
    times = [f"{value:.1f}" for value in (*steps, cost.seconds, cost.cpu_seconds)]
    return [*times, f"{cost.memory:.0f}", f"{error:.1f}"]


def _measure(folder: Path, file_format: str) -> Cost:
    """Run `shapemorph measure` on the case in a folder, results beside it."""
    files = [str(folder / f"{side}.{file_format}") for side in ("reference", "deformed")]
    command = [sys.executable, "-m", "shapemorph", "measure", *files, "-o", str(folder / "run")]
    shutil.rmtree(folder / "run", ignore_errors=True)  # nothing may come from a cache
    log = folder / "measure.log"
    started, memory = time.perf_counter(), 0.0
    with log.open("w", encoding="utf-8") as file:
        job = subprocess.Popen(
            [*command, "--quiet"], stdout=file, stderr=file, start_new_session=True
        )
        while True:
            ended, status, usage = os.wait4(job.pid, os.WNOHANG)
            if ended:
                break
            memory = max(memory, _memory_of_session(job.pid))
            time.sleep(SAMPLING)
    seconds = time.perf_counter() - started
    job.returncode = os.waitstatus_to_exitcode(status)
    lines = log.read_text(encoding="utf-8").strip().splitlines() or ["no message"]
    message = f"exit {job.returncode}: {lines[-1]}" if job.returncode else ""
    return Cost(seconds, usage.ru_utime + usage.ru_stime, memory, message)


def _memory_of_session(session: int) -> float:
    """Resident memory of all processes of a session, MB; what they share counts for each."""
    pages = 0
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields: list[Any] = entry.read_text(encoding="utf-8").rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if int(fields[3]) == session:
            pages += int(fields[21])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    sys.exit(main())
