"""Stereo experiments at the command line."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from shapemorph.cli.console import configure_log, watching
from shapemorph.cli.options import Say, Settings
from shapemorph.cli.runs import is_config, print_result
from shapemorph.cli.words import describe_verdict
from shapemorph.core.errors import ConfigError

if TYPE_CHECKING:
    from shapemorph.config import BulgeConfig, ReproduceConfig, RunConfig, TwinConfig


def write_stereo_twin(
    kind: str, output: Path | None, settings: Settings, say: Say
) -> tuple[list[Path], Path]:
    """Write a synthetic stereo experiment; return its files and folder."""
    from shapemorph.pipeline.turntable import write_turntable_case
    from shapemorph.pipeline.twin import write_twin_case

    config, folder = read_twin(kind, settings), output or Path(f"{Path(kind).stem}_twin")
    with watching(say) as listener:
        if config.kind == "bulge" and config.frames:
            return write_turntable_case(config, folder, listener=listener)[1], folder
        return write_twin_case(config, folder, listener=listener), folder


def track_pictures(config: "RunConfig", folder: Path, say: Say) -> int:
    """Measure the stereo sequence of a configuration and print what was found."""
    from shapemorph.pipeline.stereo_track import track_stereo

    configure_log(say)
    with watching(say) as listener:
        found = track_stereo(config, folder, listener=listener)
    return print_result(found.folder, found.summary, _describe, say)


def _describe(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    points, strain = summary["points"], summary["strain"]
    yield f"points      {points['ok']} of {points['total']} ({points['ok_share']:.1%})"
    yield (
        f"displaced   median {summary['displacement_mm']['median']:.4g} mm, largest "
        f"{summary['displacement_mm']['max']:.4g} mm (1 sigma "
        f"{summary['sigma_displacement_mm']['median']:.4g} mm)"
    )
    for name in ("E1", "E2"):
        found = strain[name]
        yield (
            f"{name}          median {found['median']:.4g}, p1 {found['p1']:.4g}, p99 "
            f"{found['p99']:.4g} (Green-Lagrange)"
        )
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def read_twin(kind: str, settings: Settings) -> "TwinConfig":
    """Read the YAML file of a stereo experiment, or make a default one of a kind.

    Raises
    ------
    ConfigError
        If there is no such kind or file, or the file is wrong.
    """
    from shapemorph.config import TwinConfig
    from shapemorph.io.config_files import check_config, read_config
    from shapemorph.pipeline.twin import TwinFile

    if is_config(Path(kind)):
        return read_config(Path(kind), TwinFile, settings.set_).twin
    kinds = get_args(TwinConfig.model_fields["kind"].annotation)
    if kind not in kinds:
        raise ConfigError(
            f"expected a stereo experiment ({', '.join(kinds)}) or a YAML file, got {kind!r}"
        )
    return check_config({"twin": {"kind": kind}}, TwinFile, settings.set_).twin


def read_reproduction(
    case: str, settings: Settings, *, quick: bool
) -> "ReproduceConfig | BulgeConfig":
    """Read the YAML file of a reproduction, or make a default one, small if that is asked for.

    Raises
    ------
    ConfigError
        If there is no such case or file, or the file is wrong.
    """
    from shapemorph.io.config_files import check_config, read_config
    from shapemorph.pipeline.reproduce import QUICK, ReproduceFile
    from shapemorph.pipeline.reproduce_bulge import QUICK_BULGE

    if is_config(Path(case)):
        if quick:
            raise ConfigError(f"--quick stands instead of a file, got {case} too: leave one out")
        found = read_config(Path(case), ReproduceFile, settings.set_)
    else:
        cases = {"membrane": ("reproduce", QUICK), "bulge": ("bulge", QUICK_BULGE)}
        if case not in cases:
            raise ConfigError(f"expected {', '.join(cases)} or a YAML file, got {case!r}")
        section, small = cases[case]
        found = check_config({section: small if quick else {}}, ReproduceFile, settings.set_)
    return found.bulge or found.reproduce


def describe_reproduction(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say how far off every method was."""
    yield f"{'mean ± s.d., mm':24s}{'points':>8s}" + "".join(f"{name:>20s}" for name in "uvw")
    for name, method in summary["methods"].items():
        errors = method["against_truth_mm"]
        texts = (f"{errors[key]['mean']:.4f} ± {errors[key]['std']:.4f}" for key in "uvw")
        yield f"{name:24s}{method['points']:8d}" + "".join(f"{text:>20s}" for text in texts)
    yield f"page        {folder / 'index.html'}"


def describe_bulge(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say how far off every law was."""
    names = ("position", "E1", "E2")
    yield f"{'rms, away from the kink':24s}{'points':>8s}" + "".join(f"{n:>14s}" for n in names)
    for name, law in summary["laws"].items():
        rms = law["rms_away_from_kink"]
        texts = (f"{rms['position_mm']:.4f} mm", f"{rms['E1']:.4f}", f"{rms['E2']:.4f}")
        yield f"{name:24s}{law['points']:8d}" + "".join(f"{text:>14s}" for text in texts)
    agree = summary["laws_agree_mm"]
    if agree is not None:
        yield f"laws agree  {1e3 * agree:.2g} um rms"
    glare = summary["glare"]
    yield f"glare       {glare['share_found']:.1%} of {glare['points']} points that it covered once"
    yield f"page        {folder / 'index.html'}"
