"""What a browser sets arrives, whatever the session sets the same widget to meanwhile."""

import time

import pytest
from viz.conftest import eventually
from viz.visits import pause, widget

from kneeviz.actions import view
from kneeviz.jobs.messages import Asked


@pytest.fixture
def posted(app, page, monkeypatch):
    """What browsers ask for; nothing of it is done."""
    kept = []
    eventually(lambda: not page.animation.running)
    page.playback.play(False)
    monkeypatch.setattr(app.session._worker.mailbox, "post", lambda *message: kept.append(message))
    return kept


WIDGETS = {
    "position": (lambda view: view.transport.position, 30.0, 70.0),
    "slider": (lambda view: view.knee.sliders[0], -14.5, -13.5),
    "bound": (lambda view: view.knee.bounds["geometry_mm"], 0.5, 0.7),
    "preset": (lambda view: view.knee.preset, "Larger condyle", "My own"),
    "case": (lambda view: view.knee.case, "geometry", "material"),
    "box": (lambda view: view.search.overlay, False, True),
    "seed": (lambda view: view.search.options.handles["seed"], 5, 6),
    "mode": (lambda view: view.look.mode, "In time, flexing", "In time, extending"),
}


@pytest.mark.parametrize("name", WIDGETS)
class TestAValueThatArrivesWhileTheSessionSetsIt:
    def asked(self, posted):
        """The values that were asked for, once there are any."""

        def told():
            return [m[-1].value for m in posted if isinstance(m[-1], Asked)]

        eventually(told, 5.0)
        return told()

    @pytest.fixture
    def handle(self, page, name):
        handle = WIDGETS[name][0](page.view)
        before = handle.value
        yield handle
        handle._impl.value = before

    def test_it_is_not_taken_for_the_sessions(self, posted, visitor, handle, name, monkeypatch):
        _, sent, ours = WIDGETS[name]
        # viser calls this between taking a value in and telling of it.
        monkeypatch.setattr(
            handle._impl, "sync_cb", lambda *_: setattr(handle._impl, "value", ours)
        )
        visitor.set(widget(handle), sent)
        assert self.asked(posted) == [sent]

    def test_it_counts_though_the_session_has_just_set_the_same(
        self, posted, visitor, handle, name
    ):
        sent = WIDGETS[name][1]
        handle._impl.value = sent
        visitor.set(widget(handle), sent)
        assert self.asked(posted) == [sent]


def test_the_one_who_moved_it_is_told_after_what_crossed_his_hand(page, visitor, monkeypatch):
    """Ours may reach his browser after he has moved the slider; then his must come once more."""
    monkeypatch.setattr(view, "_CROSSING_SECONDS", 60.0)
    handle = page.view.transport.position
    pause(visitor, page)
    page.playback.set_share(0.9)
    page.post(("setting", "search.seed"))
    visitor.wait(lambda c: c.values[widget(handle)] == pytest.approx(90.0))
    time.sleep(0.1)  # nothing of the session's is on its way any more
    visitor.set(widget(handle), 20.0)
    visitor.wait(lambda c: c.values[widget(handle)] == pytest.approx(20.0), 5.0)
