"""Undo, redo, start over and the kept state, in the real server."""

import json
import math
import re
import shutil

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, wait_for_result, widget
from viz.websocket_client import WebSocketClient

from kneecore import NAMES, FileFormatError, OutputError, ParameterError, asset_path
from kneeviz.jobs import keeper as keeper_module
from kneeviz.jobs.keeper import Keeper
from kneeviz.server.app import App
from kneeviz.server.kept import KeptState
from kneeviz.state import saved
from kneeviz.views.tabs.change import REDO, START_OVER, UNDO

ACL_Y = NAMES.index("acl_femur_y")
KNEE = asset_path("baseline.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("state") / "state.json"


@pytest.fixture(scope="module")
def app(path):
    running = App(port=0, state=path)
    try:
        eventually(lambda: running.page.exact_ready and running.page.surrogate_ready)
        yield running
    finally:
        running.stop()


@pytest.fixture
def page(app):
    """The page as it began, with nothing to undo."""
    page = app.page
    page.post("start_over")
    eventually(lambda: page.snapshot().same_as(page.history.start))
    settled(page)
    page.begin()
    return page


def settled(page):
    """Wait until what was done is noted; return the state's text."""
    eventually(lambda: page.history.present.same_as(page.snapshot()))
    return saved.to_text(page.history.present)


def change(visitor, page, what):
    press(visitor, page.view.transport.change, what)


class Changes:
    """Ten changes of all kinds; each waits until it is done."""

    def __init__(self, visitor, page):
        self.visitor, self.page, self.tab = visitor, page, page.view.knee

    def all(self):
        return (
            self.slider, self.bound, self.preset, self.setting, self.search, self.case,
            self.upload, self.rest_lengths, self.follow, self.stop_following,
        )  # fmt: skip

    def slider(self):
        self.visitor.set(widget(self.tab.sliders[ACL_Y]), 0.6)
        eventually(lambda: self.page.state.x[ACL_Y] == pytest.approx(0.6e-3))

    def bound(self):
        self.visitor.set(widget(self.tab.bounds["geometry_mm"]), 0.5)
        eventually(lambda: self.page.state.bounds.geometry_mm == 0.5)

    def preset(self):
        press(self.visitor, self.tab.preset, "Random, within bounds")
        eventually(lambda: self.page.state.x[0] != self.page.state.space.baseline[0])

    def setting(self):
        handles = self.page.view.search.options.handles
        self.visitor.set(widget(handles["pop_size"]), 100)
        eventually(lambda: dict(self.page.history.present.settings)["search.pop_size"] == 100)

    def search(self):
        press(self.visitor, self.page.view.search.surrogate)
        wait_for_result(self.page)

    def case(self):
        self.visitor.set(widget(self.tab.case), "geometry")
        eventually(lambda: self.page.state.bounds.case == "geometry")

    def upload(self):
        mine = KNEE.replace('title = "Packaged baseline"', 'title = "Mine"').encode()
        self.visitor.upload(widget(self.page.view.files.upload), "mine.toml", mine)
        eventually(lambda: self.page.state.knee.title == "Mine")

    def rest_lengths(self):
        self.visitor.set(widget(self.tab.rest_length), "fixed")
        eventually(lambda: self.page.state.bounds.rest_length == "fixed")

    def follow(self):
        self.visitor.set(widget(self.page.view.search.live), True)
        eventually(lambda: self.page.live.shown)

    def stop_following(self):
        self.visitor.set(widget(self.page.view.search.live), False)
        eventually(lambda: not self.page.live.on)


class TestTenMixedChanges:
    def test_undone_and_redone_they_are_the_same_bytes(self, page, visitor, path):
        texts = [settled(page)]
        for one in Changes(visitor, page).all():
            one()
            texts.append(settled(page))
        assert len(set(texts)) == 11
        for wanted in texts[-2::-1]:
            change(visitor, page, UNDO)
            eventually(lambda w=wanted: settled(page) == w)
        change(visitor, page, UNDO)
        visitor.wait(lambda c: c.notifications)
        for wanted in texts[1:]:
            change(visitor, page, REDO)
            eventually(lambda w=wanted: settled(page) == w)


class TestSteps:
    def test_a_drag_over_the_wire_is_one_step(self, page, visitor):
        began = settled(page)
        for value in np.linspace(-1.2, 0.5, 40).round(2):
            visitor.set(widget(page.view.knee.sliders[ACL_Y]), float(value))
        eventually(lambda: page.state.x[ACL_Y] == pytest.approx(0.5e-3))
        settled(page)
        change(visitor, page, UNDO)
        eventually(lambda: settled(page) == began)
        visitor.wait(lambda c: c.values[widget(page.view.knee.sliders[ACL_Y])] == -0.3)

    def test_two_visitors_share_one_way_back(self, app, page, visitor):
        began = settled(page)
        with WebSocketClient(app.server.get_port()) as other:
            other.wait(lambda c: c.counts.get("ReplayDoneMessage"))
            other.set(widget(page.view.knee.sliders[0]), -13.5)
            eventually(lambda: page.state.x[0] == pytest.approx(-13.5e-3))
            settled(page)
            change(visitor, page, UNDO)
            eventually(lambda: settled(page) == began)

    def test_the_keys_commands_do_the_same(self, page, visitor):
        began = settled(page)
        Changes(visitor, page).bound()
        after = settled(page)
        commands = {
            c.label: c._impl.uuid for c in page.target.gui._command_handle_from_uuid.values()
        }
        for name, wanted in ((UNDO, began), (REDO, after), (START_OVER, began), (UNDO, after)):
            visitor.send({"type": "CommandTriggerMessage", "uuid": commands[name]})
            eventually(lambda w=wanted: settled(page) == w)

    def test_start_over_restores_knee_bounds_and_settings_and_can_be_undone(self, page, visitor):
        began, changes = settled(page), Changes(visitor, page)
        for one in (changes.slider, changes.bound, changes.setting, changes.search):
            one()
        mine = settled(page)
        change(visitor, page, START_OVER)
        eventually(lambda: settled(page) == began)
        assert page.view.knee.bounds["geometry_mm"].value == 1.0
        visitor.wait(lambda c: c.props[widget(page.view.found)]["content"] == "")
        assert page.view.files.result["result.json"].disabled
        change(visitor, page, UNDO)
        eventually(lambda: settled(page) == mine)
        visitor.wait(lambda c: "over-extends" in c.props[widget(page.view.found)]["content"])

    def test_what_is_shown_of_a_result_goes_back_with_it(self, page, visitor):
        Changes(visitor, page).search()
        settled(page)
        box = widget(page.view.search.overlay)
        visitor.set(box, False)
        eventually(lambda: not page.overlay)
        settled(page)
        change(visitor, page, UNDO)
        eventually(lambda: page.overlay and settled(page))
        visitor.wait(lambda c: c.values[box] is True)


class TestWhatIsLimited:
    @pytest.mark.parametrize("bad", [math.nan, math.inf, -1e9, "1"])
    def test_nonsense_from_the_wire_leaves_no_step_and_one_line_tells(self, page, visitor, bad):
        began, view = settled(page), page.view
        handles = (view.knee.bounds["geometry_mm"], view.transport.position, view.knee.sliders[0])
        for handle in (*handles, view.search.options.handles["seed"]):
            visitor.set(widget(handle), bad)
        visitor.wait(lambda c: c.notifications)
        assert settled(page) == began
        assert page.history.undo() is None
        assert len(visitor.notifications) == 1

    def test_narrower_bounds_tell_once_and_undo_gives_the_knee_back(self, page, visitor):
        visitor.set(widget(page.view.knee.sliders[ACL_Y]), 0.6)
        eventually(lambda: page.state.x[ACL_Y] == pytest.approx(0.6e-3))
        mine = settled(page)
        for mm in (0.8, 0.6, 0.4):
            visitor.set(widget(page.view.knee.bounds["geometry_mm"]), mm)
        eventually(lambda: page.state.bounds.geometry_mm == 0.4)
        visitor.wait(lambda c: c.notifications)
        assert "One value of the knee was beyond" in visitor.notifications[0]["props"]["body"]
        change(visitor, page, UNDO)
        eventually(lambda: settled(page) == mine)
        assert len(visitor.notifications) == 1


class TestKeptState:
    def test_a_server_that_starts_again_opens_as_it_was_left(self, page, visitor, path, tmp_path):
        began, changes = settled(page), Changes(visitor, page)
        for one in (changes.slider, changes.bound, changes.setting, changes.search):
            one()
        left = settled(page)
        eventually(lambda: path.read_text() == left)
        again = App(port=0, state=shutil.copy(path, tmp_path))
        try:
            assert saved.to_text(again.page.snapshot()) == left
            again.page.post("undo")
            eventually(lambda: settled(again.page) == began)
        finally:
            again.stop()
        left = (tmp_path / path.name).read_text()
        assert left == began, "the last state is written before the server ends"

    def test_a_second_server_on_the_same_file_is_refused_in_a_line(self, page, path):
        with pytest.raises(OutputError, match=r"`state` .* another process is writing") as told:
            App(port=0, state=path)
        assert "\n" not in str(told.value)

    def test_who_ends_or_fails_lets_others_write(self, tmp_path):
        path = tmp_path / "state.json"
        path.write_text("no state")
        for _ in range(2):
            with pytest.raises(FileFormatError):
                KeptState(path, saved.read)
        path.unlink()
        for _ in range(2):
            KeptState(path, saved.read).stop()
        assert list(tmp_path.iterdir()) == []

    def test_a_lesson_is_nothing_to_come_back_to(self, page, visitor, monkeypatch):
        kept, learn = [], page.view.learn
        monkeypatch.setattr(page, "keep", kept.append)
        press(visitor, learn.press)
        eventually(lambda: page.lesson == 0)
        Changes(visitor, page).slider()
        settled(page)
        assert kept == []
        press(visitor, learn.turn, "Back")
        eventually(lambda: page.lesson is None)

    @pytest.mark.parametrize(
        ("change", "why"),
        [
            ({"schema": "kneeviz.state/2"}, "'kneeviz.state/1' is allowed"),
            ({"knee": [0.0] * 31}, "shape"),
            ({"knee": ["0"] * 32}, "32 numbers"),
            ({"bounds": {"case": "both"}}, "`bounds` must name"),
            ({"baseline": "schema = 1"}, "`schema`"),
            ({"settings": {"search.seed": -1}}, "search.seed: -1 is outside"),
            ({"settings": {"colour": "red"}}, "'colour' is unknown"),
            ({"result": {"schema": "kneecore.result/9"}}, "`result`"),
            ({"overlay": 1}, "`overlay`"),
            ({"more": 1}, "'more'"),
        ],
        ids=lambda value: str(value)[:30],
    )
    def test_what_is_no_state_of_this_version_is_refused_in_a_line(
        self, page, tmp_path, change, why
    ):
        document = json.loads(settled(page)) | change
        del document["digest"]
        bad = tmp_path / "bad.json"
        bad.write_text(json.dumps(document))
        with pytest.raises(FileFormatError, match=re.escape(why)) as told:
            App(port=0, state=bad)
        assert "\n" not in str(told.value)

    @pytest.mark.parametrize("content", ["", "{", "[]", '{"knee": [NaN]}', "changed"])
    def test_a_broken_or_changed_file_is_refused_with_its_name(self, page, tmp_path, content):
        bad = tmp_path / "bad.json"
        changed = settled(page).replace('"overlay": false', '"overlay": true')
        bad.write_text(changed if content == "changed" else content)
        with pytest.raises(FileFormatError, match=r"bad\.json: "):
            App(port=0, state=bad)

    def test_a_place_that_cannot_be_written_is_told_at_once(self, tmp_path):
        with pytest.raises(OutputError, match="cannot be written"):
            App(port=0, state=tmp_path / "no_folder" / "state.json")

    def test_visitors_with_pages_of_their_own_have_no_common_state(self, tmp_path):
        with pytest.raises(ParameterError, match="page of his own"):
            App(port=0, state=tmp_path / "state.json", shared=False)

    def test_the_last_state_is_written_before_the_server_ends(self, tmp_path, monkeypatch):
        monkeypatch.setattr(keeper_module, "_BETWEEN", 60.0)
        path = tmp_path / "state.json"
        keeper = Keeper(path, lambda _: None)
        keeper.keep(lambda: "first")
        eventually(path.exists)
        keeper.keep(lambda: "last")
        keeper.stop()
        assert path.read_text() == "last"

    def test_a_disk_that_fills_up_is_told_once(self, tmp_path):
        told, folder = [], tmp_path / "gone"
        folder.mkdir()
        keeper = Keeper(folder / "state.json", told.append)
        folder.rmdir()
        for _ in range(3):
            keeper.keep(lambda: "{}")
            keeper._write()
        keeper.stop()
        assert len(told) == 1
        assert "cannot be written" in told[0]
