"""Bring a list of stages up to date: what is current is kept, the rest runs in order."""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from shapemorph.config import Section
from shapemorph.core.errors import ConfigError
from shapemorph.pipeline.fingerprints import code_fingerprint, fingerprint

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Stage:
    """A pure function and the names of what it reads.

    Attributes
    ----------
    name : str
        At once the YAML section, the command, the module in ``shapemorph.stages`` and the
        folder of the result.
    run : callable
        Called with the content of everything in `reads`, in order, then the section.
    reads : tuple of str
        Earlier stages and sources.
    elsewhere : frozenset of str
        Keys of the section whose content comes in through `reads` instead.
    """

    name: str
    run: Callable[..., Any]
    reads: tuple[str, ...]
    elsewhere: frozenset[str] = frozenset()


class Sources(Protocol):
    """What a run reads from outside."""

    def fingerprint(self, name: str) -> str:
        """Digest of a source, without loading it where possible."""

    def load(self, name: str) -> Any:
        """Content of a source."""


class Store(Protocol):
    """Where results are kept."""

    def fingerprint(self, name: str) -> str | None:
        """Fingerprint of the stored result, None where there is none."""

    def load(self, name: str) -> Any:
        """Read a stored result."""

    def save(self, name: str, noun: object, *, fingerprint: str, seconds: float) -> None:
        """Keep a result."""


@dataclass(frozen=True, slots=True)
class Event:
    """What the runner tells those who watch."""

    name: str
    state: Literal["kept", "started", "finished"]
    seconds: float = 0.0


Listener = Callable[[Event], None]


class Results:
    """Content of sources and stages by name, each loaded when first asked for."""

    def __init__(self, sources: Sources, store: Store, stages: Sequence[Stage]) -> None:
        self._sources = sources
        self._store = store
        self._stages = {stage.name for stage in stages}
        self._held: dict[str, Any] = {}

    def load(self, name: str) -> Any:
        """Give the result of a stage or the content of a source."""
        if name not in self._stages:
            return self._sources.load(name)
        if name not in self._held:
            self._held[name] = self._store.load(name)
        return self._held[name]

    def keep(self, name: str, noun: Any) -> None:
        """Hold a fresh result so that it need not be read back."""
        self._held[name] = noun


def fingerprints(
    stages: Sequence[Stage], sections: Mapping[str, Section | None], sources: Sources
) -> dict[str, str]:
    """Fingerprint that every result must have to be current."""
    wanted: dict[str, str] = {}
    for stage in stages:
        section = sections[stage.name]
        settings = (
            section.model_dump(mode="json", exclude=set(stage.elsewhere)) if section else None
        )
        read = [
            wanted[name] if name in wanted else sources.fingerprint(name) for name in stage.reads
        ]
        wanted[stage.name] = fingerprint(code_fingerprint(), stage.name, settings, read)
    return wanted


def stages_until(stages: Sequence[Stage], last: str | None) -> tuple[Stage, ...]:
    """Cut the list after a stage.

    Raises
    ------
    ConfigError
        If there is no such stage.
    """
    if last is None:
        return tuple(stages)
    names = [stage.name for stage in stages]
    if last not in names:
        raise ConfigError(f"expected a stage ({', '.join(names)}), got {last!r}")
    return tuple(stages[: names.index(last) + 1])


def dependents(stages: Sequence[Stage], first: str) -> set[str]:
    """Name a stage and all that read it, directly or not."""
    reached = {first}
    for stage in stages:
        if reached.intersection(stage.reads):
            reached.add(stage.name)
    return reached


def run_stages(
    stages: Sequence[Stage],
    sections: Mapping[str, Section | None],
    results: Results,
    store: Store,
    outdated: Mapping[str, str],
    listener: Listener,
) -> None:
    """Run the stages named in `outdated` (name -> fingerprint) in order and store each result.

    One is stored while the next runs; whatever ends the run, what is finished is stored.
    """
    with ThreadPoolExecutor(1) as beside:
        stored: Future[None] | None = None
        for stage in stages:
            if stage.name not in outdated:
                listener(Event(stage.name, "kept"))
                continue
            listener(Event(stage.name, "started"))
            begin = time.perf_counter()
            read = [results.load(name) for name in stage.reads]
            noun = stage.run(*read, sections[stage.name])
            seconds = time.perf_counter() - begin
            if stored:
                stored.result()  # a full disk ends the run here
            recipe = outdated[stage.name]
            stored = beside.submit(
                store.save, stage.name, noun, fingerprint=recipe, seconds=seconds
            )
            results.keep(stage.name, noun)
            _log.info("%s: %.2f s", stage.name, seconds)
            listener(Event(stage.name, "finished", seconds))
        if stored:
            stored.result()


def outdated_stages(
    stages: Sequence[Stage], wanted: Mapping[str, str], store: Store, forced: set[str]
) -> dict[str, str]:
    """Choose the stages whose stored result is absent, of another recipe, or forced."""
    return {
        stage.name: wanted[stage.name]
        for stage in stages
        if stage.name in forced or store.fingerprint(stage.name) != wanted[stage.name]
    }
