"""The files of a run for people and scripts, each remade when what it shows has changed."""

import functools
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shapemorph.config import RunConfig
from shapemorph.core.forming import Forming
from shapemorph.core.measurement import Measurement
from shapemorph.core.results import RunResults
from shapemorph.io.config_files import config_text
from shapemorph.io.safe_files import move_files, scratch_folder, write_json
from shapemorph.pipeline.drawing import Drawing
from shapemorph.pipeline.fingerprints import code_fingerprint, file_fingerprint, fingerprint
from shapemorph.pipeline.run import Event, Listener, Results

if TYPE_CHECKING:
    from shapemorph.view.drawing_process import Pictures

RECORD = "outputs.json"


class Finished:
    """A run whose stages are up to date, as far as its outputs need them."""

    def __init__(
        self, config: RunConfig, folder: Path, results: Results, seconds: Mapping[str, float]
    ) -> None:
        self.config = config
        self.folder = folder
        self.results = results
        self.seconds = dict(seconds)
        self._drawing: Drawing | None = None

    @contextmanager
    def drawing(self, *, wanted: bool) -> Iterator[None]:
        """Load what draws beside the run, if figures are wanted."""
        if not (wanted and self.config.report.figures):
            yield
            return
        from shapemorph.view.drawing_process import DrawingProcess

        with DrawingProcess(self.config.report.theme) as process:
            self._drawing = Drawing(self.results, process)
            yield

    def reached(self, stage: str) -> None:
        """Draw what shows a stage, now that it is up to date, if figures are wanted."""
        if self._drawing:
            self._drawing.reached(stage)

    def all_reached(self) -> None:
        """Draw all that is left, now that every stage is up to date, if figures are wanted."""
        if self._drawing:
            self._drawing.all_reached(self._found)

    def drawn(self) -> "Pictures":
        """Wait for the figures."""
        return self._drawing.finish() if self._drawing else []

    @functools.cached_property
    def measurement(self) -> Measurement:
        """Every measured point."""
        return self._with_forming[0]

    @property
    def forming(self) -> Forming:
        """What is asked for beyond the field."""
        return self._with_forming[1]

    @functools.cached_property
    def _with_forming(self) -> tuple[Measurement, Forming]:
        from shapemorph.io.meshes import MM_PER_UNIT
        from shapemorph.methods.assemble import assemble_measurement
        from shapemorph.methods.charts.ownership import assign_points
        from shapemorph.pipeline.forming import with_forming

        load = self.results.load
        grid, tracked = load("correlate"), load("lift")
        ownership = assign_points(load("flatten"), grid, tracked)
        bare = assemble_measurement(grid, tracked, load("align"), load("strain"), ownership)
        unit = self.config.inputs.reference_units or self.config.inputs.units
        return with_forming(bare, self.config, load("limit_curve"), float(MM_PER_UNIT[unit]))

    def nouns(self) -> RunResults:
        """Collect everything that was found, with a summary as it stands now."""
        return replace(self._found, summary=self.summary(self._found))

    @functools.cached_property
    def _found(self) -> RunResults:
        """Everything but the summary."""
        load = self.results.load
        return RunResults(
            pair=load("flatten"),
            matches=load("match"),
            morphed=load("morph"),
            grid=load("correlate"),
            tracked=load("lift"),
            alignment=load("align"),
            field=load("strain"),
            spread=load("spread"),
            measurement=self.measurement,
            forming=self.forming,
            summary={},
            reference_mesh=load("reference"),
            deformed_mesh=load("deformed"),
        )

    def summary(self, results: RunResults) -> dict[str, Any]:
        """Figures of the run."""
        from shapemorph.pipeline.good_practice import good_practice
        from shapemorph.pipeline.summary import summarise

        found = summarise(results, self.results.load("inputs"), self.config, self.seconds)
        noise = self.results.load("noise")
        return found | {"good_practice": good_practice(found, self.config, noise)}


@dataclass(frozen=True, slots=True)
class Output:
    """Some files of a run.

    Attributes
    ----------
    name : str
    reads : tuple of str
        Stages whose results it shows.
    settings : callable
        What it takes from the configuration, JSON-able.
    write : callable
        Makes the files in a fresh folder, in the places that they have in the run.
    """

    name: str
    reads: tuple[str, ...]
    settings: Callable[[RunConfig], Any]
    write: Callable[[Finished, Path], None]


def _write_config(run: Finished, folder: Path) -> None:
    (folder / "run.yaml").write_text(config_text(run.config), encoding="utf-8")


def _write_pictures(run: Finished, folder: Path) -> None:
    from shapemorph.io.calibrated_files import write_pages

    pair = run.results.load("flatten")
    (folder / "flatten").mkdir()
    for side, surface in (("reference", pair.reference), ("deformed", pair.deformed)):
        write_pages(folder / "flatten" / side, run.results.load(side), surface.calibrated)


def _write_measurement(run: Finished, folder: Path) -> None:
    from shapemorph.io.measurement_files import write_measurement

    config = json.dumps(run.config.model_dump(mode="json"))
    write_measurement(folder, run.measurement, config)


def _write_sections(run: Finished, folder: Path) -> None:
    from shapemorph.io.measurement_files import write_table
    from shapemorph.pipeline.forming import cut_table

    for cut in run.forming.cuts:
        write_table(folder / "sections" / f"{cut.name}.csv", cut_table(run.measurement, cut))


