"""The door to Dask: workers on this machine, or those of a scheduler elsewhere."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

from shapemorph.config import ClusterConfig
from shapemorph.core.errors import ConfigError

_WAIT_SECONDS = 30
_ANSWER_SECONDS = 10
_GIGABYTE = 1e9
_SHARE_OF_MEMORY = 0.9  # the rest is for the parent and the system
_THREAD_VARIABLES = (
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"),
    *("OPENCV_FOR_THREADS_NUM", "LP_NUM_THREADS", "VTK_SMP_MAX_THREADS"),
)

Payload = dict[str, Any]
Listener = Callable[[Payload], None]


@dataclass(frozen=True, slots=True)
class Crew:
    """Who works, and how much each may take.

    Attributes
    ----------
    address : str
        Of a scheduler; empty: workers of this process.
    workers : int
        Of a scheduler elsewhere: those that were there at the start.
    threads : int or None
        Of each case; None: as its worker was started.
    memory : float or None
        Most bytes of each worker; None: as it was started.
    attempts : int
        Times that a case is tried whose worker dies.
    """

    address: str
    workers: int
    threads: int | None
    memory: float | None
    attempts: int

    def __str__(self) -> str:
        workers = f"{self.workers} worker" + ("s" if self.workers > 1 else "")
        if self.address:
            return f"{workers} of {self.address}"
        assert self.memory is not None
        threads = f"{self.threads} thread" + ("s" if self.threads != 1 else "")
        return f"{workers}, each {threads} and at most {self.memory / _GIGABYTE:.3g} GB"


def plan_crew(config: ClusterConfig, cases: int) -> Crew:
    """Share the cores and the memory of this machine among workers.

    Raises
    ------
    ConfigError
        If Dask is not installed.
    """
    _require_dask()
    from dask.system import CPU_COUNT
    from distributed.system import MEMORY_LIMIT

    workers = min(config.workers or CPU_COUNT, cases)
    memory = _SHARE_OF_MEMORY * MEMORY_LIMIT / workers
    if config.memory_gb is not None:
        memory = config.memory_gb * _GIGABYTE
    threads = config.threads or max(1, CPU_COUNT // workers)
    return Crew("", workers, threads, memory, config.attempts)


class Cluster:
    """Runs functions of one payload each on the workers of a crew."""

    def __init__(self, client: Any, crew: Crew) -> None:
        self.crew = crew
        self._client = client

    def run(
        self,
        work: Callable[[Payload], Payload],
        payloads: Mapping[str, Payload],
        listener: Listener,
    ) -> Iterator[tuple[str, Payload | Exception]]:
        """Call `work` with every payload and yield results as they come.

        Parameters
        ----------
        work : callable
            Importable on the workers; called with its payload, which gets a key ``topic``
            to :func:`tell` under.
        payloads : mapping of str to dict
            JSON-able, by name.
        listener : callable
            Gets, in another thread, what workers tell.

        Yields
        ------
        name : str
        result : dict or Exception
            The exception that `work` raised or that ended its worker.
        """
        from distributed import as_completed

        topic = f"shapemorph-{uuid4().hex}"
        self._client.subscribe_topic(topic, lambda event: listener(event[1]))
        names = {}
        for name, payload in payloads.items():
            told = {**payload, "topic": topic}
            key = f"case-{uuid4().hex}"  # one prefix, so that the scheduler deals them out evenly
            names[self._client.submit(work, told, key=key, pure=False)] = name
        for future in as_completed(list(names)):
            failure = future.exception()
            yield names[future], future.result() if failure is None else failure
        self._client.unsubscribe_topic(topic)


def tell(topic: str, message: Payload) -> None:
    """Say something from a worker to who started it; nobody listens outside of a worker."""
    from distributed import get_worker

    with suppress(ValueError):
        get_worker().log_event(topic, message)


@contextmanager
def local_cluster(crew: Crew) -> Iterator[Cluster]:
    """Start workers on this machine; they end with the block, and when this process dies."""
    _require_dask()
    from distributed import Client, LocalCluster

    with (
        _dask_settings(crew),
        LocalCluster(
            n_workers=crew.workers,
            threads_per_worker=1,
            processes=True,
            memory_limit=int(crew.memory or 0),
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield Cluster(client, crew)


@contextmanager
def remote_cluster(address: str, config: ClusterConfig) -> Iterator[Cluster]:
    """Use the workers of a scheduler.

    Raises
    ------
    ConfigError
        If Dask is not installed, none answers, or it has no workers.
    """
    _require_dask()
    from distributed import Client

    try:
        client = Client(address, timeout=_ANSWER_SECONDS)
    except (OSError, ValueError, TimeoutError) as error:
        raise ConfigError(
            f"--scheduler {address}: expected a Dask scheduler (tcp://host:8786), got {error}"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_WAIT_SECONDS)
        except TimeoutError as error:
            raise ConfigError(
                f"--scheduler {address}: no worker within {_WAIT_SECONDS} s: start some with "
                f"`dask worker {address} --nthreads 1`"
            ) from error
        workers = len(client.nthreads())
        yield Cluster(client, Crew(address, workers, config.threads, None, config.attempts))


def dask_setup(worker: object) -> None:  # noqa: ARG001 - the name and argument that Dask looks for
    """Leave interrupts to the parent, which then ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def limit_threads(threads: int | None) -> None:
    """Limit what runs in this thread of a worker that was started by others."""
    if threads is None:
        return
    import cv2
    import numba

    cv2.setNumThreads(threads)
    numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))


@contextmanager
def _dask_settings(crew: Crew) -> Iterator[None]:
    """Set what Dask reads when workers start, also in them."""
    import dask

    threads = {name: str(crew.threads) for name in _THREAD_VARIABLES}
    settings = {
        "distributed.nanny.pre-spawn-environ": threads | _inherited_environment(),
        "distributed.scheduler.allowed-failures": crew.attempts - 1,
        "distributed.scheduler.worker-saturation": 1.0,
        "distributed.scheduler.worker-ttl": None,
        "distributed.worker.preload": [__name__],
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.limit": "1h",
        "logging": {"distributed": "critical"},
    }
    before = {name: os.environ.get(name) for name in (*threads, *_inherited_environment())}
    try:
        with dask.config.set(settings):
            yield
    finally:  # what is set for workers is set here, too, when they start
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _inherited_environment() -> dict[str, str]:
    """Give what Dask would otherwise set by itself."""
    return {"MALLOC_TRIM_THRESHOLD_": os.environ.get("MALLOC_TRIM_THRESHOLD_", "65536")}


def _require_dask() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise ConfigError(
            "batch needs Dask, which is not installed: pip install 'shapemorph[batch]'"
        ) from error
