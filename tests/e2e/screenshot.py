"""Take the README's picture of the app: ``python tests/e2e/screenshot.py [assets/screenshot.png]``.

The app runs, searches in the surrogate and shows both worst cases on the knee.
"""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parents[1])]

from playwright.sync_api import sync_playwright  # noqa: E402, I001

from e2e.conftest import ARGUMENTS, Visitor, eventually, find_browser  # noqa: E402
from kneeviz.server.app import App  # noqa: E402
from kneeviz.jobs.messages import Asked  # noqa: E402

MAX_BYTES = 400_000


def main(path: Path) -> None:
    app = App(port=0)
    try:
        page = app.page
        eventually(lambda: page.surrogate_ready, 60.0)
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=find_browser(), args=list(ARGUMENTS)
            )
            visitor = Visitor(browser, app.url, query="")
            page.post("play", Asked(None, -1, True))  # it plays from the start
            visitor.tab("Search")
            visitor.press("Worst case (surrogate)")
            visitor.wait_until(lambda: page.overlay and not page.animation.fading, 60)
            page.post("position", Asked(None, -1, 16.0))
            eventually(lambda: abs(page.playback.share - 0.16) < 1e-6)
            visitor.page.mouse.move(640, 700)
            visitor.page.wait_for_timeout(2500)
            visitor.page.screenshot(path=path)
            browser.close()
    finally:
        app.stop()
    size = path.stat().st_size
    assert size < MAX_BYTES, f"{path} has {size} bytes; below {MAX_BYTES} is wanted"
    print(f"{path}: {size:,} bytes")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "assets/screenshot.png"))
