"""The lesson's state: what a visitor had before it, and what was answered."""

from dataclasses import dataclass, field

from kneeviz.state.history import History
from kneeviz.state.lesson_facts import Fact
from kneeviz.state.lesson_steps import STEPS
from kneeviz.state.snapshot import Snapshot


@dataclass(frozen=True, kw_only=True)
class SetAside:
    """A page as the lesson found it, and gives it back."""

    state: Snapshot
    history: History[Snapshot]
    mode: str
    forces: bool
    playing: bool
    share: float
    """Where the motion was, 0 to 1."""
    landscape: bool
    band: bool
    """Whether the study's band was wanted."""


@dataclass(kw_only=True)
class Answers:
    """What was answered, step by step, and whether the open step is revealed."""

    given: dict[int, float] = field(default_factory=dict)
    """The answers by step: the place of a choice, or a number."""
    judged: dict[int, bool] = field(default_factory=dict)
    """Whether an answer was right when its step was first revealed."""
    fact: Fact | None = None
    """What the open step has shown; None before it is revealed."""
    waiting: bool = False
    """Whether it is to be told as soon as it is known."""

    def open(self) -> None:
        """Open a step: its answer is still to be revealed."""
        self.fact, self.waiting = None, False

    def give(self, step: int, answer: float) -> None:
        """Take an answer, until the step is revealed."""
        if not self.revealed and not self.waiting:
            self.given[step] = answer

    def reveal(self, step: int, fact: Fact) -> None:
        """Take what was seen; the first time counts."""
        self.fact, self.waiting = fact, False
        if step in self.given:
            right = STEPS[step].is_right(self.given[step], fact.right)
            self.judged.setdefault(step, right)

    @property
    def revealed(self) -> bool:
        """Whether the open step has told what was seen."""
        return self.fact is not None

    @property
    def tally(self) -> dict[str, int]:
        """How many answers were revealed, and how many of them were right."""
        return {"answered": len(self.judged), "right": sum(self.judged.values())}
