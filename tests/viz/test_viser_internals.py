"""The checks in front of viser, and the private parts that they rest on."""

import math

import numpy as np
import numpy.typing
import pytest
import viser
from viser import _assignable_props_api, _client_autobuild, _messages

from kneeviz import viser_internals
from kneeviz.viser_internals import MAX_UPLOAD


@pytest.fixture(scope="module")
def server():
    running = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield running
    running.stop()


@pytest.fixture(scope="module")
def widgets(server):
    gui = server.gui
    return {
        "slider": gui.add_slider("s", 0.0, 10.0, 0.1, 5.0),
        "number": gui.add_number("n", 5, min=1, max=9),
        "seed": gui.add_number("e", 0, min=0, max=2**31 - 1),
        "open": gui.add_number("o", 5.0),
        "check": gui.add_checkbox("c", True),
        "choice": gui.add_dropdown("d", ("a", "b")),
        "group": gui.add_button_group("g", ("x", "y")),
        "button": gui.add_button("b"),
        "shut": gui.add_button("t", disabled=True),
        "upload": gui.add_upload_button("u"),
        "bar": gui.add_progress_bar(0.0),
    }


@pytest.mark.parametrize(
    ("widget", "value"),
    [
        ("slider", 0.0), ("slider", 10), ("slider", 10.0 + 1e-9), ("number", 9), ("open", -1e9),
        ("check", False), ("choice", "b"), ("group", "y"), ("button", True),
    ],
)  # fmt: skip
def test_good_values_pass(widgets, widget, value):
    assert viser_internals.update_fault(widgets[widget], {"value": value}) is None


@pytest.mark.parametrize(
    ("widget", "value"),
    [
        ("slider", 10.1), ("slider", -0.1), ("slider", math.nan), ("slider", math.inf),
        ("slider", "5"), ("slider", None), ("slider", True), ("slider", [5]), ("number", 0),
        ("open", math.nan), ("seed", -0.6), ("seed", 2**31), ("check", "yes"), ("check", 1),
        ("choice", "c"), ("choice", ["a"]), ("group", "z"), ("button", "x"), ("shut", True),
        ("upload", b"x"), ("bar", 50.0),
    ],
)  # fmt: skip
def test_bad_values_do_not(widgets, widget, value):
    assert viser_internals.update_fault(widgets[widget], {"value": value})


@pytest.mark.parametrize(
    "updates", [{}, {"uuid": "x"}, {"value": 1.0, "max": 99.0}, "value", None, [1]]
)
def test_nothing_but_the_value_can_be_set(widgets, updates):
    assert viser_internals.update_fault(widgets["slider"], updates)


@pytest.mark.parametrize(
    ("size", "parts", "passes"),
    [
        (10, 1, True), (0, 0, True), (MAX_UPLOAD, 5, True), (MAX_UPLOAD + 1, 5, False),
        (-1, 1, False), (10, -1, False), (10, 10**9, False), ("10", 1, False), (10.5, 1, False),
    ],
)  # fmt: skip
def test_announced_uploads(size, parts, passes):
    assert (viser_internals.upload_fault(size, parts) is None) is passes


def test_the_private_parts_are_there(server, widgets):
    gui = server.gui
    assert (
        gui._gui_input_handle_from_uuid[viser_internals.widget_id(widgets["slider"])]
        is widgets["slider"]
    )
    for message, handler in (
        (_messages.GuiUpdateMessage, gui._handle_gui_updates),
        (_messages.FileTransferStartUpload, gui._handle_file_transfer_start),
        (_messages.FileTransferPart, gui._handle_file_transfer_part),
    ):
        assert handler in gui._websock_interface._incoming_handlers[message]
    assert isinstance(gui._current_file_upload_states, dict)


def test_no_server_looks_for_a_compiler(monkeypatch):
    looked = []
    monkeypatch.setattr(_client_autobuild, "ensure_client_is_built", lambda: looked.append(1))
    viser.ViserServer(host="127.0.0.1", port=0, verbose=False).stop()
    assert looked, "viser has another way to build its client now"
    viser_internals.skip_client_build()
    viser.ViserServer(host="127.0.0.1", port=0, verbose=False).stop()
    assert looked == [1]


def test_the_tunnel_is_refused(server):
    handlers = server._websock_server._incoming_handlers
    assert _messages.ShareUrlRequest in handlers
    viser_internals.refuse_tunnel(server)
    assert _messages.ShareUrlRequest not in handlers
    viser_internals.refuse_tunnel(server)


def test_a_forced_value_is_sent_though_nothing_changed(server, widgets):
    sent = []
    queue = server._websock_server.queue_message
    server._websock_server.queue_message = sent.append
    try:
        widgets["slider"].value = widgets["slider"].value
        assert sent == []
        viser_internals.force_value(server.gui, widgets["slider"])
    finally:
        server._websock_server.queue_message = queue
    assert sent[0].updates == {"value": widgets["slider"].value}


def test_numbers_forgive_the_rounding_of_the_screen():
    assert viser_internals.number_fault(0.499000001, 0.414, 0.499) is None
    assert viser_internals.number_fault(np.float64(0.6), 0.414, 0.499)


def test_array_types_are_made_once_and_values_are_still_cast(server):
    viser_internals.know_array_types()
    known = vars(_assignable_props_api)["npt"].NDArray
    for kind in (np.float16, np.float32, np.float64, np.uint8):
        assert known[kind] == np.typing.NDArray[kind]
        assert known[kind] is known[kind]
    line = server.scene.add_line_segments("/l", np.zeros((1, 2, 3)), (1, 2, 3))
    line.points, line.colors = np.ones((1, 2, 3)), np.array([1.0, 0.0, 0.0])
    assert line.points.dtype == np.float32
    assert line.colors.dtype == np.uint8
    line.remove()
