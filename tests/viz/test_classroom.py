"""A class over the wire: who only watches changes nothing, whatever he sends."""

import itertools
import urllib.request
from dataclasses import fields

import pytest
from viz.conftest import eventually
from viz.visits import pause, widget
from viz.websocket_client import CAMERA, WebSocketClient
from websockets.exceptions import InvalidStatus

from kneecore import ParameterError
from kneeviz.geometry.handles import BY_NAME
from kneeviz.server import caps
from kneeviz.server.app import App
from kneeviz.server.classroom import Rule
from kneeviz.server.gate import Gate
from kneeviz.state import saved
from kneeviz.views.teach import ALL, TEACHER, WATCHING

pytestmark = pytest.mark.filterwarnings("ignore:Queued a ")  # viser's, for those who left
HIT = "/handles/acl_femur"
_MOVES = itertools.count(1)


@pytest.fixture(scope="module")
def app():
    running = App(port=0, for_class=True)
    try:
        eventually(lambda: running.page.model_ready)
        yield running
    finally:
        running.stop()


def entered(app, *, as_teacher):
    token = f"/?token={app.gate.lead}" if as_teacher else ""
    client = WebSocketClient(app.server.get_port(), path=token)
    client.wait(lambda c: c.counts.get("ReplayDoneMessage"))
    return client


@pytest.fixture
def teacher(app):
    with entered(app, as_teacher=True) as client:
        client.wait(switch)
        yield client
        app.classroom.give(TEACHER)


@pytest.fixture
def student(app, teacher):
    with entered(app, as_teacher=False) as client:
        eventually(lambda: "Visitor 1" in offered(teacher))
        yield client
    eventually(lambda: "Visitor 1" not in offered(teacher))


def switch(client):
    """The id of the switch that only a teacher's page has, if it is there."""
    found = (u for u, props in client.props.items() if props.get("label") == "Who drives")
    return next(found, None)


def offered(teacher):
    return tuple(teacher.props[switch(teacher)]["options"])


def give(app, teacher, driver):
    teacher.set(switch(teacher), driver)
    eventually(lambda: app.classroom.driver == driver)


def slider(page):
    return widget(page.view.knee.sliders[0])


def all_is_read(app, name, client):
    """Wait until the server has read all that a client has sent: its camera counts in any case."""
    moved = float(next(_MOVES))
    client.send(CAMERA | {"position": (moved, 0.0, 2.0)})
    camera = app.server.get_clients()[number_of(app, name)].camera
    eventually(lambda: camera.position[0] == moved)


def number_of(app, name):
    people = app.classroom._people.items()
    return next(number for number, person in people if person.name == name)


def everything(app, client, page):
    """What a page can send, one of each kind beside its camera, each of which would change it."""
    gui = page.view
    knee = b'schema = 1\ntitle = "Mine"'
    undo = next(c for c in gui.commands if c.label == "Undo")
    return {
        caps.GuiUpdate: [
            lambda: client.set(slider(page), -13.3),
            lambda: client.set(widget(gui.transport.play), True),
            lambda: client.set(widget(gui.look.dark), True),
            lambda: client.set(widget(gui.search.surrogate), True),
            lambda: client.set(widget(gui.files.knee), True),
            lambda: client.update(slider(page), {"disabled": True}),
        ],
        caps.CommandTrigger: [
            lambda: client.send({"type": "CommandTriggerMessage", "uuid": widget(undo)})
        ],
        caps.SceneNodeClick: [lambda: client.click(HIT)],
        caps.SceneNodeDrag: [
            lambda p=phase: client.drag(HIT, p, (0.0, 0.0, 0.0), (0.01, 0.0, 0.0))
            for phase in ("start", "update", "end")
        ],
        caps.FileTransferStartUpload: [
            lambda: client.upload(widget(gui.files.upload), "mine.toml", knee)
        ],
        caps.FileTransferPart: [
            lambda: client.send(
                {
                    "type": "FileTransferPart",
                    "source_component_uuid": None,
                    "transfer_uuid": "x",
                    "part_index": 0,
                    "content": b"x",
                }
            )
        ],
    }


def test_a_watcher_changes_nothing_whatever_he_sends(app, teacher, student, monkeypatch):
    page, done = app.page, []
    pause(teacher, page)
    before = (saved.to_text(page.snapshot()), page.view.dark, page.handles.chosen)
    attacks = everything(app, student, page)
    assert set(attacks) == set(caps.ACCEPTED) - {caps.ViewerCamera}
    mailbox = app.session._worker.mailbox
    post = mailbox.post
    monkeypatch.setattr(mailbox, "post", lambda *asked: (done.append(asked[0]), post(*asked)))
    for kind in attacks.values():
        for send in kind:
            send()
    all_is_read(app, "Visitor 1", student)
    assert {key[0] for key in done} <= {"reject", "joined", "resized"}, "nothing else has arrived"
    assert (saved.to_text(page.snapshot()), page.view.dark, page.handles.chosen) == before
    student.wait(lambda c: any(WATCHING in n["props"]["body"] for n in c.notifications))
    assert student.downloads == {}


def test_what_moved_in_his_browser_is_set_right(app, teacher, student):
    student.set(slider(app.page), -13.3)
    held = app.page.view.knee.sliders[0].value
    student.wait(lambda c: c.counts.get("GuiUpdateMessage") and c.values[slider(app.page)] == held)
    assert app.page.state.x[0] == pytest.approx(held * 1e-3)


