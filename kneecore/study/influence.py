"""Which inputs decide the outputs: the answer that a worst case alone cannot give.

Examples
--------
>>> import kneecore
>>> found = kneecore.influence(kneecore.Knee(), kneecore.InfluenceSettings(n_base=256))
>>> found.deciding(5)[0]  # at 5 N m of extension
'condyle_x'
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import shown
from kneecore._threads import thread_count
from kneecore._version import versions
from kneecore.errors import ModelError, ParameterError
from kneecore.model import Model
from kneecore.numerics.sampling_options import check_count
from kneecore.numerics.sensitivity import Indices, sobol_indices
from kneecore.presented import Presented
from kneecore.progress import Callback, Cancelled, Clock, Progress
from kneecore.study.arguments import checked_settings
from kneecore.study.partial import count_partial
from kneecore.study.settings import InfluenceSettings
from kneecore.unit_model import UnitModel

__all__ = ["InfluenceResult", "check_independent", "influence"]

FloatArray = NDArray[np.float64]
N_RESAMPLES = 100


@dataclass(frozen=True, kw_only=True, eq=False)
class InfluenceResult(Presented):
    """Sobol' indices of the outputs."""

    model: Model
    """What was looked at. Read from a file, a model that is no knee has no function."""
    settings: InfluenceSettings
    names: tuple[str, ...]
    """The free inputs, in the order of the indices' second axis."""
    groups: Mapping[str, FloatArray]
    """First-order indices summed over each group's inputs, shape (m,) each; empty where the model
    has no groups."""
    indices: Indices
    """First axis the m outputs, second axis the free inputs."""
    counts: Mapping[str, int]
    """Models that were run by what became of them, as in `MonteCarloResult`, "partial" among them:
    a run that failed in some outputs costs those outputs its base row, not the others. Empty where
    an older file did not tell."""
    seconds: Mapping[str, float]
    threads: int
    versions: Mapping[str, str]

    @property
    def told_alone(self) -> list[int]:
        """Outputs that are told apart from the others: the watched one, and the order's end."""
        return list(dict.fromkeys([self.model.watched, self.model.order[-1]]))

    def deciding(self, column: int, count: int = 5) -> list[str]:
        """Return the inputs with the largest total indices in an output, largest first.

        Parameters
        ----------
        column : int
            Which of the m numbers that the model returns, from 0.
        count : int
            How many are wanted.
        """
        check_column(column, len(self.indices.constant))
        check_count("count", count)
        total = np.nan_to_num(self.indices.total_order[column])
        return [self.names[k] for k in np.argsort(-total, kind="stable")[:count]]


def check_column(column: int, n_outputs: int) -> None:
    """Raise a `ParameterError` if there is no such column of the outputs."""
    whole = isinstance(column, int | np.integer) and not isinstance(column, bool)
    if not whole or not 0 <= column < n_outputs:
        raise ParameterError(
            f"`column` is {shown(column)}; a whole number from 0 to {n_outputs - 1} is allowed"
        )


def check_independent(model: Model) -> None:
    """Raise a `ParameterError` if a model's inputs are correlated."""
    if model.correlation is not None:
        raise ParameterError(
            "`correlation` of the model is given; Sobol' indices share the variance out among "
            "inputs that are independent, and are not defined for others (`monte_carlo` takes them)"
        )


def influence(
    model: Model,
    settings: InfluenceSettings | None = None,
    *,
    callback: Callback | None = None,
) -> InfluenceResult:
    """Return first-order and total Sobol' indices of the outputs of the true model.

    Parameters
    ----------
    model : Model
        Such as `Knee`; it is run n_free + 2 times for each base row.
    settings : InfluenceSettings, optional
    callback : callable, optional
        Gets `Progress`; a true result cancels (raises `Cancelled`).

    Raises
    ------
    ParameterError
        If an argument is not allowed, the inputs are correlated, or no output varies within the
        bounds.
    ModelError
        If too many models failed.
    """
    settings = checked_settings(model, InfluenceSettings, settings, callback)
    check_independent(model)
    start = time.perf_counter()
    counted = UnitModel(model, drawn=True, every_mark=True)
    found = _indices(counted, settings, callback)
    if found.unknown.all():
        raise ModelError(
            "each output failed in more than three quarters of the rows of the sensitivity design; "
            f"narrower bounds are needed{model.told_failure}"
        )
    if (found.constant | found.unknown).all():
        raise ParameterError(
            f"the bounds of the {model.n_free} free inputs move no output; bounds that move at "
            "least one are needed"
        )
    return InfluenceResult(
        model=model,
        settings=settings,
        names=model.free_names,
        groups=_sums_of_groups(model, found.first_order),
        indices=found,
        counts=counted.counts,
        seconds={"total": time.perf_counter() - start},
        threads=thread_count(model.threads),
        versions=versions(),
    )


def _sums_of_groups(model: Model, first_order: FloatArray) -> dict[str, FloatArray]:
    sums: dict[str, FloatArray] = {}
    for k, name in enumerate(model.free_names):
        group = model.groups.get(name)
        if group is not None:
            sums[group] = sums.get(group, np.zeros(len(first_order))) + first_order[:, k]
    return sums


def _indices(model: UnitModel, settings: InfluenceSettings, callback: Callback | None) -> Indices:
    reached = [0, settings.n_base]
    clock = Clock()

    def watch(done: int, total: int) -> object:
        reached[:] = done, total
        if callback is None:
            return False
        left = clock.left(done, total - done)
        return callback(Progress(stage="sampling", done=done, total=total, seconds_left=left))

    def run(u: FloatArray) -> FloatArray:
        # Within a batch of base rows too, for a slow model's sake.
        y = model(u, None if callback is None else lambda _: watch(reached[0], reached[1]))
        count_partial(model.counts, y)
        return y

    try:
        return sobol_indices(
            run,
            model.model.n_free,
            n_base=settings.n_base,
            seed=settings.seed,
            n_resamples=N_RESAMPLES if settings.intervals else 0,
            callback=watch,
        )
    except InterruptedError:
        raise Cancelled from None
