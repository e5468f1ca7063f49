"""Models that are slow, fail, hang or crash: the page goes on, and says what is wrong."""

import re

import numpy as np
import pytest
import run_models
from viz.conftest import eventually
from viz.visits import press, widget
from viz.websocket_client import WebSocketClient

from kneecore import Input, Model, Output
from kneeviz.anymodel import state
from kneeviz.anymodel.actions import inputs
from kneeviz.jobs.messages import Asked
from kneeviz.server.app import App


@pytest.fixture(autouse=True)
def no_learning(monkeypatch):
    monkeypatch.setattr(inputs, "LEARNS_BY_ITSELF_SECONDS", 0.0)


@pytest.fixture
def open_page(monkeypatch):
    """Return a function that opens a page of the model with a run, and waits for its first run."""
    running = []

    def opened(run):
        if run is not run_models.slowly:  # fast also where the machine is busy
            monkeypatch.setattr(state, "FAST_SECONDS", 5.0)
        running.append(App(port=0, model=run_models.square(run)))
        page = running[-1].page
        eventually(lambda: page.state.seconds is not None)
        return page

    yield opened
    for app in running:
        app.stop()


def said(page):
    return re.sub("<[^>]*>", "", page.view.running.status.content)


def move(page, index, value):
    page.post(("input", index), Asked(None, -1, value))


def test_a_slow_model_runs_when_it_is_asked_to(open_page):
    page = open_page(run_models.slowly)
    port = page.target.get_port()
    with WebSocketClient(port) as visitor:
        visitor.wait(lambda c: c.counts.get("ReplayDoneMessage"))
        eventually(lambda: page.view.running.run.visible)
        assert page.state.slow
        assert "Run the model here (1" in page.view.running.run.label  # 100 ms and a bit
        assert re.search(r"At most 149 runs, 1\d s", page.view.search.cost.content)
        move(page, 0, 0.75)
        eventually(lambda: page.state.x[0] == 0.75 and not page.touched)
        assert page.state.last.x[0] == page.runs._wanted[0] == 0.5
        assert "for other inputs" in page.view.legend.content
        press(visitor, page.view.running.run)
        data = widget(page.view.charts.charts[0].handle)
        visitor.wait(lambda c: np.allclose(c.props[data]["data"][8], [1.75, 0.75]))
        assert np.isnan(visitor.props[data]["data"][4]).all()  # no line that would follow
    assert "Learn a surrogate (50 runs, " in page.view.running.learn.label


def test_learning_is_offered_done_and_can_be_cancelled(open_page):
    page = open_page(run_models.slowly)
    page.post("learn", Asked(None, -1, True))
    eventually(lambda: page.state.job is not None and page.view.running.progress.value > 0.0)
    page.post("run_cancel", None)
    eventually(lambda: page.state.job is None)
    assert page.state.surrogate is None
    eventually(lambda: "cancelled" in said(page))
    assert page.view.running.learn.visible


def test_a_search_that_is_stopped_keeps_its_best_pair(open_page):
    page = open_page(run_models.slowly)
    page.view.search.first.value = 4
    page.post("search", None)
    eventually(lambda: page.state.rising)
    page.post("search_cancel", None)
    eventually(lambda: page.state.result is not None)
    assert page.state.result.stop_reason == "cancelled"
    eventually(lambda: "the best pair until then" in page.view.search.found.content)
    assert len(page.state.surrogate.training_x) == len(page.state.result.training_x)
    n_before = page.state.result.counts["models_simulated"]
    page.view.search.more.value = 2
    page.post("search", None)  # goes on from the runs that were done
    eventually(lambda: page.state.result.stop_reason != "cancelled")
    assert page.state.result.counts["models_reused"] >= min(n_before, 4)
    eventually(lambda: "of them done before" in page.view.search.found.content)


def test_every_kind_of_failure_is_a_line_and_the_last_good_state_stays(open_page):
    page = open_page(run_models.moody)
    assert page.state.last.x[0] == 0.5
    for value, told in (
        (0.15, "raised ValueError: no convergence."),
        (0.25, "ended its process (exit code 3)."),
    ):
        move(page, 0, value)
        eventually(lambda v=value, t=told: t in said(page) and page.state.x[0] == v)
        assert "The last good state stays." in said(page)
        assert page.state.last.x[0] == 0.5
    move(page, 0, 0.6)
    eventually(lambda: page.state.last.x[0] == 0.6)
    eventually(lambda: said(page) == "Ready.")


def test_an_output_that_is_not_a_number_costs_that_output(open_page):
    page = open_page(run_models.moody)
    move(page, 0, 0.05)
    eventually(lambda: "returned NaN or infinity for 1 of 2 outputs" in said(page))
    np.testing.assert_array_equal(page.state.last.y, [np.nan, 1.05])


def test_a_run_that_hangs_is_cancelled_or_gives_way(open_page):
    page = open_page(run_models.moody)
    move(page, 0, 0.9)
    eventually(lambda: "Running the model" in said(page))  # it says so after a second
    page.post("run_cancel", None)
    eventually(lambda: "cancelled; the last one stands" in said(page))
    move(page, 0, 0.95)
    eventually(lambda: "Running the model" in said(page))
    move(page, 0, 0.7)
    eventually(lambda: page.state.last.x[0] == 0.7)


def test_a_model_that_always_fails_has_a_page():
    model = Model(
        run_models.Failing("raises", above=-1.0), run_models.SQUARE, run_models.PAIR, name="lost"
    )
    app = App(port=0, model=model)
    try:
        page = app.page
        eventually(lambda: "raised ValueError: no convergence" in said(page))
        assert "last good state" not in said(page)
        page.post("search", None)
        eventually(lambda: "The search failed" in said(page) and page.state.job is None)
    finally:
        app.stop()


def test_each_visitor_has_sliders_of_his_own_and_leaves_no_process():
    app = App(port=0, model=run_models.square(), shared=False)
    try:
        with (
            WebSocketClient(app.server.get_port()) as one,
            WebSocketClient(app.server.get_port()) as two,
        ):
            eventually(lambda: len(app.sessions) == 2)
            for client in (one, two):
                client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            pages = [session.page for session in app.sessions.values()]
            move(pages[0], 0, 0.75)
            eventually(lambda: pages[0].state.x[0] == 0.75)
            assert pages[1].state.x[0] == 0.5
            eventually(lambda: all(page.state.seconds is not None for page in pages))
            pages[0].post("search", None)
            eventually(lambda: pages[0].state.result is not None)
            engines = [page.runs._model._engine for page in pages]
            engines.append(pages[0].state.model._engine)
            assert all(engine._pool is not None for engine in engines)
        eventually(lambda: not app.sessions)
        eventually(lambda: all(engine._pool is None for engine in engines))
    finally:
        app.stop()


def test_many_outputs_are_shown_one_at_a_time():
    outputs = [Output(f"y_{k}", axis=(1, 2), scale=1.0) for k in range(5)]
    model = Model(lambda x: np.arange(10.0) * x[0], [Input("a", lower=1.0, upper=2.0)], outputs)
    app = App(port=0, model=model)
    try:
        charts = app.page.view.charts
        assert [c.handle.visible for c in charts.charts] == [True] + 4 * [False]
        charts.choice.value = "y_3"
        app.page.post("chart", None)
        eventually(lambda: [c.handle.visible for c in charts.charts].index(True) == 3)
    finally:
        app.stop()
