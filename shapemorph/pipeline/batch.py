"""Many pairs, one after the other on each worker: progress, table, summary page."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shapemorph.config import BatchConfig, RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.batch_files import Case
from shapemorph.io.batch_tables import write_batch_tables
from shapemorph.io.config_files import check_config
from shapemorph.io.folder_lock import LOCK_FILE, alone_in
from shapemorph.io.safe_files import check_writable, whole_file
from shapemorph.pipeline.batch_case import CASES, Row, failed_row, run_case, waiting_row
from shapemorph.pipeline.cluster import (
    Cluster,
    Crew,
    Payload,
    local_cluster,
    plan_crew,
    remote_cluster,
)


@dataclass(frozen=True, slots=True)
class BatchEvent:
    """What a batch tells those who watch.

    Attributes
    ----------
    state : str
        "ready": workers are there; "step": a case has begun a step; "ended": a case has a row.
    case : str
    text : str
        The crew, the step, or the verdict or reason.
    ended, total : int
        Cases that have a row, and all.
    """

    state: Literal["ready", "step", "ended"]
    case: str
    text: str
    ended: int
    total: int


BatchListener = Callable[[BatchEvent], None]


@dataclass(frozen=True, slots=True)
class BatchOutcome:
    """What a batch found.

    Attributes
    ----------
    folder : Path
    rows : tuple of dict
        One for each case, in the order of the batch file.
    crew : Crew or None
        None: no case could begin.
    files : tuple of Path
        Tables and the summary page.
    notes : tuple of str
        What was left out, and why.
    """

    folder: Path
    rows: tuple[Row, ...]
    crew: Crew | None
    files: tuple[Path, ...]
    notes: tuple[str, ...]

    @property
    def failed(self) -> tuple[Row, ...]:
        """Cases without a result."""
        return tuple(row for row in self.rows if row["state"] == "failed")


def run_batch(
    config: BatchConfig,
    cases: Sequence[Case],
    folder: Path,
    *,
    settings: Sequence[str] = (),
    scheduler: str | None = None,
    listener: BatchListener,
) -> BatchOutcome:
    """Bring every case of a batch up to date, in FOLDER/cases/NAME.

    What is current is kept, so that a batch that was ended by anything goes on where it
    was. A case that cannot be measured is a row with its reason. Tables and summary page
    are written again after every case.

    Parameters
    ----------
    config : BatchConfig
    cases : sequence of Case
    folder : Path
        New, empty, or a batch already.
    settings : sequence of str
        ``section.key=value`` over the configuration of every case.
    scheduler : str, optional
        Address of a Dask scheduler whose workers see the same files; None: this machine.
    listener : callable

    Raises
    ------
    ConfigError
        If the settings are wrong, the folder is somebody's, or there are no workers.
    """
    check_config({}, RunConfig, settings)
    _check_is_batch(folder)
    check_writable(folder)
    with alone_in(folder):
        return _run(config, cases, folder, settings, scheduler, listener)


def _run(
    config: BatchConfig,
    cases: Sequence[Case],
    folder: Path,
    settings: Sequence[str],
    scheduler: str | None,
    listener: BatchListener,
) -> BatchOutcome:
    book = _Book(folder, cases, listener)
    payloads = dict(_payloads(cases, folder.absolute(), settings, book))
    crew = None
    if payloads:
        with _cluster(config, len(payloads), scheduler) as cluster:
            crew = cluster.crew
            listener(BatchEvent("ready", "", str(crew), book.ended, len(cases)))
            _work(cluster, payloads, book)
    files, notes = book.write(crew)
    return BatchOutcome(folder, tuple(book.rows.values()), crew, tuple(files), tuple(notes))


class _Book:
    """The rows of a batch while it goes on."""

    def __init__(self, folder: Path, cases: Sequence[Case], listener: BatchListener) -> None:
        self.folder = folder
        self.rows: dict[str, Row] = {case.name: waiting_row(case.name) for case in cases}
        self._listener = listener

    @property
    def ended(self) -> int:
        """Cases that have a result or a reason."""
        return sum(row["state"] != "waiting" for row in self.rows.values())

    def enter(self, row: Row) -> None:
        """Take down what became of a case."""
        self.rows[row["case"]] = row
        text = row["verdict"] or row["reason"]
        self._tell("ended", row["case"], text)

    def hear(self, message: Mapping[str, Any]) -> None:
        """Pass on what a worker tells."""
        if message["state"] == "started":
            self._tell("step", message["case"], message["step"])

    def write(self, crew: Crew | None) -> tuple[list[Path], list[str]]:
        """Write tables and summary page as they stand."""
        from shapemorph.view.batch_page import batch_page

        rows = list(self.rows.values())
        files, notes = write_batch_tables(self.folder, rows)
        page = self.folder / "index.html"
        with whole_file(page) as partial:
            text = batch_page(rows, "" if crew is None else str(crew))
            partial.write_text(text, encoding="utf-8")
        return [*files, page], notes

    def _tell(self, state: Literal["step", "ended"], case: str, text: str) -> None:
        self._listener(BatchEvent(state, case, text, self.ended, len(self.rows)))


def _payloads(
    cases: Sequence[Case], folder: Path, settings: Sequence[str], book: _Book
) -> Iterator[tuple[str, Payload]]:
    """Check every case; one whose configuration is wrong gets its row at once."""
    for case in cases:
        try:
            config = check_config(
                case.document, RunConfig, settings, source=f"configuration of {case.name}"
            )
        except ConfigError as error:
            book.enter(failed_row(case.name, str(error)))
            continue
        yield (
            case.name,
            {
                "name": case.name,
                "folder": str(folder / CASES / case.name),
                "config": config.model_dump(mode="json"),
            },
        )


def _work(cluster: Cluster, payloads: Mapping[str, Payload], book: _Book) -> None:
    told = {name: {**p, "threads": cluster.crew.threads} for name, p in payloads.items()}
    for name, result in cluster.run(run_case, told, book.hear):
        row = result if isinstance(result, dict) else failed_row(name, _why(result))
        book.enter(row)
        book.write(cluster.crew)


def _why(error: Exception) -> str:
    if type(error).__name__ == "KilledWorker":
        return (
            "its worker died each time it was tried (killed, or beyond its memory): lower "
            "flatten.max_megapixels, or raise cluster.memory_gb with fewer cluster.workers"
        )
    return f"unexpected {type(error).__name__}: {error}"


def _cluster(
    config: BatchConfig, cases: int, scheduler: str | None
) -> AbstractContextManager[Cluster]:
    if scheduler:
        return remote_cluster(scheduler, config.cluster)
    return local_cluster(plan_crew(config.cluster, cases))


def _check_is_batch(folder: Path) -> None:
    """Refuse to mix results with somebody's files.

    Raises
    ------
    ConfigError
        If the folder holds anything but a batch.
    """
    entries = {entry.name for entry in folder.iterdir()} if folder.is_dir() else set()
    if entries - {LOCK_FILE} and not entries & {CASES, "batch.csv"}:
        raise ConfigError(
            f"output {folder} holds other files and is no batch of shapemorph: choose a new or "
            "empty directory with -o"
        )
