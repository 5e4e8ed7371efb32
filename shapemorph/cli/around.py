"""The commands around a measurement: cases with truth, configurations, the machine."""

from pathlib import Path

from shapemorph.cli.app import NO_SETTINGS, SAY, app
from shapemorph.cli.console import configure_log, show, show_json, watching
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.runs import print_outcome, read_case, read_finished_config, read_run_config
from shapemorph.core.errors import ConfigError

__all__ = ["app"]  # with all commands, those of this module included


@app.command
def synthesize(
    case: str = "bulge",
    kind: str | None = None,
    /,
    *,
    output: Output = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Make a textured pair, or the pictures of a stereo experiment, with exact truth.

    Parameters
    ----------
    case
        Shape (dome, bulge, indentation, freeform, hole, tube, rigid, balloon, sheet) or a YAML
        file with a section `synthesize`; or `stereo`.
    kind
        Of `stereo`: membrane, bulge, or a YAML file with a section `twin`.
    """
    from shapemorph.cli.stereo import write_stereo_twin
    from shapemorph.pipeline.synthesize import write_case

    configure_log(say)
    if case == "stereo":
        files, folder = write_stereo_twin(kind or "membrane", output, settings, say)
    elif kind is not None:
        raise ConfigError(f"a second word follows stereo only, got {case} {kind}: leave it out")
    else:
        config = read_case(case, settings)
        folder = output or Path(Path(case).stem)
        files = write_case(config, folder)
    if say.json:
        show_json({"folder": str(folder), "files": [str(file) for file in files]})
    else:
        show("\n".join(str(file) for file in files))
    return 0


@app.command
def compare(run_folder: Path, truth: Path, /, *, say: Say = SAY) -> int:
    """Print the errors of a run against the truth of the synthetic pair that it measured.

    Parameters
    ----------
    run_folder
        Directory of the run.
    truth
        truth.npz, or the directory that holds it.
    """
    from shapemorph.pipeline.compare import compare as compare_run
    from shapemorph.pipeline.compare import comparison_lines

    found = compare_run(run_folder, truth)
    show_json(found) if say.json else show("\n".join(comparison_lines(found)))
    return 0


@app.command
def init(path: Path = Path("shapemorph.yaml"), /, *, say: Say = SAY) -> int:  # noqa: ARG001
    """Write a configuration with every default and what it means.

    Parameters
    ----------
    path
        YAML file to write; one that exists is left alone.
    """
    from shapemorph.config import RunConfig
    from shapemorph.io.config_files import template_text
    from shapemorph.io.safe_files import check_writable, whole_file

    if path.exists():
        raise ConfigError(f"{path} exists already: name another file or remove it first")
    check_writable(path.parent)
    with whole_file(path) as partial:
        partial.write_text(template_text(RunConfig), encoding="utf-8")
    show(str(path))
    return 0


@app.command
def check(config: Path, /, *, settings: Settings = NO_SETTINGS, say: Say = SAY) -> int:
    """Check a configuration and everything that it names, without running.

    Parameters
    ----------
    config
        YAML file, or the directory of a run.
    """
    from shapemorph.cli.words import describe_check
    from shapemorph.pipeline.check import check_inputs

    configure_log(say)
    found = check_inputs(read_run_config(config, settings))
    show_json(found) if say.json else show("\n".join(describe_check(found)))
    return 0


@app.command
def report(run_folder: Path, /, *, say: Say = SAY) -> int:
    """Make summary, figures and report of a finished run again.

    Parameters
    ----------
    run_folder
        Directory of the run.
    """
    from shapemorph.pipeline.measure import report as make_again

    config = read_finished_config(run_folder)
    configure_log(say)
    with watching(say) as listener:
        outcome = make_again(config, run_folder, listener=listener)
    return print_outcome(outcome, say)


@app.command
def doctor(*, say: Say = SAY) -> int:
    """Look whether this machine has everything, and say how to mend what is missing."""
    from dataclasses import asdict

    from shapemorph.pipeline.doctor import examine

    findings = []
    for finding in examine():
        findings.append(finding)
        if not say.json and not (say.quiet and finding.ok):
            show(f"{'ok     ' if finding.ok else 'MISSING'} {finding.name}: {finding.detail}")
            if finding.remedy:
                show(f"        mend it with: {finding.remedy}")
    if say.json:
        show_json([asdict(finding) for finding in findings])
    return 0 if all(finding.ok for finding in findings) else 1
