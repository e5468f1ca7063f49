"""Runs by other processes, and by executors of others: the same bytes, and nothing lost."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from run_models import Failing, many, plain, points, slow, square

import kneecore
from kneecore import Cancelled, ModelError, ParameterError, SamplingSettings

X = points(60)
BAD = X[:, 0] > 0.8


@pytest.fixture
def made():
    """Return `square`, whose models are let go at the end."""
    models = []

    def make(*args, **options):
        models.append(square(*args, **options))
        return models[-1]

    yield make
    for model in models:
        model.close()


def alive(marker):
    """Return the processes whose command has `marker` in it."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            command = (folder / "cmdline").read_bytes()
            state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            continue
        if marker.encode() in command and state != "Z":
            found.append(int(folder.name))
    return found


def gone(marker, within_s=10.0):
    """Tell whether the processes with `marker` are gone, now or soon."""
    ended = time.monotonic() + within_s
    while alive(marker) and time.monotonic() < ended:
        time.sleep(0.02)
    return not alive(marker)


@pytest.mark.parametrize("run", [plain, slow])
def test_the_same_bytes_as_here(made, run):
    np.testing.assert_array_equal(made(run, workers=2).evaluate(X), made(run).evaluate(X))


def test_workers_stay_for_the_next_points(made):
    def run(x):
        return [float(os.getpid()), x[0]]

    model = made(run, workers=2)
    first, second = (set(model.evaluate(X)[:, 0]) for _ in range(2))
    assert first == second
    assert len(first) == 2
    assert os.getpid() not in first


def test_functions_that_have_no_name_can_be_sent(made):
    factor = np.array([2.0, 3.0])
    there, here = (made(lambda x: factor * x, workers=w).evaluate(X) for w in (2, None))
    np.testing.assert_array_equal(there, here)


def test_a_batched_function_is_given_many_points(made):
    x = points(3000)
    there = made(many, batched=True, workers=2).evaluate(x)
    np.testing.assert_array_equal(there, many(x))


def test_the_knee_elsewhere_is_the_knee_here():
    settings = SamplingSettings(n_samples=5000)
    knee = kneecore.Knee(workers=2)
    there, here = (kneecore.monte_carlo(k, settings) for k in (knee, kneecore.Knee()))
    np.testing.assert_array_equal(there.y.sd, here.y.sd)
    assert there.counts == here.counts
    for name, spread in here.observed.items():
        np.testing.assert_array_equal(there.observed[name].sigma_upper, spread.sigma_upper)
    # Other bounds are other knees, by the same workers.
    wide, usual = (k.with_size(2.0).evaluate(k.nominal[None]) for k in (knee, kneecore.Knee()))
    np.testing.assert_array_equal(wide, usual)
    knee.close()


@pytest.mark.parametrize(
    ("how", "kind", "message"),
    [
        ("dies", "died", "ended its process (exit code 3)"),
        ("hangs", "timed out", "took longer than 0.2 s"),
    ],
)
def test_a_run_that_takes_its_process_along_is_marked(made, how, kind, message):
    model = made(Failing(how, above=0.95), workers=2, timeout_s=0.2 if how == "hangs" else None)
    y = model.evaluate(X)
    bad = X[:, 0] > 0.95
    np.testing.assert_array_equal(y[~bad], [plain(x) for x in X[~bad]])
    assert np.isnan(y[bad]).all()
    assert [f.number for f in model.failures] == (np.flatnonzero(bad) + 1).tolist()
    assert {(f.kind, f.message) for f in model.failures} == {(kind, message)}
    assert len(model.failures) >= 2


def test_a_time_out_needs_no_number_of_workers(made):
    model = made(Failing("hangs", above=0.97), timeout_s=0.3)
    assert np.isnan(model.evaluate(X)).all(axis=1).tolist() == (X[:, 0] > 0.97).tolist()


def test_a_batch_that_dies_is_looked_at_row_by_row(made):
    def run(x):
        if (x[:, 0] > 0.95).any():
            os._exit(1)
        return many(x)

    model = made(run, batched=True, workers=1)
    assert (np.isnan(model.evaluate(X)).all(axis=1) == (X[:, 0] > 0.95)).all()


def test_a_run_that_died_is_tried_again(made, tmp_path):
    def run(x):
        mark = tmp_path / x.tobytes().hex()
        if x[0] > 0.9 and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return plain(x)

    model = made(run, workers=2, retries=1)
    done = model.examine(X)
    np.testing.assert_array_equal(done.y, [plain(x) for x in X])
    assert done.counts == {"failed": 0, "retried": np.count_nonzero(X[:, 0] > 0.9)}
    model = made(lambda x: os.kill(os.getpid(), signal.SIGKILL), workers=1, retries=1)
    with pytest.raises(ModelError, match=r"run 3 ended its process \(signal SIGKILL\); all of the"):
        model.evaluate(X)
    assert {f.tries for f in model.failures} == {2}


