"""What one connection may send, without a server."""

import dataclasses
import math

import msgspec
import pytest
from viser import _messages
from viz.websocket_client import CAMERA

from kneeviz.server import caps
from kneeviz.server.caps import BURST, MESSAGES_PER_SECOND, Crowd, Pace, understood

UPDATE = {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": 1.0}}
START = {
    "type": "FileTransferStartUpload", "source_component_uuid": "a", "transfer_uuid": "b",
    "filename": "x.toml", "mime_type": "", "part_count": 1, "size_bytes": 10,
}  # fmt: skip
PART = {
    "type": "FileTransferPart", "source_component_uuid": "a", "transfer_uuid": "b",
    "part_index": 0, "content": b"x",
}  # fmt: skip

CLICK = {
    "type": "SceneNodeClickMessage", "name": "/handles/condyle", "instance_index": None,
    "ray_origin": (0.0, 0.0, 2.0), "ray_direction": (0.0, 0.0, -1.0), "screen_pos": (0.5, 0.5),
    "modifier": None, "owner": "",
}  # fmt: skip
DRAG = {
    "type": "SceneNodeDragMessage", "phase": "update", "name": "/handles/condyle",
    "instance_index": None, "start_position": (0.0, 0.0, 0.0), "start_screen_pos": (0.5, 0.5),
    "end_position": (math.nan, 0.0, 0.0), "end_screen_pos": (0.5, 0.5), "button": "left",
    "modifier": "cmd/ctrl+shift", "owner": "",
}  # fmt: skip


def packed(message):
    return msgspec.msgpack.encode(message)


@pytest.mark.parametrize(
    "message", [CAMERA, UPDATE, CLICK, DRAG, START, PART], ids=lambda m: m["type"]
)
def test_what_the_page_sends_is_understood(message):
    assert understood(packed(message)) is not None


@pytest.mark.parametrize("kind", caps.ACCEPTED)
def test_our_fields_are_viser_s(kind):
    """A new release of viser that sends other fields fails here."""
    theirs = getattr(_messages, kind.__struct_config__.tag)
    assert set(kind.__struct_fields__) == {f.name for f in dataclasses.fields(theirs)}


NESTED = b"\x91" * 100_000 + b"\xc0"


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"\xc1", b"\xc0", b"\x81", "text", packed([1]), packed({}), packed({"type": 1}),
        packed({"type": "ShareUrlRequest"}), packed({"type": "RunJavascriptMessage", "source": ""}),
        packed({"type": "GuiUpdateMessage"}), packed(UPDATE | {"uuid": ["a"]}),
        packed(UPDATE | {"updates": []}), packed(UPDATE | {"uuid": "a" * 101}),
        packed(UPDATE | {"excluded_self_client": 1}),
        packed(UPDATE | {"updates": {"value": "x" * 70_000}}),
        packed(CAMERA | {"fov": math.nan}), packed(CAMERA | {"fov": "x"}),
        packed(CAMERA | {"wxyz": [1.0]}),
        packed(START | {"size_bytes": -2}), packed(START | {"filename": "x" * 1001}),
        packed(START | {"part_count": 1.5}), packed(PART | {"content": "x"}), NESTED,
        packed(CLICK | {"ray_origin": (math.nan, 0.0, 2.0)}), packed(CLICK | {"name": "a" * 101}),
        packed(DRAG | {"phase": "stay"}), packed(DRAG | {"end_position": (0.0, 0.0)}),
        packed(DRAG | {"button": "x" * 9}), packed(DRAG | {"modifier": "x" * 31}),
        b"\x82\xa4type\xb0GuiUpdateMessage\xa4uuid" + NESTED,
        packed(UPDATE)[:-1], packed(UPDATE) + b"x",
    ],
)  # fmt: skip
def test_nothing_else_is(raw):
    assert understood(raw) is None


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def test_an_honest_page_never_waits():
    clock = Clock()
    pace = Pace(clock)
    for _ in range(2000):
        clock.now += 0.01  # two tabs' sliders and the camera at once
        assert pace.charge(150) == 0.0
    for _ in range(10):
        assert pace.charge(512 * 1024 + 200) == 0.0, "a file of 5 MB"


def test_who_sends_faster_is_read_at_the_pace():
    clock = Clock()
    pace, read = Pace(clock), 0
    while clock.now < 10.0:
        clock.now += pace.charge(100) + 1e-6
        read += 1
    assert read <= BURST + 10.0 * MESSAGES_PER_SECOND + 2


def test_large_and_malformed_messages_cost_more():
    small, large, broken = (Pace(Clock()) for _ in range(3))
    for _ in range(100):
        small_wait = small.charge(100)
        large_wait, broken_wait = large.charge(600_000), broken.charge(100, malformed=True)
    assert small_wait == 0.0
    assert large_wait > 10.0
    assert broken_wait > 1.0


def test_the_silent_make_room_for_who_comes():
    crowd = Crowd(3)
    assert [crowd.enter(name) for name in "abc"] == [None, None, None]
    crowd.know("a")
    assert crowd.enter("d") == "b"
    assert crowd.enter("e") == "c"
    for name in "de":
        crowd.know(name)
    assert crowd.enter("f") == "f", "all the others have spoken"
    assert len(crowd) == 3
    crowd.leave("a")
    crowd.leave("f")
    assert crowd.enter("g") is None
    crowd.know("x")
    assert len(crowd) == 3
