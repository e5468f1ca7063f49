"""The table's rows: each one injects faults for a while and tells what happened.

A module ``rows_<part>.py`` in this folder adds its own by decorating a function::

    @row("Files cut short")
    def cut_files(scale: Scale) -> Outcome: ...
"""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Scale:
    """How long and how much."""

    seconds: float
    """How long a row that goes by time injects its faults."""
    share: float = 1.0
    """What part of a row's usual number is injected; 1 in the long run."""

    def count(self, usual: int) -> int:
        """Return how many of `usual` to inject."""
        return max(round(self.share * usual), 1)


LONG, SHORT = Scale(seconds=120.0), Scale(seconds=6.0, share=0.1)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What was done and what came of it."""

    injected: str
    """What was injected, with its number."""
    happened: str
    """What happened, with its figures."""
    sound: bool
    """Whether that is what should happen."""


Attack = Callable[[Scale], Outcome]
ROWS: dict[str, Attack] = {}
"""The rows by their names, in the order of the table."""


def row(name: str) -> Callable[[Attack], Attack]:
    """Add a row to the table."""

    def added(attack: Attack) -> Attack:
        assert name not in ROWS, f"there are two rows {name!r}"
        ROWS[name] = attack
        return attack

    return added


def table(outcomes: dict[str, Outcome]) -> str:
    """Return the Markdown table of what was injected and what happened."""
    lines = ["| what we try to break | injected | what happens |", "|---|---|---|"]
    for name, outcome in outcomes.items():
        mark = "" if outcome.sound else "**not sound:** "
        cells = (name, outcome.injected, mark + outcome.happened)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)
