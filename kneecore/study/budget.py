"""What each study asks of the machine."""

from typing import Any

from kneecore.budget import Budget, surrogate_memory
from kneecore.model import Model
from kneecore.study.settings import (
    InfluenceSettings,
    SamplingSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
)

__all__ = ["grid_budget", "study_budget"]

_SECONDS_A_MODEL = 2e-7
"""No machine is faster."""
_TAILS = 0.0035
"""Share of the samples that are kept for the percentiles."""
_SETTINGS_BYTES = 400.0
"""Of one search that a sweep has before it."""
_SECONDS_A_SEARCH = 1e-3


def _budget(
    settings: Any, models: int, seconds: dict[str, float], memory: dict[str, float]
) -> Budget:
    values = {name: getattr(settings, name) for name in (*memory, *seconds)}
    return Budget(models, seconds, memory, values)


def _sampling(settings: SamplingSettings, m: int, d: int) -> Budget:
    n = settings.n_samples
    memory = {"n_samples": 8.0 * _TAILS * n * m}
    if settings.sampling == "latin-hypercube":
        memory["n_samples"] += 8.0 * n * d
    return _budget(settings, n, {"n_samples": n * _SECONDS_A_MODEL}, memory)


def _influence(settings: InfluenceSettings, m: int, d: int) -> Budget:
    n = settings.n_base * (d + 2)
    memory = {"n_base": 8.0 * n * m * (2 if settings.intervals else 1)}
    return _budget(settings, n, {"n_base": n * _SECONDS_A_MODEL}, memory)


def _training_sweep(settings: TrainingSweepSettings, _m: int, d: int) -> Budget:
    n_searches = len(settings.sizes) * settings.n_seeds
    memory = {
        "sizes": surrogate_memory(max(settings.sizes), d),
        "n_seeds": _SETTINGS_BYTES * n_searches,
    }
    seconds = {"n_seeds": n_searches * _SECONDS_A_SEARCH}
    return _budget(settings, sum(settings.sizes) * settings.n_seeds, seconds, memory)


def _quality(settings: SurrogateQualitySettings, m: int, d: int) -> Budget:
    memory = {
        "training_samples": surrogate_memory(settings.training_samples, d),
        "n_test": 8.0 * settings.n_test * (d + 3 * m),
    }
    models = settings.training_samples + settings.n_test
    return _budget(settings, models, {"n_test": models * _SECONDS_A_MODEL}, memory)


_BUDGETS: dict[type[Any], Any] = {
    SamplingSettings: _sampling,
    InfluenceSettings: _influence,
    TrainingSweepSettings: _training_sweep,
    SurrogateQualitySettings: _quality,
}


def study_budget(settings: Any, model: Model) -> Budget | None:
    """Return what a study asks for; None for one whose steps no option counts."""
    budget = _BUDGETS.get(type(settings))
    found: Budget | None = budget and budget(settings, model.n_outputs, model.n_free)
    return found


def grid_budget(n_points: int, model: Model) -> Budget:
    """Return what a landscape asks for."""
    n = n_points**2
    return Budget(
        n,
        {"n_points": n * _SECONDS_A_MODEL},
        {"n_points": 8.0 * n * (len(model.inputs) + model.n_outputs)},
        {"n_points": n_points},
    )