def moves(app, client, value):
    client.set(slider(app.page), value)
    eventually(lambda: app.page.state.x[0] == pytest.approx(value * 1e-3))


def does_not_move(app, client, name):
    before = app.page.state.x[0]
    client.set(slider(app.page), -13.111)
    all_is_read(app, name, client)
    assert app.page.state.x[0] == before


def test_the_wheel_goes_from_hand_to_hand(app, teacher, student):
    with entered(app, as_teacher=False) as other:
        eventually(lambda: "Visitor 2" in offered(teacher))
        moves(app, teacher, -13.2)
        give(app, teacher, "Visitor 1")
        moves(app, student, -13.3)
        does_not_move(app, other, "Visitor 2")
        give(app, teacher, "Visitor 2")
        moves(app, other, -13.4)
        does_not_move(app, student, "Visitor 1")
        give(app, teacher, ALL)
        moves(app, other, -13.5)
        moves(app, student, -13.6)
        give(app, teacher, TEACHER)
        does_not_move(app, other, "Visitor 2")
        does_not_move(app, student, "Visitor 1")
        give(app, teacher, "Visitor 2")
    eventually(lambda: app.classroom.rule == Rule())  # he left, and took it not along
    moves(app, teacher, -13.7)
    assert offered(teacher) == (TEACHER, ALL, "Visitor 1")


def test_who_loses_the_wheel_lets_go_of_what_he_holds(app, teacher, student):
    page = app.page
    pause(teacher, page)
    give(app, teacher, "Visitor 1")
    at = page.view.handles.hits[[*BY_NAME].index("acl_femur")].position
    student.drag(HIT, "start", at, at)
    eventually(lambda: page.handles.grabs)
    give(app, teacher, TEACHER)
    eventually(lambda: not page.handles.grabs)


def test_the_switch_is_the_teachers_alone(app, teacher, student):
    give(app, teacher, ALL)
    assert switch(student) is None
    student.set(switch(teacher), "Visitor 1")
    all_is_read(app, "Visitor 1", student)
    assert app.classroom.driver == ALL


def test_two_windows_of_the_teacher_show_the_same(app, teacher):
    with entered(app, as_teacher=True) as second:
        second.wait(switch)
        give(app, second, ALL)
        teacher.wait(lambda c: c.values[switch(c)] == ALL)


def test_a_page_shows_what_its_visitor_may_do(app, teacher):
    said = []

    def note(message):
        if message["type"] == "RunJavascriptMessage" and "kneeviz-role" in message["source"]:
            said.append(message["source"])

    with WebSocketClient(app.server.get_port(), on_message=note) as student:
        student.wait(lambda _: said and "You are watching; the teacher drives" in said[-1])
        give(app, teacher, "Visitor 1")
        student.wait(lambda _: "You have the wheel (Visitor 1)" in said[-1])
        give(app, teacher, ALL)
        student.wait(lambda _: "line = null, watches = false" in said[-1])


class TestDoor:
    GUARDED = Gate.of("0.0.0.0", token="the-class-s-own-token", for_class=True)

    def test_the_teachers_address_makes_a_teacher_and_the_classs_does_not(self, app):
        port = app.server.get_port()
        assert app.class_url == f"http://127.0.0.1:{port}"
        assert app.url == f"{app.class_url}/?token={app.gate.lead}"
        cookies = {}
        for url in (app.url, app.class_url):
            with urllib.request.urlopen(url, timeout=10) as answer:
                cookies[url] = answer.headers["Set-Cookie"]
        assert cookies[app.class_url] is None
        cookie = cookies[app.url].partition(";")[0]
        with WebSocketClient(port, headers={"Cookie": cookie}) as client:
            client.wait(switch)

    def test_the_class_needs_its_token_where_others_are(self):
        running = App(port=0, token="the-class-s-own-token", for_class=True)
        try:
            for path in ("", "/?token=the-class-s-own-tokem", "/?lead=1"):
                with pytest.raises(InvalidStatus):
                    WebSocketClient(running.server.get_port(), path=path)
        finally:
            running.stop()

    def test_the_classs_token_is_not_the_teachers(self):
        gate = self.GUARDED
        headers = type("None_", (), {"get_all": lambda _, key: []})()
        assert gate.has_token(f"/?token={gate.lead}", headers)
        assert gate.leads(f"/?token={gate.lead}", headers)
        assert gate.has_token(f"/?token={gate.token}", headers)
        assert not gate.leads(f"/?token={gate.token}", headers)
        assert gate.lead not in gate.class_url(8080)
        assert "watch" in gate.warning(8080)

    def test_without_a_class_nobody_leads(self):
        gate = Gate.of("127.0.0.1", token=None)
        assert gate.lead is None
        assert "/?token=" not in gate.url(8080)

    def test_each_with_a_page_of_his_own_is_no_class(self):
        with pytest.raises(ParameterError, match="page of his own"):
            App(port=0, shared=False, for_class=True)


def test_a_rule_lets_nobody_but_the_teacher_drive_unless_it_says_so():
    student, leader = (type("C", (), {"leads": leads})() for leads in (False, True))
    assert [f.name for f in fields(Rule)] == ["everybody", "one"]
    assert not Rule().lets(student)
    assert Rule().lets(leader)
    assert Rule(one=student).lets(student)
    assert Rule(everybody=True).lets(student)