def _write_figures(run: Finished, folder: Path) -> None:
    if run.config.report.figures:
        from shapemorph.view.figures import write_pictures
        from shapemorph.view.viewer import viewer_data

        viewer_data(run.measurement)  # what the report asks for, while figures are still drawn
        write_pictures(run.drawn(), folder / "figures")
    if run.config.report.animation:
        _write_animation(run.measurement, folder)


def _write_animation(measurement: Measurement, folder: Path) -> None:
    from shapemorph.io.animations import write_gif, write_mp4
    from shapemorph.view.animation import strain_film

    film = strain_film(measurement)
    if film is not None:
        write_gif(folder / "animation.gif", film)
        write_mp4(folder / "animation.mp4", film)


def _write_summary(run: Finished, folder: Path) -> None:
    write_json(folder / "summary.json", run.nouns().summary)


def _write_report(run: Finished, folder: Path) -> None:
    from shapemorph.view.report import Contents, write_report

    summary = json.loads((run.folder / "summary.json").read_text(encoding="utf-8"))
    figures = sorted((run.folder / "figures").glob("*.png")) if run.config.report.figures else []
    settings = {"config": run.config.model_dump(mode="json")}
    contents = Contents(summary | settings, figures, run.measurement, run.config.report.theme)
    write_report(contents, folder / "report.html")


def _everything(config: RunConfig) -> Any:
    return config.model_dump(mode="json"), _curve(config)


def _curve(config: RunConfig) -> str | None:
    """Content of the limit curve, which no stage reads."""
    path = config.forming.limit_curve
    return None if path is None else file_fingerprint(path)


def _drawn(config: RunConfig) -> Any:
    report = config.report.model_dump(include={"figures", "theme", "animation"})
    return report, config.forming.model_dump(mode="json"), _curve(config)


def _everything_and_noise(config: RunConfig) -> Any:
    path = config.report.noise
    return [_everything(config), path and file_fingerprint(path)]


_ALL = ("inputs", "flatten", "match", "morph", "correlate", "lift", "spread", "align", "strain")

_MEASURED = ("flatten", "correlate", "lift", "align", "strain")

OUTPUTS: tuple[Output, ...] = (
    Output("run.yaml", (), _everything, _write_config),
    Output("flatten", ("flatten",), lambda _: None, _write_pictures),
    Output(
        "measurement",
        _MEASURED,
        _everything,
        _write_measurement,
    ),
    Output("sections", _MEASURED, _everything, _write_sections),
    Output("figures", _ALL, _drawn, _write_figures),
    Output("summary", _ALL, _everything_and_noise, _write_summary),
    Output("report", _ALL, _everything_and_noise, _write_report),
)


class OutputRecord:
    """What was written into a run, and from what."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / RECORD
        self._folder = folder
        try:
            self._entries: dict[str, Any] = json.loads(self._path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._entries = {}

    def open(self) -> None:
        """Make the file of the record, which tells a run from any other folder."""
        if not self._path.is_file():
            write_json(self._path, self._entries)

    def is_current(self, name: str, wanted: str) -> bool:
        """Tell whether an output was made from this recipe and all its files are there."""
        files = self._entries.get(name, {}).get("files", ())
        return self._made_from(name) == wanted and all((self._folder / f).is_file() for f in files)

    def is_obsolete(self, name: str, wanted: str) -> bool:
        """Tell whether an output is there that shows another run than the wanted one."""
        return self._made_from(name) not in (None, wanted)

    def remove(self, name: str) -> None:
        """Remove the files of an output."""
        entry = self._entries.pop(name, None)
        for file in entry["files"] if entry else ():
            (self._folder / file).unlink(missing_ok=True)
        if entry:
            write_json(self._path, self._entries)

    def enter(self, name: str, wanted: str, files: list[Path], seconds: float) -> None:
        """Note that an output was written."""
        relative = [file.relative_to(self._folder).as_posix() for file in files]
        self._entries[name] = {"fingerprint": wanted, "files": relative, "seconds": seconds}
        write_json(self._path, self._entries)

    def _made_from(self, name: str) -> str | None:
        found: str | None = self._entries.get(name, {}).get("fingerprint")
        return found

    def seconds(self) -> dict[str, float]:
        """Time that each output took."""
        return {name: float(entry["seconds"]) for name, entry in self._entries.items()}


def output_fingerprints(
    outputs: tuple[Output, ...], config: RunConfig, stages: Mapping[str, str]
) -> dict[str, str]:
    """Fingerprint that each output must have to be current."""
    return {
        output.name: fingerprint(
            code_fingerprint(including_view=True),
            output.name,
            output.settings(config),
            [stages[name] for name in output.reads],
        )
        for output in outputs
    }


def write_output(
    output: Output, run: Finished, record: OutputRecord, wanted: str, listener: Listener
) -> None:
    """Make the files of one output; they appear whole or not at all."""
    listener(Event(f"write {output.name}", "started"))
    begin = time.perf_counter()
    record.remove(output.name)
    with scratch_folder(run.folder) as scratch:
        output.write(run, scratch)
        files = move_files(scratch, run.folder)
    seconds = time.perf_counter() - begin
    record.enter(output.name, wanted, files, seconds)
    run.seconds[f"write {output.name}"] = seconds
    listener(Event(f"write {output.name}", "finished", seconds))
