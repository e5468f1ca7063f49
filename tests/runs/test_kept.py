"""Runs that are kept: a killed study goes on from them, to the same bytes."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from run_models import Failing, many, points, square

import kneecore
from kneecore import FileFormatError, OutputError, SamplingSettings
from kneecore.record import recording
from kneecore.runs.log import RunLog
from kneecore.runs.part import Trouble

X = points(30)


def test_what_was_done_is_not_done_again(tmp_path):
    file = tmp_path / "runs.jsonl"
    y = square(keep=file).examine(X)
    assert y.counts == {"failed": 0, "reused": 0}
    head, *lines = file.read_text().splitlines()
    assert json.loads(head)["schema"] == "kneecore.runs/1"
    assert [json.loads(line)["x"] for line in lines] == X.tolist()
    again = square(keep=file)
    more = np.vstack([points(5, seed=1), X])
    done = again.examine(more)
    assert done.counts == {"failed": 0, "reused": len(X) + 1}  # the first point is in both
    np.testing.assert_array_equal(done.y[5:], y.y)
    assert len(file.read_text().splitlines()) == 1 + len(X) + 4


@pytest.mark.parametrize("workers", [None, 2])
@pytest.mark.parametrize("how", ["raises", "nan"])
def test_failures_are_kept_with_their_reason(tmp_path, how, workers):
    file = tmp_path / "runs.jsonl"
    first = square(Failing(how), keep=file, workers=workers)
    y = first.evaluate(X)
    first.close()
    again = square(Failing(how), keep=file)
    np.testing.assert_array_equal(again.evaluate(X), y)
    told = [(f.number, f.message, f.tries) for f in first.failures]
    assert [(f.number, f.message, f.tries) for f in again.failures] == told
    assert len(told) > 3
    for failure in first.failures:
        if how == "raises":
            with open(failure.files) as traceback:
                assert "no\nconvergence" in traceback.read()
    again.close()
    anew = square(Failing(how), keep=file, rerun_failures=True).examine(X)
    assert anew.counts["reused"] == len(X) - len(told)


def test_another_models_runs_are_left_alone(tmp_path):
    file = tmp_path / "runs.jsonl"
    first = square(keep=file)
    first.evaluate(X)
    with pytest.raises(OutputError, match="is written by another study; each needs its own file"):
        square(keep=file).evaluate(X)
    first.close()
    other = square(Failing("raises", above=2.0), keep=file)
    assert other.examine(X).counts["reused"] == 0
    other.close()
    assert square(keep=file).examine(X).counts["reused"] == len(X)


@settings(deadline=None, max_examples=40)
@given(
    values=st.lists(st.floats(), min_size=2, max_size=2),
    cut=st.integers(min_value=1, max_value=200),
)
def test_floats_are_exact_and_half_a_line_is_cut_off(tmp_path_factory, values, cut):
    file = str(tmp_path_factory.mktemp("log") / "runs")
    log = RunLog(file, "me")
    x, y = np.array([[0.1, -0.0], [5e-324, 1e308]]), np.array([values, values[::-1]])
    log.add(x, y, {1: Trouble(row=1, kind="nan", message="ü\n")})
    log.close()
    whole = os.path.getsize(file)
    again = RunLog(file, "me")
    np.testing.assert_array_equal(np.array([again.get(p).y for p in x]), y)
    assert np.signbit(again.get(x[0]).y).tolist() == np.signbit(y[0]).tolist() or np.isnan(y).any()
    assert again.get(x[1]).trouble.message == "ü\n"
    assert again.get(np.array([0.1, 0.0])) is None
    again.close()
    os.truncate(file, whole - cut)
    shorter = RunLog(file, "me")
    assert shorter.get(x[1]) is None
    assert shorter.n_damaged == 0
    shorter.add(x[1:], y[1:], {})
    shorter.close()
    assert RunLog(file, "me").get(x[1]) is not None


def test_a_damaged_line_is_left_out(tmp_path):
    file = tmp_path / "runs.jsonl"
    square(keep=file).evaluate(X)
    content = bytearray(file.read_bytes())
    content[content.index(b'"y":[') + 6] ^= 1  # of the first run
    file.write_bytes(content)
    log = RunLog(str(file), "of another model")
    assert (log.n_damaged, log.n_of_others) == (1, len(X) - 1)
    log.close()
    assert square(keep=file).examine(X).counts["reused"] == len(X) - 1


@pytest.mark.parametrize("content", [b"x,y\n1,2\n", b'{"schema":"kneecore.result/1"}\n', b"\xff"])
def test_another_file_is_not_written_to(tmp_path, content):
    file = tmp_path / "mine.csv"
    file.write_bytes(content)
    with pytest.raises(FileFormatError, match=r"mine\.csv is no file of runs"):
        square(keep=file).evaluate(X)
    assert file.read_bytes() == content


def test_a_file_that_cannot_be_written(tmp_path):
    for place in (tmp_path, tmp_path / "no" / "runs"):
        with pytest.raises(OutputError, match="cannot be written"):
            square(keep=place).evaluate(X)


def test_the_result_tells_how_many_runs_were_reused(tmp_path):
    how = kneecore.SearchSettings(training_samples=8, pop_size=20, n_generations=5)
    results = []
    for _ in range(2):
        model = square(keep=tmp_path / "runs.jsonl")
        results.append(kneecore.worst_case(model, how))
        model.close()
    one, two = results
    assert (one.counts["models_reused"], two.counts["models_reused"]) == (0, 11)
    assert two.counts["models_simulated"] == 11
    assert "11 models simulated: 0 failed, 11 reused from the runs that were kept." in str(two)
    np.testing.assert_array_equal(one.x, two.x)
    assert kneecore.SearchResult.from_json(two.to_json()).counts["models_reused"] == 11


def test_a_batched_models_runs_are_kept_by_sampling_too(tmp_path):
    model = square(many, batched=True, keep=tmp_path / "runs.jsonl")
    first = kneecore.monte_carlo(model, SamplingSettings(n_samples=3000))
    again = kneecore.monte_carlo(model, SamplingSettings(n_samples=3000))
    assert (first.counts["reused"], again.counts["reused"]) == (0, 3000)
    np.testing.assert_array_equal(first.y.mean, again.y.mean)
    assert "3000 reused from the runs that were kept" in str(again)


STUDY = """
import sys, kneecore
sys.path.insert(0, {tests!r})
from run_models import square, slow
model = square(slow, keep={file!r}, workers={workers})
study = kneecore.monte_carlo(model, kneecore.SamplingSettings(n_samples=150))
print(study.y.mean.tobytes().hex(), study.y.sd.tobytes().hex(), study.counts["reused"])
"""


@pytest.mark.parametrize("workers", [None, 2])
def test_a_killed_study_goes_on_to_the_same_bytes(tmp_path, workers):
    def start(file):
        code = STUDY.format(tests=os.path.dirname(__file__) + "/..", file=file, workers=workers)
        return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)

    whole = start(str(tmp_path / "whole")).communicate(timeout=60)[0].split()
    killed, file = None, tmp_path / "cut"
    killed = start(str(file))
    ended = time.monotonic() + 60
    while not (file.exists() and file.read_bytes().count(b"\n") > 20):
        assert time.monotonic() < ended
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    n_kept = file.read_bytes().count(b"\n") - 1
    assert 20 <= n_kept < 150
    resumed = start(str(file)).communicate(timeout=60)[0].split()
    assert resumed[:2] == whole[:2]
    assert abs(int(resumed[2]) - n_kept) <= 2  # a worker's last runs may have come meanwhile
    assert file.read_bytes().count(b"\n") == 151


class Memory:
    """A record of steps that are left and taken up again."""

    def __init__(self):
        self.states = {}

    def run(self, what, identity, given, compute):
        return compute()

    def load(self, step):
        return self.states.get(step)

    def save(self, step, state, *, now=False):
        self.states[step] = {name: np.array(values) for name, values in state().items()}


@pytest.mark.parametrize("stop", [100, 2100])
@pytest.mark.parametrize("how", ["raises", "nan"])
def test_sampling_that_was_cancelled_within_a_batch_goes_on_to_the_same_bytes(how, stop):
    asked = SamplingSettings(n_samples=5000)
    memory = Memory()

    def sampled(callback=None):
        with recording(memory):
            return kneecore.monte_carlo(square(Failing(how)), asked, callback=callback)

    whole = kneecore.monte_carlo(square(Failing(how)), asked)
    cut = sampled(lambda report: report.done > stop)
    assert cut.stop_reason == "cancelled"
    assert stop < cut.n_samples < 5000
    assert (cut.n_samples % 2048 > 0) == (stop < 2048)  # in the midst of a batch, or at its end
    again = sampled()
    assert again.counts == whole.counts
    for name in ("mean", "sd", "percentile_lower", "percentile_upper"):
        np.testing.assert_array_equal(getattr(again.y, name), getattr(whole.y, name))
