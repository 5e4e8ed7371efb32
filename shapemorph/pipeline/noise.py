"""The noise floor: two scans of one state, measured like any other pair."""

from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.io.noise_files import NOISE_FILE
from shapemorph.io.safe_files import write_json
from shapemorph.pipeline.measure import measure
from shapemorph.pipeline.run import Listener

_CLEARLY = 10.0  # times the predicted standard deviation: not noise

DEFINITIONS = {
    "u, v, w": "displacement along x, y, z of the reference file, mm",
    "E1, E2": "principal Green-Lagrange strains, E1 >= E2, over the strain gauge",
    "mean": "over all OK points; the truth is zero, so this is the bias",
    "std": "spatial standard deviation over all OK points: the noise floor",
    "robust": "1.4826 times the median of absolute deviations: the noise floor without outliers",
    "predicted": "root mean square of the standard deviations that the measurement states",
    "ratio": "std over predicted",
}
_OF_STRAIN = (
    "E1 is the larger of two values: noise alone makes its mean positive and that of E2 negative"
)
_MOVED = "the rigid motion that best fits all OK points (least squares) is taken out"
_FIXED = "nothing is taken out: both files are in one frame and the object did not move"


def measure_noise(
    config: RunConfig, folder: Path, *, same_frame: bool, listener: Listener
) -> dict[str, Any]:
    """Measure two scans of one state and judge how far from zero the results are.

    Parameters
    ----------
    config : RunConfig
    folder : Path
        Of the run; gets ``noise.json`` too.
    same_frame : bool
        The object did not move between the scans, and both are in one frame.
    listener : callable

    Returns
    -------
    dict
        What ``noise.json`` holds: figures, definitions, gauge, notes.
    """
    from shapemorph.io.measurement_files import read_vtp
    from shapemorph.methods.noise_floor import noise_figures

    measure(config, folder, listener=listener)
    measurement, _ = read_vtp(folder / "measurement.vtp")
    figures = noise_figures(measurement, remove_motion=not same_frame)
    found = {
        "figures": figures,
        "alignment": _FIXED if same_frame else _MOVED,
        "definitions": DEFINITIONS,
        "notes": [_OF_STRAIN, *_doubts(figures, same_frame=same_frame)],
    }
    write_json(folder / NOISE_FILE, found)
    return found


def _doubts(figures: dict[str, Any], *, same_frame: bool) -> list[str]:
    """Say what speaks against two scans of one state."""
    doubts = []
    if not same_frame:
        doubts.append("the means of u, v, w are zero by construction: the motion was fitted")
    strained = [n for n in ("E1", "E2") if _is_no_noise(figures[n])]
    if strained:
        doubts.append(
            f"{' and '.join(strained)} lie far beyond the predicted noise: are these two scans of "
            "one state?"
        )
    return doubts


def _is_no_noise(figures: dict[str, float]) -> bool:
    largest = max(abs(figures["mean"]), figures["robust_std"])
    return largest > _CLEARLY * figures["predicted"]
