"""The table's rows: each one injects faults for a while and tells what happened.

A module ``rows_<part>.py`` in this folder adds its own by decorating a function::

    @row("Files cut short", Guard(file=..., function=..., line=..., test=...))
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


@dataclass(frozen=True, kw_only=True)
class Guard:
    """A line that a row rests on: without it, its test fails. ``guards.py`` takes it out and looks.

    Lines are without their indentation, as they stand in the file.
    """

    file: str
    function: str
    line: str
    instead: str
    """What stands there when it is taken out."""
    test: str
    """What fails then: pytest's arguments."""


Attack = Callable[[Scale], Outcome]
ROWS: dict[str, Attack] = {}
"""The rows by their names, in the order of the table."""
GUARDS: dict[str, Guard] = {}
"""The guards of the rows, by the rows' names."""


def row(name: str, guard: Guard) -> Callable[[Attack], Attack]:
    """Add a row to the table."""

    def added(attack: Attack) -> Attack:
        assert name not in ROWS, f"there are two rows {name!r}"
        ROWS[name], GUARDS[name] = attack, guard
        return attack

    return added


HEAD = (
    "| what we try to break | injected | what happens | the line that was removed to see it fail |",
    "|---|---|---|---|",
)


def line(name: str, outcome: Outcome) -> str:
    """Return a row of the Markdown table."""
    mark = "" if outcome.sound else "**not sound:** "
    guard = GUARDS[name]
    place = f"`{guard.file}`, `{guard.function}`: `{guard.line}`"
    cells = (name, outcome.injected, mark + outcome.happened, place)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def table(outcomes: dict[str, Outcome]) -> str:
    """Return the Markdown table of what was injected, what happened, and what holds it."""
    return "\n".join([*HEAD, *(line(name, outcome) for name, outcome in outcomes.items())])
