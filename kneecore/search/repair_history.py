"""What a repaired surrogate tells about its repair."""

from dataclasses import dataclass

__all__ = ["Repair", "RepairRound"]


@dataclass(frozen=True, kw_only=True)
class RepairRound:
    """One look at the surrogate's optimum in the true model."""

    n_models: int
    """Models added to the training samples by then, those of the optimum included."""
    objective_surrogate: float
    """f of the optimum by the surrogate that was not yet fitted to it."""
    objective_model: float | None
    """f of the same pair by the true model; None if one of the two failed."""
    gap_percent: float | None
    """100 (surrogate - model) / surrogate."""


@dataclass(frozen=True, kw_only=True)
class Repair:
    """The history of a repair."""

    goal_percent: float
    """Gap below which the surrogate counts as repaired."""
    max_models: int
    """Models that were allowed."""
    n_models: int
    """Models that were added, failed ones included."""
    n_failed: int
    """Those among them that failed: they are in no fit."""
    rounds: tuple[RepairRound, ...]
    """The gaps, the first that of the surrogate before the repair."""

    @property
    def reached(self) -> bool:
        """Whether the last gap is below the goal."""
        gap = self.rounds[-1].gap_percent if self.rounds else None
        return gap is not None and abs(gap) < self.goal_percent
