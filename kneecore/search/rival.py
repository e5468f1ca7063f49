"""What another method found in the same space."""

from dataclasses import dataclass

__all__ = ["METHOD_NAMES", "Rival"]

METHOD_NAMES = {
    "ga_surrogate": "genetic algorithm in the surrogate (200 x 800)",
    "repair": "self-repairing surrogate",
    "exact": "exact gradients in the true model",
    "ga": "genetic algorithm in the true model (100 x 100)",
}
"""What the methods of `kneecore.search.compare` are, in words."""


@dataclass(frozen=True, kw_only=True)
class Rival:
    """One method's worst case and the way to it. Every f but the promised one is the true model's.

    The wall time is among the result's `seconds`.
    """

    method: str
    """A key of `METHOD_NAMES`."""
    promised: float | None
    """f by the surrogate that was searched, deg; None for a search in the true model."""
    n_models: tuple[float, ...]
    """True models run by then, rising."""
    objective: tuple[float, ...]
    """Best f by then, deg; empty if the true model failed for what was found."""

    def shortfall_percent(self, best: float) -> float | None:
        """Return by how much the method's f falls short of `best`, per cent."""
        return 100.0 * (1.0 - self.objective[-1] / best) if self.objective and best else None
