"""The clock of the animation: from wall time to a place in the motion. No widget, no thread."""

import math
from dataclasses import dataclass

SWEEP_SECONDS = 6.0
"""From full extension to full flexion at speed 1."""
RUN_SECONDS = 23.0
"""Simulated seconds of one run; they pass in real time times `RUN_RATE`."""
RUN_RATE = 2.0
RETURN_SECONDS = 0.8
"""To ease back to the start of a run before it loops."""
FRAME_SECONDS = 1.0 / 30.0


@dataclass
class Playback:
    """Where the motion is and how it goes on.

    Through the loads the place swings to and fro like a pendulum, so that it slows down at both
    ends; in time it runs to its end and eases back before the next round.
    """

    playing: bool = True
    speed: float = 1.0
    loop: bool = True
    mode: str = "sweep"
    phase: float = 0.0
    """Sweep: in half swings, 0 straight, 1 bent, 2 straight again. Run: share of the run; above 1
    it eases back."""
    _last: float | None = None

    @property
    def share(self) -> float:
        """Place in [0, 1]: of the way through the loads, or of a run's time."""
        if self.mode == "sweep":
            return 0.5 - 0.5 * math.cos(math.pi * self.phase)
        if self.phase <= 1.0:
            return self.phase
        back = (self.phase - 1.0) * (RUN_SECONDS / RUN_RATE) / RETURN_SECONDS
        return max(0.5 + 0.5 * math.cos(math.pi * min(back, 1.0)), 0.0)

    def set_share(self, share: float) -> None:
        """Go to a place; the motion goes on from there towards bending."""
        part = min(max(share, 0.0), 1.0)
        self.phase = math.acos(1.0 - 2.0 * part) / math.pi if self.mode == "sweep" else part

    def set_mode(self, mode: str) -> None:
        """Change between the motion through the loads and a run in time; it starts afresh."""
        if mode != self.mode:
            self.mode, self.phase = mode, 0.0

    def play(self, playing: bool) -> None:
        """Start or pause."""
        if playing and not self.playing and self.mode != "sweep" and self.phase >= 1.0:
            self.phase = 0.0
        self.playing, self._last = playing, None

    def advance(self, now: float) -> None:
        """Go on by the wall time since the last call, `now` in s."""
        last, self._last = self._last, now
        if not self.playing or last is None:
            return
        # A pause of the machine is no leap of the knee.
        passed = self.speed * min(max(now - last, 0.0), 0.25)
        if self.mode == "sweep":
            self._swing(passed / SWEEP_SECONDS)
        else:
            self._run(passed * RUN_RATE / RUN_SECONDS)

    def _swing(self, step: float) -> None:
        end = math.floor(self.phase) + 1.0
        self.phase += step
        if not self.loop and self.phase >= end:
            self.phase, self.playing = end, False
        self.phase %= 2.0

    def _run(self, step: float) -> None:
        self.phase += step
        if not self.loop:
            if self.phase >= 1.0:
                self.phase, self.playing = 1.0, False
            return
        if self.phase >= 1.0 + RETURN_SECONDS * RUN_RATE / RUN_SECONDS:
            self.phase = 0.0
