"""Measure a pair of textured meshes in a folder: the order of everything."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.image import GreyImage
from shapemorph.io.safe_files import check_writable, remove_folder
from shapemorph.io.store import RunStore
from shapemorph.pipeline.inputs import Inputs
from shapemorph.pipeline.outputs import (
    OUTPUTS,
    RECORD,
    Finished,
    Output,
    OutputRecord,
    output_fingerprints,
    write_output,
)
from shapemorph.pipeline.run import (
    Event,
    Listener,
    Results,
    Stage,
    dependents,
    fingerprints,
    outdated_stages,
    run_stages,
    stages_until,
)
from shapemorph.pipeline.stagelist import STAGES, sections
from shapemorph.pipeline.unmatched import showing_failed_match


@dataclass(frozen=True, slots=True)
class Outcome:
    """What bringing a run up to date did.

    Attributes
    ----------
    folder : Path
    ran, kept : tuple of str
        Stages.
    written : tuple of str
        Outputs.
    """

    folder: Path
    ran: tuple[str, ...]
    kept: tuple[str, ...]
    written: tuple[str, ...]

    @property
    def did_nothing(self) -> bool:
        """Whether everything was up to date already."""
        return not self.ran and not self.written


@dataclass(frozen=True, slots=True)
class Plan:
    """What has to be done.

    Attributes
    ----------
    stages : tuple of Stage
        All that are asked for.
    outdated : dict of str to str
        Name -> fingerprint of those that have to run.
    outputs : dict of str to str
        Name -> fingerprint of every output, asked for or not.
    due : tuple of Output
        Those that have to be written.
    """

    stages: tuple[Stage, ...]
    outdated: dict[str, str]
    outputs: dict[str, str]
    due: tuple[Output, ...]


def measure(
    config: RunConfig,
    folder: Path,
    *,
    until: str | None = None,
    force: Sequence[str] = (),
    listener: Listener,
) -> Outcome:
    """Bring the run in `folder` up to date with its configuration and inputs.

    Parameters
    ----------
    config : RunConfig
        With absolute paths.
    folder : Path
        New, empty, or a run already.
    until : str, optional
        Last stage; outputs that need later ones are not made.
    force : sequence of str
        Stages to run again, with everything that depends on them.
    listener : callable
        Told of every stage and output.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing of a failed stage is stored; what was finished before it is, unless the
        settings of a new run are refused.
    """
    for name in (*force, *([until] if until else [])):
        _known(name)
    check_is_run(folder)
    check_writable(folder)
    inputs, store = Inputs(config), RunStore(folder)
    inputs.files()
    store.sweep()
    results = Results(inputs, store, STAGES)
    record = OutputRecord(folder)
    plan = make_plan(config, inputs, store, record, until=until, force=force)
    if not plan.outdated and not plan.due:
        return _outcome(folder, plan)
    run = Finished(config, folder, results, {})
    figures = any(output.name == "figures" for output in plan.due)
    with run.drawing(wanted=figures):  # loads what draws while this loads what measures
        if plan.outdated:
            inputs.check_beside_meshes()
        with _clean_start(folder, store):
            _bring_up_to_date(plan, run, store, record, listener)
    return _outcome(folder, plan)


def _bring_up_to_date(
    plan: Plan, run: Finished, store: RunStore, record: OutputRecord, listener: Listener
) -> None:
    """Run the stages and write the outputs of a plan."""
    record.open()
    _remove_obsolete(record, plan)
    first = [output for output in plan.due if output.name == "run.yaml"]
    _write(first, run, record, plan, listener)
    with showing_failed_match(run.folder, lambda: _flattened(run.results)):
        run_stages(
            plan.stages,
            sections(run.config),
            run.results,
            store,
            plan.outdated,
            _drawing_too(run, listener),
        )
    run.seconds.update(_seconds(store, record))
    run.all_reached()
    rest = [output for output in plan.due if output.name != "run.yaml"]
    _write(rest, run, record, plan, listener)


def report(config: RunConfig, folder: Path, *, listener: Listener) -> Outcome:
    """Make the outputs of a finished run again from its stored results.

    Raises
    ------
    ConfigError
        If a stage is not up to date.
    """
    inputs, store, record = Inputs(config), RunStore(folder), OutputRecord(folder)
    check_writable(folder)
    plan = make_plan(config, inputs, store, record)
    if plan.outdated:
        raise ConfigError(
            f"{folder} is not up to date ({', '.join(plan.outdated)}): "
            f"run `shapemorph run {folder / 'run.yaml'}` first"
        )
    run = Finished(config, folder, Results(inputs, store, STAGES), _seconds(store, record))
    remade = [output for output in OUTPUTS if output.name in ("figures", "summary", "report")]
    with run.drawing(wanted=True):
        run.all_reached()
        _write(remade, run, record, plan, listener)
    names = tuple(output.name for output in remade)
    return Outcome(folder, (), tuple(stage.name for stage in STAGES), names)


def make_plan(
    config: RunConfig,
    inputs: Inputs,
    store: RunStore,
    record: OutputRecord,
    *,
    until: str | None = None,
    force: Sequence[str] = (),
) -> Plan:
    """Compare what is stored with what is wanted; loads no result and no mesh."""
    forced = {name for first in force for name in dependents(STAGES, _known(first))}
    stages = stages_until(STAGES, until)
    wanted = fingerprints(STAGES, sections(config), inputs)
    outdated = outdated_stages(stages, wanted, store, forced)
    outputs = output_fingerprints(OUTPUTS, config, wanted)
    reach = {stage.name for stage in stages}
    due = tuple(
        output
        for output in OUTPUTS
        if reach.issuperset(output.reads)
        and (
            not outdated.keys().isdisjoint(output.reads)
            or not record.is_current(output.name, outputs[output.name])
        )
    )
    return Plan(stages, outdated, outputs, due)


def check_is_run(folder: Path) -> None:
    """Refuse to mix results with somebody's files.

    Raises
    ------
    ConfigError
        If the folder holds anything but a run.
    """
    entries = {entry.name for entry in folder.iterdir()} if folder.is_dir() else set()
    foreign = {name for name in entries if not name.startswith(".partial-")}
    if foreign and RECORD not in foreign:
        raise ConfigError(
            f"output {folder} holds other files and is no run of shapemorph: choose a new or "
            "empty directory with -o"
        )


def _drawing_too(run: Finished, listener: Listener) -> Listener:
    """Tell of every stage that is up to date not only who watches but what draws."""

    def told(event: Event) -> None:
        listener(event)
        if event.state != "started":
            run.reached(event.name)

    return told


def _flattened(results: Results) -> tuple[GreyImage, GreyImage]:
    pair: FlattenedPair = results.load("flatten")
    return pair.reference.calibrated.image, pair.deformed.calibrated.image


def _remove_obsolete(record: OutputRecord, plan: Plan) -> None:
    """Remove what would stand beside results of another recipe, asked for or not."""
    for name, wanted in plan.outputs.items():
        if record.is_obsolete(name, wanted):
            record.remove(name)


def _write(
    outputs: Sequence[Output], run: Finished, record: OutputRecord, plan: Plan, listener: Listener
) -> None:
    for output in outputs:
        write_output(output, run, record, plan.outputs[output.name], listener)


def _known(name: str) -> str:
    return stages_until(STAGES, name)[-1].name


def _seconds(store: RunStore, record: OutputRecord) -> dict[str, float]:
    stages = {stage.name: store.seconds(stage.name) for stage in STAGES}
    known = {name: value for name, value in stages.items() if value is not None}
    return {**known, **{f"write {name}": value for name, value in record.seconds().items()}}


@contextlib.contextmanager
def _clean_start(folder: Path, store: RunStore) -> Iterator[None]:
    """Remove a folder that is new with this run if its settings are refused or nothing is in it."""
    existed = folder.is_dir()
    was_empty = not existed or not any(folder.iterdir())
    try:
        yield
    except BaseException as error:
        refused = isinstance(error, ConfigError)  # a region with nothing in it shows late
        if was_empty and (refused or store.fingerprint("flatten") is None):
            remove_folder(folder)
            if existed:
                folder.mkdir()
        raise


def _outcome(folder: Path, plan: Plan) -> Outcome:
    kept = tuple(stage.name for stage in plan.stages if stage.name not in plan.outdated)
    written = tuple(output.name for output in plan.due)
    return Outcome(folder, tuple(plan.outdated), kept, written)
