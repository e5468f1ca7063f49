"""Two clicks in quick succession, which viser tells as two."""

import time
from collections.abc import Callable, Hashable

TWICE_SECONDS = 0.4


class Clicks:
    """Remembers each visitor's last click."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._last: dict[int, tuple[Hashable, float]] = {}

    def is_second(self, client_id: int, what: Hashable) -> bool:
        """Note a click; tell whether it makes a double click of the one before."""
        now, before = self._clock(), self._last.pop(client_id, None)
        if before is not None and before[0] == what and now - before[1] <= TWICE_SECONDS:
            return True
        self._last = {c: (w, t) for c, (w, t) in self._last.items() if now - t <= TWICE_SECONDS}
        self._last[client_id] = (what, now)
        return False
