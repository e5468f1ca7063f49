"""Undo, redo, start over and the kept state of a model's page, in the real server."""

import json
import re
import threading

import models
import pytest
from viz.conftest import eventually

from kneecore import FileFormatError
from kneeviz.anymodel import saved, state
from kneeviz.anymodel.actions import inputs
from kneeviz.anymodel.actions.table import ACTIONS
from kneeviz.anymodel.runs import ModelRuns
from kneeviz.jobs.messages import Asked
from kneeviz.server.app import App
from kneeviz.views import theme
from kneeviz.views.tabs.change import REDO, START_OVER, UNDO

CRANK, ROD, OFFSET = range(3)
MODEL = models.slider_crank()


@pytest.fixture(scope="module", autouse=True)
def fast():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(state, "FAST_SECONDS", 5.0)  # fast also where the machine is busy
        patch.setattr(inputs, "LEARNS_BY_ITSELF_SECONDS", 0.0)
        patch.setitem(ACTIONS, "tell", lambda page, event: event.set())
        yield


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("state") / "state.json"


@pytest.fixture(scope="module")
def app(path):
    running = App(port=0, model=MODEL, state=path)
    eventually(lambda: running.page.state.nominal is not None)
    yield running
    running.stop()


@pytest.fixture
def page(app):
    """The page as it began, with nothing to undo."""
    page = app.page
    page.post("start_over", None)
    settled(page)
    page.view.search.first.value, page.view.search.more.value = 5, 2  # a search is soon over
    page.begin()
    return page


def do(page, key, value=True):
    """Do something as a visitor, one step of its own; return the state's text."""
    page.history.rest()
    page.post(key, Asked(None, 1, value))
    return settled(page)


def settled(page):
    """Wait until all that was asked is done and noted; return the state's text."""
    done = threading.Event()
    page.post("tell", done)
    assert done.wait(60.0)
    return saved.to_text(page.history.present, MODEL)


def changed(page):
    """Change everything that can be, a step each; return the state's text after each."""
    texts = [do(page, ("input", ROD), 121.0), do(page, ("input", ROD), 119.0)]
    page.view.search.seed.value = 3
    texts.append(do(page, ("setting", "search.seed"), 3))
    page.post("search", Asked(None, 1, True))
    eventually(lambda: page.state.result is not None)
    texts.append(settled(page))
    texts.append(do(page, "overlay", False))
    texts.append(do(page, "band", False))
    texts.append(do(page, "column", page.view.study.height.options[2]))
    return texts


def test_all_changes_are_undone_and_done_again_to_the_same_text(page):
    began = settled(page)
    texts = [began, *changed(page)]
    assert len(set(texts)) == len(texts)
    for text in texts[-2::-1]:
        assert do(page, "change", UNDO) == text
    assert not page.view.search.overlay.visible
    assert page.view.search.found.content == ""
    assert page.view.files.result["result.json"].disabled
    for text in texts[1:]:
        assert do(page, "change", REDO) == text
    assert page.view.inputs.sliders[ROD].value == 119.0
    assert do(page, "change", START_OVER) == began
    assert "Started over" in page.view.running.status.content
    assert do(page, "change", UNDO) == texts[-1]
    assert "Undo: inputs, settings, result" in page.view.running.status.content


def test_a_server_that_starts_again_opens_as_it_was_left(page, path, tmp_path):
    left = changed(page)[-1]
    eventually(lambda: path.read_text() == left)
    copy = tmp_path / "state.json"
    copy.write_text(left)
    again = App(port=0, model=MODEL, state=copy)
    try:
        opened = again.page
        assert saved.to_text(opened.snapshot(), MODEL) == left
        assert opened.view.search.seed.value == 3
        assert opened.view.files.result["result.json"].disabled is False
        eventually(lambda: opened.state.is_here and opened.state.nominal is not None)
        began = saved.to_text(opened.history.start, MODEL)
        assert do(opened, "change", UNDO) == began
    finally:
        again.stop()
    assert copy.read_text() == began  # the last state is written before the server ends


def test_nothing_takes_the_place_of_the_nominal_run(page, tmp_path, monkeypatch):
    copy, asked = tmp_path / "state.json", []
    copy.write_text(changed(page)[-1])
    monkeypatch.setattr(ModelRuns, "ask", lambda _runs, x: asked.append(x))
    again = App(port=0, model=MODEL, state=copy)
    try:
        do(again.page, ("input", ROD), 121.0)
        assert again.page.state.x[ROD] == 121.0
    finally:
        again.stop()
    assert [x.tolist() for x in asked] == [MODEL.nominal.tolist()]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"schema": "kneeviz.state/1"}, "'kneeviz.model-state/1' is allowed"),
        ({"inputs": {"crank": 50.0}}, "`inputs` must name those"),
        ({"inputs": {"crank": 50.0, "rod": "long", "offset": 0.0}}, "must be numbers"),
        ({"inputs": {"crank": 50.0, "rod": 1e9, "offset": 0.0}}, "`inputs.rod` is beyond"),
        ({"output": 10_000}, "`output`"),
        ({"band": 1}, "`band`"),
        ({"settings": {"search.seed": -1}}, "search.seed: -1 is outside"),
        ({"more": 1}, "'more'"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_what_is_no_state_of_this_model_is_refused_in_a_line(page, tmp_path, change, why):
    document = json.loads(settled(page)) | change
    del document["digest"]
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(document))
    with pytest.raises(FileFormatError, match=re.escape(why)) as told:
        App(port=0, model=MODEL, state=bad)
    assert "\n" not in str(told.value)


def test_class_size_enlarges_texts_and_charts(page):
    do(page, ("toggle", "large"))
    eventually(lambda: page.view.class_size.content == theme.large_text())
    assert page.view.large_box.value
    assert page.view.colours.size == theme.CLASS_SIZE
    do(page, ("toggle", "large"))
    eventually(lambda: page.view.class_size.content == "")
    assert page.view.colours.size == 1.0
