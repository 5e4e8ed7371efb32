"""A finished run against the truth of the synthetic pair that it measured."""

from pathlib import Path
from typing import Any

from shapemorph.core.errors import DataError

TABLE_SIZE = 70.0
"""Size that the limits below are stated for, mm; they scale with the object."""

WRONG, KINK_MARGIN, RIM_MARGIN, REACH = 0.25, 1.5, 1.5, 1.0
"""A wrong position, margins of kinks and rims, reach of a point: mm on a 70 mm object."""

SAMPLES, SEED = 20_000, 0
"""Random material points for the coverage."""


def compare(run: Path, truth: Path) -> dict[str, Any]:
    """Compare RUN/measurement.vtp with a truth.npz.

    Parameters
    ----------
    run : Path
        Folder of a finished run, or a measurement.vtp.
    truth : Path
        truth.npz, or the folder that holds it.

    Returns
    -------
    dict
        See :func:`shapemorph.methods.comparison.compare_with_truth`; all lengths in mm.
        Limits scale with the object, `wrong_points` also stands at a fixed 0.25 mm.

    Raises
    ------
    DataError
        If a file is missing, or the run measured another object.
    """
    from shapemorph.io.measurement_files import read_vtp
    from shapemorph.io.truth_files import read_truth
    from shapemorph.methods.comparison import Yardstick, compare_with_truth

    field = run if run.suffix == ".vtp" else run / "measurement.vtp"
    if not field.is_file():
        raise DataError(
            f"expected a measurement in {run}, found no {field.name}: run measure first"
        )
    known = read_truth(truth / "truth.npz" if truth.is_dir() else truth)
    measurement, _ = read_vtp(field)
    scale = known.size / TABLE_SIZE
    yardstick = Yardstick(
        wrong=WRONG * scale,
        wrong_fixed=WRONG,
        kink_margin=KINK_MARGIN * scale,
        rim_margin=RIM_MARGIN * scale,
        reach=REACH * scale,
        samples=SAMPLES,
        seed=SEED,
    )
    return compare_with_truth(measurement, known, yardstick=yardstick)


def comparison_lines(result: dict[str, Any]) -> list[str]:
    """Format a comparison as lines of a table, without markup."""
    rows = [
        ("shape", f"{result['shape']}, {result['size_mm']:g} mm"),
        ("points, OK", f"{result['points']}, {result['ok_points']}"),
        ("covered", f"{_share(result['coverage'])} of the material"),
        ("covered, visible", f"{_share(result['visible_coverage'])} of the undamaged material"),
        _wrong_row(result["wrong_limit_mm"], result["wrong_points"], result["ok_points"]),
        _wrong_row(WRONG, result["wrong_points_fixed"], result["ok_points"]),
        ("position error", _microns(result["error_mm"])),
        ("displacement error", _microns(result["displacement_error_mm"])),
        ("|dE1|", _strains(result["dE1"])),
        ("|dE2|", _strains(result["dE2"])),
        ("within 1 sigma", _shares(result["within_sigma"])),
    ]
    if result["wrong_limit_mm"] == WRONG:
        del rows[5]
    width = max(len(name) for name, _ in rows) + 2
    return [f"{name:<{width}}{value}" for name, value in rows] + _notes(result)


def _notes(result: dict[str, Any]) -> list[str]:
    return [
        f"covered: with a right point within {result['reach_mm']:g} mm, "
        f"{result['rim_margin_mm']:g} mm inside the rim",
        "displacement: after the best rigid motion of the right points",
        f"strains: Green-Lagrange, {result['kink_margin_mm']:g} mm off any kink of the map",
        "within 1 sigma: 68 % for normal errors without bias; E1, E2 where they are told apart",
    ]


def _wrong_row(limit: float, count: int, total: int) -> tuple[str, str]:
    return f"off by > {limit:g} mm", f"{count} points, {_share(count / total)}"


def _share(share: float) -> str:
    return f"{100 * share:.3f} %"


def _microns(spread: dict[str, float | None]) -> str:
    return ", ".join(
        f"{name} {'-' if value is None else format(1000 * value, '.2f')} um"
        for name, value in spread.items()
    )


def _shares(shares: dict[str, float]) -> str:
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()) or "-"


def _strains(spread: dict[str, float | None]) -> str:
    return ", ".join(
        f"{name} {'-' if value is None else format(value, '.5f')}" for name, value in spread.items()
    )
