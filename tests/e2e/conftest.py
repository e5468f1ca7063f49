"""A real Chromium in front of the real server.

Debian's chromium on the PATH is taken, or Playwright's own. Without a browser these tests are
skipped and say so; with ``KNEEVIZ_REQUIRE_BROWSER=1`` its absence is a failure.
"""

import os
import shutil
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from kneeviz.jobs.messages import Asked
from kneeviz.server.app import App

ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--no-first-run", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
READY = """() => window.__viserMutable?.nodeRefFromName?.['/knee/femur'] != null
    && Object.keys(window.__viserTestpoints?.uplots ?? {}).length > 0"""
VISER_S_OWN = "Unable to preventDefault inside passive event listener"
"""What viser's client says whenever a node is dragged; nothing comes of it."""
SPOT = """name => {
    const { nodeRefFromName, camera, canvas } = window.__viserMutable, node = nodeRefFromName[name];
    const drawn = node.children[0].matrixWorld;  // a hand takes what was drawn last
    const at = node.position.clone().setFromMatrixPosition(drawn).project(camera);
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return [left + (at.x + 1) / 2 * width, top + (1 - at.y) / 2 * height];
}"""
VIEWPORT = {"width": 1280, "height": 720}


def eventually(condition: Callable[[], object], timeout: float = 60.0) -> None:
    """Wait until a condition on the server holds."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "what was waited for did not happen"
        time.sleep(0.02)


def find_browser() -> str | None:
    """Return the path of a Chromium on the PATH; None stands for Playwright's own."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for name in names if (path := shutil.which(name))), None)


def _absent(reason: str) -> None:
    if os.environ.get("KNEEVIZ_REQUIRE_BROWSER") == "1":
        pytest.fail(f"KNEEVIZ_REQUIRE_BROWSER is set, but {reason}", pytrace=False)
    pytest.skip(f"{reason}; the browser tests did not run")


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        _absent("the package playwright is not installed")
    with sync_playwright() as playwright:
        try:
            running = playwright.chromium.launch(
                executable_path=find_browser(), args=list(ARGUMENTS)
            )
        except Error as error:
            _absent(f"no browser can be started ({str(error).splitlines()[0]})")
        yield running
        running.close()


class Visitor:
    """A page on the app, with helpers that find widgets as a person would."""

    def __init__(self, browser: Any, url: str, query: str = "/?fixedDpr=0.5") -> None:
        self.errors: list[str] = []
        self.context = browser.new_context(viewport=VIEWPORT, accept_downloads=True)
        self.page = self.context.new_page()
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._note)
        self.url = url + query
        self.open()

    def _note(self, message: Any) -> None:
        if message.type == "error" and VISER_S_OWN not in message.text:
            self.errors.append(message.text)

    def open(self) -> None:
        self.page.goto(self.url)
        self.page.wait_for_function(READY, timeout=60_000)
        # Headless Chromium has no graphics card; viser says so in a notice over the scene.
        notice = self.page.locator(".mantine-Notification-closeButton")
        for _ in range(notice.count()):
            notice.first.click()

    def close(self) -> None:
        self.context.close()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).click()

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()

    def row(self, label: str) -> Any:
        found = self.page.get_by_text(label, exact=True)
        return found.locator("xpath=ancestor::div[contains(@class,'Flex-root')][1]")

    def thumb(self, label: str) -> Any:
        return self.row(label).get_by_role("slider")

    def curve(self, uuid: str) -> list[list[float | None]]:
        """Return the data of a chart: axis and series; what is not drawn is None."""
        return self.page.evaluate(
            "id => window.__viserTestpoints.uplots[id].chart.data"
            ".map(s => Array.from(s, v => Number.isNaN(v) ? null : v))",
            uuid,
        )

    def pixels(self, uuid: str) -> str:
        """Return the picture of a chart."""
        return self.page.evaluate(
            "id => window.__viserTestpoints.uplots[id].chart.ctx.canvas.toDataURL()", uuid
        )

    def turn(self, node: str = "/knee/tibia") -> list[float]:
        """Return a node's orientation as it is drawn."""
        return self.page.evaluate(
            "name => { const q = window.__viserMutable.nodeRefFromName[name].quaternion;"
            " return [q.w, q.x, q.y, q.z]; }",
            node,
        )

    def spot(self, node: str) -> tuple[float, float]:
        """Return where the middle of a node of the scene is in the window, in pixels."""
        x, y = self.page.evaluate(SPOT, node)
        return x, y

    def wait(self, script: str, argument: Any = None, timeout: float = 20_000) -> None:
        self.page.wait_for_function(script, arg=argument, timeout=timeout)

    def wait_until(self, condition: Callable[[], object], timeout: float = 60.0) -> None:
        """Wait for a condition while the page goes on."""
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, "what was waited for did not happen"
            self.page.wait_for_timeout(30)


@pytest.fixture(scope="session")
def app(chromium: Any) -> Iterator[App]:
    running = App(port=0)
    try:
        eventually(lambda: running.page.surrogate_ready, 60.0)
        yield running
    finally:
        running.stop()


@pytest.fixture(scope="session")
def shared_page(chromium: Any, app: App) -> Iterator[Visitor]:
    visitor = Visitor(chromium, app.url)
    yield visitor
    visitor.close()


@pytest.fixture
def visitor(shared_page: Visitor, app: App) -> Iterator[Visitor]:
    """The page, with the knee at the baseline and the motion paused."""
    page = app.page
    if page.playback.playing:
        page.post("play", Asked(None, -1, True))
    eventually(lambda: not page.playback.playing)
    if not page.state.at_baseline:
        page.post("reset_all")
        eventually(lambda: page.state.at_baseline)
        eventually(lambda: not page.animation.morphing)
    shared_page.errors.clear()
    yield shared_page
    assert shared_page.errors == []
