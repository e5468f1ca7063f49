"""The browser of the benchmarks, one for all of them: that of the browser tests."""

from collections.abc import Iterator
from typing import Any

import pytest
from e2e.conftest import VIEWPORT
from e2e.conftest import chromium as chromium


@pytest.fixture
def page(chromium: Any) -> Iterator[Any]:
    """Return an empty page of the size at which nothing is folded."""
    context = chromium.new_context(viewport=VIEWPORT)
    yield context.new_page()
    context.close()