def test_what_a_run_has_started_ends_with_it(made):
    marker = f"61.{os.getpid()}"

    def run(x):
        subprocess.run(["sleep", marker], check=False)
        return plain(x)

    with pytest.raises(ModelError, match=r"took longer than 0\.3 s; all of the first 3 runs"):
        made(run, workers=1, timeout_s=0.3).evaluate(X[:4])
    assert gone(marker)


def test_workers_end_with_who_has_started_them(tmp_path):
    marker = f"62.{os.getpid()}"
    code = f"""
import sys; sys.path.insert(0, {os.path.dirname(__file__)!r} + "/..")
import subprocess
from run_models import square, points
square(lambda x: subprocess.run(["sleep", "{marker}"]) and x, workers=2).evaluate(points(9))
"""
    process = subprocess.Popen([sys.executable, "-c", code])
    ended = time.monotonic() + 30
    while len(alive(marker)) < 2:
        assert time.monotonic() < ended
        time.sleep(0.05)
    process.kill()
    process.wait()
    assert gone(marker)


def test_what_a_model_prints_is_no_answer(made, capfd):
    def run(x):
        print("iteration 1")
        os.write(1, b"iteration 2\n")
        return plain(x)

    np.testing.assert_array_equal(made(run, workers=1).evaluate(X[:5]), [plain(x) for x in X[:5]])
    printed = capfd.readouterr()
    assert printed.out == ""
    assert printed.err.count("iteration 2") == 5


def test_a_model_that_cannot_be_sent(made):
    lock = threading.Lock()

    def run(x):
        with lock:
            return plain(x)

    with pytest.raises(ParameterError) as error:
        made(run, workers=2).evaluate(X)
    assert str(error.value).startswith("the model cannot be sent to another process (TypeError: ")
    assert "\n" not in str(error.value)


class Unloadable:
    """Cannot be loaded where it comes to."""

    def __call__(self, x):
        return plain(x)

    def __reduce__(self):
        return (__import__, ("no_such_module",))


def test_a_model_that_cannot_be_loaded(made):
    with pytest.raises(ModelError, match=r"a worker process cannot load the model .*no_such_mod"):
        made(Unloadable(), workers=2).evaluate(X)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_watch_cancels_in_the_midst_of_a_run(made, workers):
    model = made(Failing("hangs", above=-1.0), workers=workers)
    began = time.monotonic()
    with pytest.raises(Cancelled):
        model.examine(X, watch=lambda done: time.monotonic() - began > 0.5)
    assert time.monotonic() - began < 5.0
    assert made(slow, workers=workers).evaluate(X[:3]).shape == (3, 2)


def test_sampling_that_is_cancelled_keeps_what_was_done(made):
    study = kneecore.monte_carlo(
        made(slow, workers=2),
        SamplingSettings(n_samples=5000),
        callback=lambda report: report.done >= 20,
    )
    assert study.stop_reason == "cancelled"
    assert 2 <= study.n_samples < 200
    whole = np.random.default_rng(0).random((5000, 2))[: study.n_samples] * [1.0, 2.0]
    np.testing.assert_allclose(study.y.mean[0], whole.sum(axis=1).mean(), rtol=1e-12)


class OnlyMaps:
    """An executor that can map, and nothing else."""

    def __init__(self):
        self.sizes = []

    def map(self, function, given):
        given = list(given)
        self.sizes.append(len(given))
        return [function(one) for one in given]


def executors():
    spawn = multiprocessing.get_context("spawn")
    yield "threads", lambda: ThreadPoolExecutor(2)
    yield "processes", lambda: ProcessPoolExecutor(2, mp_context=spawn)
    yield "a pool", lambda: spawn.Pool(2)
    yield "only maps", OnlyMaps


@pytest.mark.parametrize("make", [m for _, m in executors()], ids=[n for n, _ in executors()])
def test_any_executor(made, make):
    executor = make()
    model = made(Failing("raises"), workers=executor)
    y = model.evaluate(X)
    np.testing.assert_array_equal(y[~BAD], [plain(x) for x in X[~BAD]])
    assert len(model.failures) == np.count_nonzero(BAD)
    for end in ("shutdown", "terminate"):
        getattr(executor, end, lambda: None)()
    if hasattr(executor, "join"):
        executor.join()


def test_a_broken_executor_is_told_in_a_line(made):
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as executor, pytest.raises(ModelError) as error:
        made(Failing("dies"), workers=executor).evaluate(X)
    assert str(error.value).startswith("the executor is broken: a run has ended its process (Brok")
    assert str(error.value).endswith("such a run is marked and the others go on")


def test_a_time_out_in_somebody_elses_executor(made):
    with ThreadPoolExecutor(2) as executor:
        model = made(Failing("hangs", above=0.97), workers=executor, timeout_s=0.3)
        assert (np.isnan(model.evaluate(X)).all(axis=1) == (X[:, 0] > 0.97)).all()
        assert {f.kind for f in model.failures} == {"timed out"}
