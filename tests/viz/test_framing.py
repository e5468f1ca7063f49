import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, search_anew
from viz.websocket_client import CAMERA, WebSocketClient

from kneeviz.geometry import framing, surfaces
from kneeviz.views.scene import camera

DIRECTIONS = (camera.FRONT, camera.ASIDE, camera.BEFORE_LANDSCAPE)


def on_screen(points, frame, direction):
    """Points in a perspective picture, in half heights from its middle, worked out with angles."""
    eye = camera.position(frame, direction)
    towards = (frame.centre - eye) / np.linalg.norm(frame.centre - eye)
    right = np.cross(towards, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, towards)
    rays = points - eye
    depth = rays @ towards
    scale = np.tan(0.5 * framing.FIELD_OF_VIEW)
    return np.column_stack([rays @ right, rays @ up]) / depth[:, None] / scale


@pytest.mark.parametrize("direction", DIRECTIONS, ids=["front", "aside", "landscape"])
@pytest.mark.parametrize("aspect", [0.5, 0.75, 1.0, 2.4])
def test_a_frame_shows_all_and_is_filled(direction, aspect):
    points = surfaces.corners() + [0.05, -0.02, 0.0]
    frame = framing.frame_around(points, direction, aspect)
    seen = np.abs(on_screen(points, frame, direction)) / [aspect, 1.0]
    assert 0.85 < seen.max() < 1.0
    assert framing.holds(frame, points, direction, aspect)
    assert not framing.holds(frame, 1.2 * points, direction, aspect)
    assert not framing.holds(frame, 0.6 * points + 0.4 * frame.centre, direction, aspect)
    assert not framing.holds(frame, points + [0.03, 0.03, 0.0], direction, aspect)


def test_between_two_frames():
    one = framing.Frame(centre=np.zeros(3), half_height=0.1)
    two = framing.Frame(centre=np.ones(3), half_height=0.3)
    half = framing.between(one, two, 0.5)
    assert half.centre.tolist() == [0.5, 0.5, 0.5]
    assert half.half_height == pytest.approx(0.2)


class Window(WebSocketClient):
    """A visitor's window: tells where its camera is, and keeps what it is told."""

    def __init__(self, port, width, height):
        self.size = {"image_width": width, "image_height": height}
        self.position, self.look_at, self.folded = None, None, []
        super().__init__(port, on_message=self._take, camera=self.camera())

    def camera(self, **more):
        return CAMERA | self.size | more

    def _take(self, message):
        if message["type"] == "SetCameraPositionMessage":
            self.position = tuple(map(float, message["position"]))
        elif message["type"] == "SetCameraLookAtMessage":
            self.look_at = tuple(map(float, message["look_at"]))
        elif message.get("run_id", "").startswith("client"):
            self.folded.append(message["collapsed"])

    def resize(self, width, height):
        self.size = {"image_width": width, "image_height": height}
        self.send(self.camera(position=self.position, look_at=self.look_at))

    def shows(self, page):
        """Tell whether the knees of the page are in the picture all through their motion."""
        if self.position is None or self.look_at is None:
            return False
        width, height = self.size["image_width"], self.size["image_height"]
        half = (self.position[2] - self.look_at[2]) * np.tan(0.5 * framing.FIELD_OF_VIEW)
        sweeps = [knee.sweep for knee in page.knees if knee is not None]
        poses = [s.at_moment(m) for s in sweeps for m in np.linspace(5.0, -5.0, 20)]
        away = np.abs(framing.knee_points(poses) - self.look_at)[:, :2].max(axis=0)
        return away[1] < half and away[0] < half * width / height


@pytest.mark.parametrize("size", [(542, 720), (1182, 1080), (530, 700), (420, 400)])
def test_knees_and_worst_cases_fill_each_window(page, visitor, size):
    with Window(visitor.port, *size) as window:
        window.wait(lambda w: w.shows(page))
        search_anew(page, visitor)
        window.wait(lambda w: w.shows(page) and not page.framing.running)
        window.resize(size[0] // 2, size[1])
        window.wait(lambda w: w.shows(page))


def test_a_camera_that_its_visitor_has_moved_is_left_alone(page, visitor, monkeypatch):
    monkeypatch.setattr("kneeviz.page.framing._ECHO_SECONDS", 0.0)
    with Window(visitor.port, 542, 720) as window:
        window.wait(lambda w: w.shows(page))
        mine = (0.1, 0.2, 1.5)
        window.send(window.camera(position=mine, look_at=(0.1, 0.2, 0.0)))
        seen = page.clients
        eventually(lambda: any(np.allclose(c.camera.position, mine) for c in seen().values()))
        before = window.position
        search_anew(page, visitor)
        eventually(lambda: page.overlay and not page.framing.running)
        assert window.position is before
        press(window, page.view.transport.view, "Reset")
        window.wait(lambda w: w.shows(page))


@pytest.mark.parametrize("size", [(0, 0), (500, 0), (0, 500), (-3, 7), (10**9, 1)])
def test_a_window_without_a_size_harms_nobody(page, visitor, size, capfd):
    with Window(visitor.port, *size) as window:
        window.wait(lambda w: w.position is not None)
        window.resize(*size[::-1])
        window.resize(600, 400)
        window.wait(lambda w: w.shows(page))
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("density", [0.5, 2.0])
def test_charts_give_way_in_a_narrow_window_and_come_back(page, visitor, monkeypatch, density):
    def pixels(width):
        return round(width * density), round(700 * density)

    def resized(width):
        window.resize(*pixels(width))
        window.wait(lambda w: w.shows(page))

    with Window(visitor.port, *pixels(170)) as window:
        window.wait(lambda w: w.folded == [True])
        resized(520)  # what the charts leave
        monkeypatch.setattr("kneeviz.page.framing._ECHO_SECONDS", 0.0)
        resized(600)
        assert window.folded == [True]
        window.resize(*pixels(900))
        window.wait(lambda w: w.folded == [True, False])
    assert visitor.counts["GuiSetPanelCollapsedMessage"] == 1  # of the controls, at the start
