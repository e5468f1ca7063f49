"""Runs by a real dask.distributed cluster of processes: whatever happens, the same bytes."""

import json
import os
import signal
import socket
import threading
import time

import numpy as np
import pytest
from distributed import Client, LocalCluster
from run_models import Failing, plain, points, slow, square

import kneecore
from kneecore import ModelError, ParameterError, SamplingSettings
from kneecore.runs import cluster as cluster_module

# What distributed and its server leave open, and what it says of its own ports, is theirs.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::UserWarning:distributed"),
]
X = points(200)


def started():
    return LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=100,
    )


@pytest.fixture(scope="module")
def cluster():
    with started() as cluster:
        yield cluster


@pytest.fixture
def made(cluster):
    """Return `square` with the cluster's workers."""
    models = []

    def make(run, **options):
        models.append(square(run, workers=cluster.scheduler_address, **options))
        return models[-1]

    yield make
    for model in models:
        model.close()


def when_written(file, n_lines, do):
    """Do something as soon as a file has some lines."""

    def wait():
        while not (file.exists() and file.read_bytes().count(b"\n") > n_lines):
            time.sleep(0.01)
        do()

    threading.Thread(target=wait, daemon=True).start()


def kill_one(cluster):
    os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)


def test_the_same_bytes_as_here(made):
    np.testing.assert_array_equal(made(slow).evaluate(X), square().evaluate(X))


def test_a_killed_worker_costs_time_only(made, cluster, tmp_path):
    """Each run leaves a line; those of the killed worker's chunk alone may be there twice."""
    log = tmp_path / "runs"

    def run(x):
        with open(log, "a") as file:
            file.write(f"{x[0]!r}\n")
        return slow(x)

    model = made(run, keep=tmp_path / "kept")
    before = {worker.pid for worker in cluster.workers.values()}
    when_written(log, 30, lambda: kill_one(cluster))
    done = model.examine(X)
    np.testing.assert_array_equal(done.y, [plain(x) for x in X])
    assert done.counts == {"failed": 0, "reused": 0}
    assert {worker.pid for worker in cluster.workers.values()} != before
    lines = log.read_text().split()
    assert set(lines) == {repr(value) for value in X[:, 0]}
    assert len(lines) < len(X) + 60
    assert (tmp_path / "kept").read_bytes().count(b"\n") == 1 + len(X)


def test_runs_that_crash_or_hang_take_no_worker_along(made, cluster):
    before = {worker.pid for worker in cluster.workers.values()}
    for how, kind in (("dies", "died"), ("hangs", "timed out"), ("raises", "raised")):
        model = made(Failing(how, above=0.97), timeout_s=0.3 if how == "hangs" else None)
        bad = X[:, 0] > 0.97
        assert (np.isnan(model.evaluate(X)).all(axis=1) == bad).all()
        assert {f.kind for f in model.failures} == {kind}
        assert len(model.failures) == np.count_nonzero(bad) >= 3
    assert {worker.pid for worker in cluster.workers.values()} == before


def test_many_knees_less_one_worker(cluster):
    """Here fewer of them: `tests/benchmarks/million.py` does a million."""
    settings = SamplingSettings(n_samples=16_000)
    knee = kneecore.Knee(workers=cluster.scheduler_address)
    killed = []

    def callback(report):
        if report.done > 3000 and not killed:
            killed.append(kill_one(cluster))

    there = kneecore.monte_carlo(knee, settings, callback=callback)
    here = kneecore.monte_carlo(kneecore.Knee(), settings)
    assert killed
    assert there.counts == here.counts
    assert there.n_samples == 16_000
    np.testing.assert_array_equal(there.y.mean, here.y.mean)
    np.testing.assert_array_equal(there.y.percentile_lower, here.y.percentile_lower)
    knee.close()


def test_an_executor_of_dask_is_an_executor(cluster):
    with Client(cluster.scheduler_address, set_as_default=False) as client:
        executor = client.get_executor(pure=False)
        model = square(slow, workers=executor)
        np.testing.assert_array_equal(model.evaluate(X[:50]), [plain(x) for x in X[:50]])


def test_a_run_is_cancelled_in_its_midst(made):
    began = time.monotonic()
    with pytest.raises(kneecore.Cancelled):
        made(Failing("hangs", above=-1.0), timeout_s=3.0).examine(
            X, watch=lambda done: time.monotonic() - began > 0.5
        )
    assert time.monotonic() - began < 3.0


def test_a_model_that_cannot_be_sent_or_loaded(made):
    lock = threading.Lock()
    with pytest.raises(ParameterError, match="the model cannot be sent to another process"):
        made(lambda x: lock and plain(x)).evaluate(X)


def test_a_scheduler_that_goes_away(tmp_path):
    """What was done until then is kept; the study goes on with another scheduler."""
    keep = tmp_path / "runs"
    gone = started()
    model = square(slow, workers=gone.scheduler_address, keep=keep)
    address = gone.scheduler_address
    when_written(keep, 20, gone.close)
    with pytest.raises(ModelError) as error:
        model.evaluate(points(2000))
    assert str(error.value) == f"the scheduler at {address} has gone"
    model.close()
    n_kept = keep.read_bytes().count(b"\n") - 1
    assert 20 <= n_kept < 2000
    kept = [json.loads(line)["x"] for line in keep.read_text().splitlines()[1:]]
    again = square(slow, keep=keep)
    assert again.examine(np.array(kept)).counts["reused"] == n_kept
    again.close()


def test_a_scheduler_that_is_not_there(monkeypatch):
    monkeypatch.setattr(cluster_module, "CONNECT_S", 0.5)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(ModelError) as error:
            square(workers=address).evaluate(X)
    assert str(error.value) == f"no scheduler answers at {address} (Connection refused)"


def test_a_scheduler_without_workers(monkeypatch):
    monkeypatch.setattr(cluster_module, "CONNECT_S", 0.5)
    with (
        LocalCluster(
            n_workers=0, processes=True, dashboard_address=None, silence_logs=100
        ) as empty,
        pytest.raises(ModelError, match="has no workers; start some with `dask worker tcp"),
    ):
        square(workers=empty.scheduler_address).evaluate(X)
