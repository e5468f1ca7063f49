"""What a search asks of the machine."""

from typing import TYPE_CHECKING, Any

from kneecore.budget import Budget, surrogate_memory

if TYPE_CHECKING:  # a command line shows its options without it
    from kneecore.model import Model

__all__ = ["search_budget"]

_SECONDS_A_PAIR = 2e-7
"""Least time of a pair in the surrogate, and of a model: no machine is faster."""


def search_budget(settings: Any, model: "Model") -> Budget:
    """Return what a search with all its `SearchSettings` decided asks for."""
    d, m = model.n_free, model.n_outputs
    in_model, ga = settings.search_space == "model", settings.method == "ga"
    memory: dict[str, float] = {}
    seconds: dict[str, float] = {}
    models = 2
    if not in_model:
        added = settings.n_repair if settings.repair else 0
        rows = settings.n_training + added
        models += rows
        most = "training_samples"
        if added > settings.n_training:
            most = "repair_models"
        memory[most] = surrogate_memory(rows, d) + 8.0 * rows * (d + m)
        seconds[most] = rows * _SECONDS_A_PAIR
    if ga:
        pairs = settings.pop_size * settings.n_generations * settings.n_runs
        models += 2 * pairs if in_model else 0
        # Parents, children and what is held while they change places, two models each.
        memory["pop_size"] = 8.0 * settings.pop_size * 3 * 2 * d
        if in_model:  # and what a model holds while a generation runs, such as its constants
            memory["pop_size"] += 8.0 * settings.pop_size * 2 * 2 * (d + m)
        memory["n_generations"] = 8.0 * settings.n_generations
        memory["n_runs"] = 8.0 * settings.n_runs
        counts = {name: getattr(settings, name) for name in ("n_generations", "n_runs", "pop_size")}
        seconds[max(counts, key=lambda name: counts[name])] = pairs * _SECONDS_A_PAIR
    return Budget(models, seconds, memory, {name: getattr(settings, name) for name in memory})
