"""What several commands do: find the configuration, bring a run up to date, print it."""

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from shapemorph.cli.console import configure_log, show, show_json, watching
from shapemorph.cli.options import Say, Settings
from shapemorph.core.errors import ConfigError

if TYPE_CHECKING:
    from shapemorph.config import RunConfig, SynthesizeConfig
    from shapemorph.pipeline.measure import Outcome

CONFIG_SUFFIXES = (".yaml", ".yml")


def is_config(path: Path) -> bool:
    """Tell a configuration, or a run, from a mesh or a picture."""
    return path.suffix.lower() in CONFIG_SUFFIXES or (path / "run.yaml").is_file()


def read_run_config(path: Path, settings: Settings) -> "RunConfig":
    """Read a YAML file, or the one in the directory of a run."""
    from shapemorph.config import RunConfig
    from shapemorph.io.config_files import read_config

    if not path.exists() and path.suffix.lower() not in CONFIG_SUFFIXES:
        raise ConfigError(
            f"{path} was not found: expected a YAML file (`shapemorph init` writes one) or the "
            "directory of a run"
        )
    if path.is_dir():
        if not (path / "run.yaml").is_file():
            raise ConfigError(f"{path} is no run: expected a directory with run.yaml in it")
        path = path / "run.yaml"
    elif path.suffix.lower() not in CONFIG_SUFFIXES:
        raise ConfigError(
            f"expected a YAML file ({', '.join(CONFIG_SUFFIXES)}) or the directory of a run, got "
            f"{path}"
        )
    return read_config(path, RunConfig, settings.set_)


def read_finished_config(folder: Path) -> "RunConfig":
    """Read the configuration that a run was made with.

    Raises
    ------
    ConfigError
        If there is no such directory, or it is no run.
    """
    if not folder.exists():
        raise ConfigError(f"run directory {folder} was not found: check the path")
    if not folder.is_dir():
        raise ConfigError(f"expected the directory of a run, got the file {folder}")
    return read_run_config(folder, Settings())


def read_case(case: str, settings: Settings) -> "SynthesizeConfig":
    """Read the YAML file of a synthetic case, or make a default one of a shape.

    Raises
    ------
    ConfigError
        If there is no such shape or file, or the file is wrong.
    """
    from shapemorph.config import SynthesizeConfig
    from shapemorph.io.config_files import check_config, read_config
    from shapemorph.pipeline.synthesize import SynthesizeFile

    if Path(case).suffix.lower() in CONFIG_SUFFIXES:
        return read_config(Path(case), SynthesizeFile, settings.set_).synthesize
    shapes = get_args(SynthesizeConfig.model_fields["shape"].annotation)
    if case not in shapes:
        raise ConfigError(f"expected a shape ({', '.join(shapes)}) or a YAML file, got {case!r}")
    return check_config({"synthesize": {"shape": case}}, SynthesizeFile, settings.set_).synthesize


def defaults(settings: Settings) -> "RunConfig":
    """Give the default configuration with some settings over it."""
    from shapemorph.config import RunConfig
    from shapemorph.io.config_files import check_config

    return check_config({}, RunConfig, settings.set_)


def pair_config(inputs: dict[str, Path | None], settings: Settings) -> "RunConfig":
    """Give the configuration of a pair that the command line names."""
    from shapemorph.config import RunConfig
    from shapemorph.io.config_files import check_config

    given = {key: str(path.absolute()) for key, path in inputs.items() if path is not None}
    return check_config({"inputs": given}, RunConfig, settings.set_)


def with_steps(settings: Settings, steps: int | None) -> Settings:
    """Turn the number N of pictures of a morph sequence into the setting `morph.images`."""
    if steps is None:
        return settings
    if steps < 2 or steps % 2:
        raise ConfigError(f"--steps expects an even number of pictures, at least 2, got {steps}")
    return Settings([*settings.set_, f"morph.images={steps - 2}"])


def both(deformed: Path | None, command: str) -> Path:
    """Insist on the second picture."""
    if deformed is None:
        raise ConfigError(f"{command} expects two pictures, or one YAML file; got one picture")
    return deformed


def bring_up_to_date(
    config: "RunConfig",
    folder: Path,
    say: Say,
    *,
    until: str | None = None,
    force: Sequence[str] = (),
) -> int:
    """Run what is outdated and print what was found."""
    from shapemorph.pipeline.measure import measure

    configure_log(say)
    with watching(say) as listener:
        outcome = measure(config, folder, until=until, force=force, listener=listener)
    return print_outcome(outcome, say)


def print_outcome(outcome: "Outcome", say: Say) -> int:
    """Print what a run did and found."""
    from shapemorph.cli.words import describe_run

    summary_file = outcome.folder / "summary.json"
    summary: dict[str, Any] = {}
    if summary_file.is_file():
        summary = json.loads(summary_file.read_text(encoding="utf-8"))
    if say.json:
        done = {"folder": str(outcome.folder), "ran": outcome.ran, "kept": outcome.kept}
        show_json({"run": {**done, "written": outcome.written}, **summary})
        return 0
    if outcome.did_nothing:
        show(f"nothing to do: {outcome.folder} is up to date")
    if summary:
        show("\n".join(describe_run(outcome.folder, summary)))
    elif not outcome.did_nothing:
        show(f"ran {', '.join(outcome.ran) or 'nothing'} in {outcome.folder}")
    return 0


def print_result(
    folder: Path,
    summary: dict[str, Any],
    describe: Callable[[Path, dict[str, Any]], Iterator[str]],
    say: Say,
) -> int:
    """Print what was found outside of a run."""
    if say.json:
        show_json({"folder": str(folder), **summary})
    else:
        show("\n".join(describe(folder, summary)))
    return 0
