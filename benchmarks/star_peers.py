"""Compare the metrological efficiency indicator of the star pattern with that of pyvale.

    python benchmarks/star_peers.py                    all subsets, both orders
    python benchmarks/star_peers.py --cache FOLDER     where the environment of pyvale is kept

The same pictures and the same subsets for both. The spatial resolution l10 is the period of
which a tenth of the amplitude is lost, along the row of full amplitude, from pictures without
noise (12th-order polynomial); sigma is the standard deviation of v in a pair without motion and
with 2 grey levels of noise. MEI is their product; the score of a program is the mean of its
three lowest. Ours is the whole command `shapemorph correlate`, second matches included.

P. L. Reu et al., "DIC Challenge 2.0", Exp. Mech. 62 (2022), doi:10.1007/s11340-021-00806-6.
"""

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from exact_pictures import SPACING, star, take_picture
from peers import OURS, REACH, Results, environment, run_peer
from platformdirs import user_cache_dir
from star import correlated, resolution

NOISE = 2.0
SUBSETS = (15, 21, 27)
PEER = "pyvale"
Field = tuple[np.ndarray, np.ndarray]  # positions (N, 2) and displacements v (N,)
Follow = Callable[[tuple[str, str], int, int], Field]


def ours(folder: Path) -> Follow:
    """Follow points by the command."""

    def follow(pair: tuple[str, str], order: int, subset: int) -> Field:
        table = correlated(folder, pair, (order, subset, SPACING))
        ok = table["status"] == 0
        places = np.stack([table["x_px"], table["y_px"]], axis=1).astype(np.float64)
        return places[ok], table["v_px"][ok]

    return follow


def theirs(folder: Path, python: Path) -> Follow:
    """Follow points by the peer, in an environment of its own."""

    def follow(pair: tuple[str, str], order: int, subset: int) -> Field:
        first, second = (
            cv2.imread(str(folder / f"{name}.png"), cv2.IMREAD_GRAYSCALE) for name in pair
        )
        task, found = folder / "task.npz", Results()
        np.savez(
            task, first=first, second=second, subset=subset, spacing=SPACING, order=order,
            threads=2, reach=REACH, rounds=1,
        )  # fmt: skip
        run_peer(PEER, python, task, found)
        return found.positions, (found.moved - found.positions)[:, 1]

    return follow


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    cache = Path(user_cache_dir("shapemorph")) / "peers"
    parser.add_argument("--cache", type=Path, default=cache, help="folder of the environment")
    python = environment(PEER, parser.parse_args().cache)
    scores: dict[tuple[str, int], list[float]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seen = {
            "first": (lambda p: p, 0.0), "waves": (star().back, 0.0),
            "still": (lambda p: p, NOISE), "again": (lambda p: p, NOISE),
        }  # fmt: skip
        for seed, (key, (back, noise)) in enumerate(seen.items()):
            levels = np.round(255 * take_picture(back, noise, 30 + seed).grey).astype(np.uint8)
            cv2.imwrite(str(folder / f"{key}.png"), levels)
        print("program      order subset   l10 px  sd mpx  MEI mpx px")
        programs = {OURS: ours(folder), PEER: theirs(folder, python)}
        for order in (1, 2):
            for subset in SUBSETS:
                for program, follow in programs.items():
                    period = resolution(*follow(("first", "waves"), order, subset))
                    random = float(np.std(follow(("still", "again"), order, subset)[1]))
                    scores.setdefault((program, order), []).append(1e3 * period * random)
                    print(
                        f"{program:12s} {order:5d} {subset:6d} {period:8.1f} {1e3 * random:7.2f}"
                        f" {1e3 * period * random:11.0f}",
                        flush=True,
                    )
        for (program, order), values in scores.items():
            known = sorted(value for value in values if np.isfinite(value))
            print(f"{program}, order {order}: {np.mean(known[:3]):.0f}, lowest {known[0]:.0f}")


if __name__ == "__main__":
    main()
