"""A Dask cluster computes the same as this computer; a worker that dies has its cases redone."""

from __future__ import annotations

import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fowtlib as fw
from fowtlib.cases import Case, run_batch
from fowtlib.cases import cluster as clusters
from fowtlib.cases.statistics import statistics_of
from fowtlib.language.errors import ModelError

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes of one thread each."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
                                  memory_limit=None) as made:  # fmt: skip
        yield made


@pytest.fixture(scope="module")
def plant():
    return fw.load("oc3_spar_rigid").compile()


def spars(count, duration=100.0):
    return [Case(f"s{k}", "oc3_spar_rigid", {"wind.kind": "steady", "wind.mean_speed": 7.0 + 0.1 * k},
                 start="file", duration=duration, output_step=0.5, outputs=("surge", "pitch"))
            for k in range(count)]  # fmt: skip


def same(batch, case, plant):
    alone = plant.simulate(conditions=case.conditions())
    assert np.array_equal(batch.result(case.name).array("surge"), alone.array("surge"))
    assert batch.statistics(case.name) == statistics_of(alone)


def test_a_cluster_computes_the_same_and_a_killed_worker_costs_only_its_cases(tmp_path, cluster, plant):
    cases = [*spars(2), *(replace(case, name=f"long{k}") for k, case in enumerate(spars(2, 3000.0)))]
    with distributed.Client(cluster) as client:
        client.wait_for_workers(2)
        processes, killed = client.run(os.getpid), []

        def kill(progress):
            """Once, a worker that has been given a case."""
            for address, keys in () if killed else client.processing().items():
                if any("long" in str(key) for key in keys):
                    killed.append(address)
                    os.kill(processes[address], signal.SIGKILL)
                    return

        batch = run_batch(cases, tmp_path / "c.batch", cluster=client, progress=kill)
    assert killed and batch.counts["done"] == 4, [row.message for row in batch]
    assert {row.worker for row in batch} - {""} and not list((tmp_path / "c.batch").glob(".here"))
    for case in cases[1:3]:
        same(batch, case, plant)
    assert run_batch(cases, tmp_path / "c.batch", cluster=cluster).counts["done"] == 4


def test_results_come_back_in_pieces_where_no_folder_is_shared(tmp_path, cluster, plant, monkeypatch):
    """The workers look for the folder under another name than it has."""
    monkeypatch.setattr(clusters, "_TOKEN", ".elsewhere")
    monkeypatch.setattr(clusters, "PIECE", 10_000)
    fetched, whole = [], clusters._fetch
    monkeypatch.setattr(clusters, "_fetch", lambda *given: fetched.append(given[2]) or whole(*given))
    batch = run_batch(spars(2), tmp_path / "c.batch", cluster=cluster.scheduler_address)
    assert batch.counts["done"] == 2, [row.message for row in batch]
    same(batch, spars(2)[1], plant)
    assert len(fetched) == 2 and not any(Path(left).exists() for left in fetched)


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("tcp://127.0.0.1:9", "no Dask scheduler answers at tcp://127.0.0.1:9"),
        ("nowhere", "is not the address of a Dask scheduler|no Dask scheduler answers at nowhere"),
        ("tcp://", "is not the address of a Dask scheduler|no Dask scheduler answers"),
        (7, "give the address of a scheduler, a Client or a cluster"),
    ],
)
def test_a_scheduler_that_is_not_there_is_a_sentence(tmp_path, address, message, monkeypatch):
    monkeypatch.setattr(clusters, "_ANSWER", 0.5)
    with pytest.raises(ModelError, match=message):
        run_batch(spars(1), tmp_path / "b.batch", cluster=address)


@pytest.mark.parametrize("address", ["nowhere", "tcp://", "post://here:8786"])
def test_a_wrong_address_makes_no_client(address, monkeypatch):
    import distributed

    monkeypatch.setattr(distributed.Client, "__init__", lambda *_, **__: pytest.fail("a client was made"))
    with pytest.raises(ModelError, match="is not the address of a Dask scheduler"):
        clusters._client(address)


def test_workers_with_another_fowtlib_are_refused(tmp_path, cluster, monkeypatch):
    monkeypatch.setattr(clusters, "version", lambda: "9.9")
    with pytest.raises(ModelError, match="has fowtlib .*, and here is 9.9"):
        run_batch(spars(1), tmp_path / "b.batch", cluster=cluster)
