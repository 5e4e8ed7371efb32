"""Accuracy of `shapemorph measure` on flat sheets drawn evenly, as one table.

    python benchmarks/sheets.py                                   stretch 1.3 to 3.5, and 5
    python benchmarks/sheets.py --stretch 3.5 --direction 0 45 --turn 60 --speckle 0.5
    python benchmarks/sheets.py --sample 24 --seed 1 2

The ratio of the principal stretches is stretch^1.5. Directions, turns and seeds are paired in
turn, not crossed, unless --cross is given; --sample draws cases in which every level of each
comes up about as often as any other. Limits: covered 99 % (95 % from stretch 5 on),
0.05 % off by more than 0.25 mm, median and 95 % of the error 9 and 22 um x max(1, stretch / 2).
Ends with 1 if a limit is missed.
"""

import argparse
import itertools
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shapemorph.config import SynthesizeConfig
from shapemorph.pipeline.compare import compare
from shapemorph.pipeline.synthesize import write_case

STRETCHES = [1.3, 1.6, 2.0, 2.5, 3.0, 3.5, 5.0]
DIRECTIONS, TURNS, SPECKLES = [0.0, 10.0, 20.0, 45.0], [0.0, 60.0, 170.0], [0.8]


class Case(NamedTuple):
    """A sheet: how it is drawn, turned and painted."""

    stretch: float
    direction: float
    turn: float
    speckle: float
    seed: int


def main() -> int:
    options = _options()
    print("| stretch | direction | turn | speckle, mm | seed | covered | off by > 0.25 mm "
          "| error median / p95, um | s | s CPU | verdict | |")  # fmt: skip
    print("|" + " --- |" * 12, flush=True)
    with tempfile.TemporaryDirectory(prefix="shapemorph-sheets-") as temporary:
        folder = options.keep or Path(temporary)
        passed = [
            _row(folder / f"case{number}", case, options)
            for number, case in enumerate(_cases(options))
        ]
    return 0 if all(passed) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stretch", type=float, nargs="*", default=STRETCHES)
    parser.add_argument("--direction", type=float, nargs="*", default=DIRECTIONS)
    parser.add_argument("--turn", type=float, nargs="*", default=TURNS)
    parser.add_argument("--speckle", type=float, nargs="*", default=SPECKLES)
    parser.add_argument("--cross", action="store_true", help="all directions with all turns")
    parser.add_argument("--faces", type=int, default=60_000, help="triangles of each mesh")
    parser.add_argument("--texture", type=int, default=2048, help="width of the textures")
    parser.add_argument("--seed", type=int, nargs="*", default=[0], help="of everything random")
    parser.add_argument("--sample", type=int, help="number of cases drawn from all combinations")
    parser.add_argument("--keep", type=Path, help="folder to keep cases and runs in")
    return parser.parse_args()


def _cases(options: argparse.Namespace) -> Iterator[Case]:
    """Every case that is asked for."""
    levels = (options.stretch, options.direction, options.turn, options.speckle, options.seed)
    if options.sample is not None:
        yield from sorted(_sample(levels, options.sample))
    elif options.cross:
        yield from (Case(*each) for each in itertools.product(*levels))
    else:
        paired = [itertools.cycle(each) for each in (options.direction, options.turn, options.seed)]
        for stretch, speckle in itertools.product(options.stretch, options.speckle):
            direction, turn, seed = (next(each) for each in paired)
            yield Case(stretch, direction, turn, speckle, seed)


def _sample(levels: tuple[list[float], ...], number: int) -> set[Case]:
    """Different cases, at random but always the same."""
    number = min(number, math.prod(len(each) for each in levels) // 4)
    random, cases = np.random.default_rng(0), set()
    while len(cases) < number:
        drawn = [_evenly(random, each, number) for each in levels]
        cases = {Case(*each) for each in zip(*drawn, strict=True)}
    return cases


def _evenly(random: np.random.Generator, levels: list[float], number: int) -> list[float]:
    """`number` levels in random order, each as often as any other, or once more."""
    order = np.concatenate([random.permutation(len(levels)) for _ in range(number)])[:number]
    return [levels[k] for k in random.permutation(order)]


def _row(folder: Path, case: Case, options: argparse.Namespace) -> bool:
    config = SynthesizeConfig(
        shape="sheet", faces=options.faces, texture=options.texture, **case._asdict()
    )
    write_case(config, folder)
    message, seconds, spent = _measure(folder)
    start = "| " + " | ".join(f"{value:g}" for value in case) + " |"
    if message:
        print(f"{start} {message} |" + " |" * 6, flush=True)
        return False
    verdict = json.loads((folder / "run" / "summary.json").read_text("utf-8"))["verdict"]
    found = compare(folder / "run", folder / "truth.npz")
    wide = max(1.0, case.stretch / 2)
    good = (
        found["coverage"] >= (0.99 if case.stretch < 5 else 0.95)
        and found["wrong_share"] <= 0.0005
        and found["error_mm"]["median"] <= 0.009 * wide
        and found["error_mm"]["p95"] <= 0.022 * wide
    )
    print(
        f"{start} {found['coverage']:.2%} | {found['wrong_share']:.3%} "
        f"| {1000 * found['error_mm']['median']:.1f} / {1000 * found['error_mm']['p95']:.1f} "
        f"| {seconds:.1f} | {spent:.1f} | {verdict['level']} | {'ok' if good else 'missed'} |",
        flush=True,
    )
    if not options.keep:
        shutil.rmtree(folder)
    return bool(good)


def _measure(folder: Path) -> tuple[str, float, float]:
    """Message of a failure, wall time and time of all cores, s."""
    files = [str(folder / "reference.obj"), str(folder / "deformed.obj")]
    command = [sys.executable, "-m", "shapemorph", "measure", *files, "-o", str(folder / "run")]
    started, log = time.perf_counter(), folder / "measure.log"
    with log.open("w", encoding="utf-8") as file:
        process = subprocess.Popen([*command, "--quiet"], stdout=file, stderr=file)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    lines = log.read_text(encoding="utf-8").strip().splitlines() or ["no message"]
    message = f"exit {process.returncode}: {lines[-1]}" if process.returncode else ""
    return message, time.perf_counter() - started, usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    sys.exit(main())
