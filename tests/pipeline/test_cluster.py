"""Workers of this machine: their threads, what they tell, and what their death does."""

import os
import signal
import sys

import pytest

from shapemorph.config import ClusterConfig
from shapemorph.core.errors import ConfigError
from shapemorph.pipeline.cluster import Crew, local_cluster, plan_crew, remote_cluster, tell

pytest.importorskip("distributed", reason="Dask is not installed")


def test_workers_share_cores_and_memory(monkeypatch):
    monkeypatch.setattr("dask.system.CPU_COUNT", 8)
    monkeypatch.setattr("distributed.system.MEMORY_LIMIT", 40e9)
    assert plan_crew(ClusterConfig(), 20) == Crew("", 8, 1, pytest.approx(4.5e9), 2)
    assert plan_crew(ClusterConfig(), 2) == Crew("", 2, 4, pytest.approx(18e9), 2)
    assert plan_crew(ClusterConfig(workers=3), 20).threads == 2
    given = plan_crew(ClusterConfig(workers=16, threads=2, memory_gb=1.5, attempts=5), 20)
    assert given == Crew("", 16, 2, 1.5e9, 5)
    assert str(given) == "16 workers, each 2 threads and at most 1.5 GB"


def test_without_dask_the_message_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigError, match=r"pip install 'shapemorph\[batch\]'"):
        plan_crew(ClusterConfig(), 2)


def test_what_is_no_scheduler_is_refused(monkeypatch):
    monkeypatch.setattr("shapemorph.pipeline.cluster._ANSWER_SECONDS", 1)
    with pytest.raises(ConfigError, match=r"tcp://127\.0\.0\.1:9: expected a Dask scheduler"):
        remote_cluster("tcp://127.0.0.1:9", ClusterConfig()).__enter__()


@pytest.mark.slow
def test_a_deadly_case_ends_no_other_and_threads_are_limited(tmp_path):
    def work(payload):
        if payload["deadly"]:
            with (tmp_path / "deaths").open("a") as stream:
                stream.write("x")
            os.kill(os.getpid(), signal.SIGKILL)
        tell(payload["topic"], {"case": payload["name"]})
        names = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "LP_NUM_THREADS")
        return {"threads": [os.environ[name] for name in names], "process": os.getpid()}

    told = []
    payloads = {name: {"name": name, "deadly": name == "b"} for name in "abcd"}
    before = os.environ.get("NUMBA_NUM_THREADS")
    with local_cluster(Crew("", 2, 3, 2e9, 2)) as cluster:
        found = dict(cluster.run(work, payloads, told.append))
    assert os.environ.get("NUMBA_NUM_THREADS") == before
    assert type(found.pop("b")).__name__ == "KilledWorker"
    assert (tmp_path / "deaths").read_text() == "xx"
    assert [result["threads"] for result in found.values()] == [["3", "3", "3"]] * 3
    assert os.getpid() not in {result["process"] for result in found.values()}
    assert {message["case"] for message in told} == set("acd")


@pytest.mark.slow
def test_a_worker_beyond_its_memory_is_ended_and_its_case_has_the_reason():
    def work(payload):
        held = [bytearray(b"x" * 50_000_000) for _ in range(payload["blocks"])]
        import time

        time.sleep(2.0 if len(held) > 10 else 0.0)
        return {"blocks": len(held)}

    payloads = {"small": {"blocks": 1}, "large": {"blocks": 40}}
    with local_cluster(Crew("", 1, 1, 0.8e9, 1)) as cluster:
        found = dict(cluster.run(work, payloads, lambda _: None))
    assert found["small"] == {"blocks": 1}
    assert type(found["large"]).__name__ == "KilledWorker"
