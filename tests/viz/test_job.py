"""A job: reports, result, cancellation, failure."""

import threading

from kneecore import Cancelled, ModelError, Progress
from kneeviz.jobs.job import Job


def run(work, *, cancel=False):
    posted, done = [], threading.Event()

    def post(key, value):
        posted.append((key, value))
        if key == "study_done":
            done.set()

    job = Job("study", work, post, kind="sampling")
    if cancel:
        job.cancel()
    job.start()
    assert done.wait(10.0)
    return job, posted


def report(done):
    return Progress(stage="sampling", done=done, total=8)


def test_it_reports_and_returns():
    job, posted = run(lambda watch: (watch(report(2)), "found")[1])
    assert posted[0] == ("study_progress", (job, 25.0, "sampling", None, None))
    assert posted[-1] == ("study_done", (job, "found", None))


def test_a_cancelled_one_has_no_result():
    """Whether the work raises, as influence does, or returns what it has, as sampling does."""

    def raises(watch):
        if watch(report(1)):
            raise Cancelled
        return "found"

    for work in (raises, lambda watch: (watch(report(1)), "part")[1]):
        job, posted = run(work, cancel=True)
        assert posted[-1] == ("study_done", (job, None, None))
        job, posted = run(work)
        assert posted[-1][1][1] is not None


def test_a_failure_says_why(caplog):
    def fails(_watch):
        raise ModelError("all failed")

    def breaks(_watch):
        raise ZeroDivisionError("oops")

    assert run(fails)[1][-1][1][1:] == (None, "all failed")
    assert run(breaks)[1][-1][1][1:] == (None, "ZeroDivisionError: oops")
    assert "the study failed" in caplog.text
