"""Two public sets of pictures: one with an exact field, one with the result of another program.

DIC Challenge 1.0, sample 14 (`dic_challenge_14_sinusoid`): u varies as a sine of 0.1 px whose
period falls along x; the exact field is given for every column. Sample 12
(`dic_challenge_12_oht_cfrp`): a plate with a hole in tension, eleven steps, with the fields that
DICe found (subset 27 px, translation and normal strains).

The pictures are not part of the repository: give their folder, or set SHAPEMORPH_DATA.
"""

import argparse
import contextlib
import io
import os
import tempfile
from pathlib import Path

import numpy as np

from shapemorph.cli import main as shapemorph

STRAIN_UNIT = 1e-6
HOLE = [[float(194 + 51 * np.cos(a)), float(543 + 51 * np.sin(a))] for a in np.arange(0, 6.28, 0.1)]
PLATE = [[38.5, 28.5], [351.5, 28.5], [351.5, 1005.5], [38.5, 1005.5]]


def main() -> int:
    """Correlate both sets and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    default = Path(os.environ.get("SHAPEMORPH_DATA", "../shared/data"))
    parser.add_argument("folder", nargs="?", type=Path, default=default)
    folder = parser.parse_args().folder
    with tempfile.TemporaryDirectory() as scratch:
        sinusoid(folder / "dic_challenge_14_sinusoid", Path(scratch))
        open_hole(folder / "dic_challenge_12_oht_cfrp", Path(scratch))
    return 0


def correlate(words: list[str], out: Path, settings: dict[str, object]) -> None:
    """Run the command without figures."""
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    with contextlib.redirect_stdout(io.StringIO()):
        code = shapemorph(["correlate", *words, "-o", str(out), *sets, "--no-figures", "--quiet"])
    if code:
        raise SystemExit(code)


def table(folder: Path) -> dict[str, np.ndarray]:
    """Columns of the points with a value."""
    with np.load(folder / "correlation.npz") as arrays:
        ok = arrays["status"] == 0
        return {
            name: column[ok] if column.shape == ok.shape else column
            for name, column in arrays.items()
        } | {"share": np.array(ok.mean())}


def sinusoid(data: Path, scratch: Path) -> None:
    """Sample 14 against its exact field."""
    exact = np.genfromtxt(
        data / "exact_x_uL1_exxL1_uL3_exxL3_uL5_exxL5.csv", delimiter=",", names=True
    )
    print("sample 14: errors of u against the exact field, px (columns: mean over each column)")
    print(f"{'case':5s}{'subset':>7s}{'order':>6s}{'right':>8s}{'bias':>10s}{'rms':>9s}"
          f"{'rms of columns':>15s}{'rms v':>9s}{'E_xx rms':>10s}")  # fmt: skip
    for name in ("L1", "L3", "L5"):
        for subset, order in ((21, 1), (21, 2), (35, 1), (35, 2)):
            out = scratch / f"{name}_{subset}_{order}"
            pictures = [data / "Sample14_Reference.tif", data / f"Sample14_{name}_Amp0.1b.tif"]
            settings = {
                "correlate.subset_size": subset,
                "correlate.spacing": 8,
                "correlate.order": order,
            }
            correlate([str(path) for path in pictures], out, settings)
            found = table(out)
            x = found["x_px"]
            off = found["u_px"] - exact[f"u_{name}_px"][x]
            strain = found["E_xx"] - STRAIN_UNIT * exact[f"exx_{name}_microstrain"][x]
            columns = [off[x == each].mean() for each in np.unique(x)]
            print(f"{name:5s}{subset:7d}{order:6d}{(np.abs(off) < 0.1).mean():8.2%}"
                  f"{off.mean():10.5f}{rms(off):9.5f}{rms(np.array(columns)):15.5f}"
                  f"{rms(found['v_px']):9.5f}{rms(strain[np.isfinite(strain)]):10.6f}")  # fmt: skip


def open_hole(data: Path, scratch: Path) -> None:
    """Sample 12 against the fields of DICe."""
    print("sample 12: differences from DICe at its points, px")
    heads = "".join(f"{head:>9s}" for head in ("rms u", "rms v", "p95", "max"))
    print(f"{'frame':6s}{'points':>8s}{'found':>8s}{heads}")
    settings = {
        "correlate.subset_size": 27,
        "correlate.spacing": 5,
        "correlate.reference": "first",
        "inputs.region.polygon": PLATE,
        "inputs.region.holes": [HOLE],
    }
    out = scratch / "open_hole"
    correlate(["--sequence", str(data / "images" / "*.tiff")], out, settings)
    for number in range(1, 12):
        peer = read_dice(data / "dice_gold" / f"DICe_solution_{number:02d}.txt")
        off = difference(table(out / f"oht_cfrp_{number:02d}"), peer)
        known = np.isfinite(off).all(axis=1)
        u, v = off[known].T
        length = np.hypot(u, v)
        print(f"{number:<6d}{len(peer):8d}{known.mean():8.1%}{rms(u):9.4f}{rms(v):9.4f}"
              f"{np.percentile(length, 95):9.4f}{length.max():9.4f}")  # fmt: skip


def read_dice(path: Path) -> np.ndarray:
    """Columns x, y, u, v, px."""
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = [line.split(",")[:4] for line in lines if line[:1].isdigit()]
    return np.array(rows, dtype=np.float64)


def difference(found: dict[str, np.ndarray], peer: np.ndarray) -> np.ndarray:
    """(N, 2) ours - theirs at their points; NaN where no point of ours is within 3 px."""
    place = np.stack([found["x_px"], found["y_px"]], axis=-1)
    away = peer[:, None, :2] - place
    nearest = np.abs(away).max(axis=-1).argmin(axis=1)
    step = away[np.arange(len(peer)), nearest]
    u = found["u_px"][nearest] + found["du_dx"][nearest] * step[:, 0]
    v = found["v_px"][nearest] + found["dv_dx"][nearest] * step[:, 0]
    u, v = u + found["du_dy"][nearest] * step[:, 1], v + found["dv_dy"][nearest] * step[:, 1]
    off = np.stack([u, v], axis=-1) - peer[:, 2:]
    off[np.abs(step).max(axis=1) > 3] = np.nan
    return off


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


if __name__ == "__main__":
    raise SystemExit(main())
