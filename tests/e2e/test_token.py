"""The token, the cookie and the gate as a real browser meets them."""

import http.server
import threading

import pytest
import viser
from e2e.conftest import READY, Visitor, eventually

from kneeviz.server.app import App

TOKEN = "the-token-of-this-test"
STRANGER = b"""<script>
const line = new WebSocket("ws://127.0.0.1:%d/", ["viser-v%s"]);
line.onmessage = () => { document.title = "got in"; };
line.onclose = () => { if (!document.title) document.title = "refused"; };
</script>"""


@pytest.fixture(scope="module")
def guarded():
    running = App(port=0, token=TOKEN)
    yield running
    running.stop()


@pytest.fixture
def page(chromium, guarded):
    visitor = Visitor(chromium, guarded.url, "&fixedDpr=0.5")
    yield visitor
    visitor.close()


def test_the_page_works_with_the_whole_address_and_is_kept_after_it(guarded, page):
    assert page.page.url.startswith(guarded.url)
    bare = f"http://127.0.0.1:{guarded.server.get_port()}/?fixedDpr=0.5"
    page.page.goto(bare)
    page.page.wait_for_function(READY, timeout=60_000)
    page.page.reload()
    page.page.wait_for_function(READY, timeout=60_000)
    assert TOKEN not in page.page.evaluate("document.cookie"), "no script can read it"
    assert page.errors == []


def test_without_the_token_the_page_says_what_is_needed(chromium, guarded):
    context = chromium.new_context()
    page = context.new_page()
    answer = page.goto(f"http://127.0.0.1:{guarded.server.get_port()}/")
    assert answer.status == 403
    assert "open the whole address" in page.inner_text("body")
    context.close()


def test_a_page_of_another_site_gets_nothing(chromium, guarded, page):
    """The visitor has the cookie, and opens a hostile page in the same browser."""
    text = STRANGER % (guarded.server.get_port(), viser.__version__.encode())

    class Site(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(text)

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Site) as site:
        threading.Thread(target=site.serve_forever, daemon=True).start()
        before = len(guarded.server.get_clients())
        stranger = page.context.new_page()
        stranger.goto(f"http://127.0.0.1:{site.server_port}/")
        stranger.wait_for_function("document.title !== ''", timeout=20_000)
        assert stranger.title() == "refused"
        eventually(lambda: len(guarded.server.get_clients()) == before)
        site.shutdown()
