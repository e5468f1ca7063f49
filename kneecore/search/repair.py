"""A surrogate that repairs itself where it is trusted most: at its own optimum.

A surrogate's optimum lies in a corner that the training samples know little of, and what is wrong
there is what the search finds. So the optimum is computed in the true model, added to the samples,
and the surrogate fitted again, until its gap is small. That alone ends in a corner that is right
but not the best: an input whose effect has the other sign there than elsewhere is never looked at.
So the models that are left go, one at a time, to the pair so far with one input at its other bound:
the one with the largest expected improvement (Jones, Schonlau & Welch 1998, J. Glob. Optim.
13:455), by the loss that the surrogate predicts and by how much such predictions have been wrong
so far, for the same model and for the same input of the other. No input of a model is tried twice.

Examples
--------
>>> import kneecore
>>> from kneecore import Input, Output
>>> springs = kneecore.Model(
...     lambda k: 1.0 / k,
...     inputs=[Input("k_1", lower=90.0, upper=110.0), Input("k_2", lower=45.0, upper=55.0)],
...     outputs=[Output("stretch", axis=(1, 2))],
... )
>>> settings = kneecore.SearchSettings(training_samples=5, method="exact", repair=True)
>>> kneecore.worst_case(springs, settings).repair.reached
True
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.pair import SurrogatePair
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Cancelled, Progress
from kneecore.search.exact_search import climb_surrogate
from kneecore.search.genetic_search import search_pair
from kneecore.search.problem import Found, Outcome, Problem, pair_value
from kneecore.search.result import Repair, RepairRound, gap_percent
from kneecore.search.settings import SearchSettings
from kneecore.search.training import Training, train
from kneecore.unit_model import UnitModel

__all__ = ["find_repaired_pair"]

FloatArray = NDArray[np.float64]
Search = Callable[[Surrogate], Found]

_SAME = 1e-3  # of the cube's width: models closer than that are one
_WORTH = 2e-3  # of f: an optimum that promises less above the best known pair is not computed
_FIRST_ERROR = 0.01  # of f: what the prediction of an input's effect is taken to be wrong by ...
_FIRST_WEIGHT = 2.0  # ... as if that had been seen this many times
_OTHER_WEIGHT = 3.0  # of the same input's error for the other model, in trials
_NEAR = 0.95  # of the optimum's f: a known pair below that is not where it is
_PAIR = 2


def _expected_improvement(loss: FloatArray, error: FloatArray) -> FloatArray:
    """Return the expected gain of changes that are predicted to lose `loss`, sd `error`."""
    z = -loss / error
    density = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    below = np.array([0.5 * math.erfc(-v / math.sqrt(2.0)) for v in z])
    gain: FloatArray = error * (density + z * below)
    return gain


@dataclass(frozen=True, kw_only=True)
class _Trial:
    """One input of one of the two models at its other bound."""

    half: int
    place: int
    """Which input."""
    u: FloatArray
    sums: FloatArray
    """Weighted signs of the outputs whose sum the model is to have large."""
    predicted: float


class _Samples:
    """All models known so far, and the surrogate through those that did not fail."""

    def __init__(self, model: UnitModel, training: Training, weights: FloatArray) -> None:
        self._model, self._weights = model, weights
        self.points, self.values = training.points, training.values
        self.surrogate = training.surrogate
        self.n_first = len(training.points)
        self.best = -np.inf
        self.best_places = (0, 0)
        self._take_in(0)

    def _take_in(self, first: int) -> None:
        """Look for better pairs among the models from `first` on."""
        for k in range(first, len(self.values)):
            f = (np.abs(self.values[: k + 1] - self.values[k]) * self._weights).sum(axis=1)
            f = np.where(np.isfinite(f), f, -np.inf)
            j = int(np.argmax(f))
            if f[j] > self.best:
                self.best, self.best_places = float(f[j]), (j, k)

    @property
    def n_added(self) -> int:
        return len(self.points) - self.n_first

    @property
    def n_failed(self) -> int:
        added = self.values[self.n_first :]
        return int(np.count_nonzero(~np.isfinite(added).all(axis=1)))

    def known(self, u: FloatArray) -> bool:
        """Tell whether a model (d,) is among the known ones."""
        return bool(np.abs(self.points - u).max(axis=1).min() < _SAME)

    def places_of(self, u: FloatArray) -> list[int]:
        """Return where models (n, d), known ones, are among the known models."""
        places: list[int] = np.abs(self.points - u[:, None]).max(axis=2).argmin(axis=1).tolist()
        return places

    def add(self, u: FloatArray) -> FloatArray:
        """Compute models (n, d), keep them, fit again, and return their outputs."""
        y = self._model(u)
        first = len(self.values)
        self.points = np.concatenate([self.points, u])
        self.values = np.concatenate([self.values, y])
        self._take_in(first)
        good = np.isfinite(self.values).all(axis=1)
        self.surrogate = Surrogate.fit(self.points[good], self.values[good])
        return y


class _Repairing:
    """The state of one repair."""

    def __init__(
        self, samples: _Samples, search: Search, weights: FloatArray, settings: SearchSettings
    ) -> None:
        self.samples, self._search, self._weights = samples, search, weights
        self._goal, self._max = settings.repair_gap_percent, settings.n_repair
        self.rounds: list[RepairRound] = []
        self.last: Found | None = None
        """The optimum that was computed last."""
        self.predicted: FloatArray | None = None
        """Its outputs by the surrogate before that, shape (2, m)."""
        self._searched: tuple[Surrogate, Found] | None = None
        self._tried: tuple[set[int], set[int]] = (set(), set())
        self._errors: tuple[dict[int, float], dict[int, float]] = ({}, {})
        self.n_evaluations = 0
        self.cancelled = False

    @property
    def _left(self) -> int:
        return self._max - self.samples.n_added

    def run(self) -> None:
        """Repair until nothing is left to try or the models are used up; look once more then."""
        while self._left > _PAIR:
            found = self._look()
            if self.cancelled:
                return
            if self._promises_more(found) and self._is_new(found):
                if self._left < 2 * _PAIR:
                    break
                self._check(found)
                if not self.small or self._left <= _PAIR:  # what is left is for the last look
                    continue
            if not self._try_one(*self._base(found)):
                break
        found = self._look()
        if not self.cancelled:
            self._check(found)

    @property
    def small(self) -> bool:
        """Whether the last gap is below the goal."""
        gap = self.rounds[-1].gap_percent if self.rounds else None
        return gap is not None and abs(gap) < self._goal

    def _look(self) -> Found:
        """Search the surrogate as it is now; the two models keep their places from last time."""
        surrogate = self.samples.surrogate
        if self._searched is not None and self._searched[0] is surrogate:
            return self._searched[1]
        try:
            found = self._search(surrogate)
        except Cancelled:
            if self._searched is None:
                raise
            self.cancelled = True
            return self._searched[1]
        self.n_evaluations += found.n_evaluations
        self.cancelled = found.stop_reason == "cancelled"
        if self._searched is not None:
            before = self._searched[1].u
            if np.abs(found.u[::-1] - before).sum() < np.abs(found.u - before).sum():
                found = replace(found, u=found.u[::-1].copy())
        self._searched = surrogate, found
        return found

    def _promises_more(self, found: Found) -> bool:
        return found.value > self.samples.best * (1.0 + _WORTH)

    def _is_new(self, found: Found) -> bool:
        return not all(self.samples.known(u) for u in found.u)

    def _check(self, found: Found) -> None:
        """Compute an optimum in the true model."""
        samples = self.samples
        predicted = samples.surrogate(found.u)
        fresh = [k for k in (0, 1) if not samples.known(found.u[k])]
        if fresh:
            samples.add(found.u[fresh])
        f = pair_value(samples.values[samples.places_of(found.u)], self._weights)
        model = f if np.isfinite(f) else None
        self.rounds.append(
            RepairRound(
                n_models=samples.n_added,
                objective_surrogate=found.value,
                objective_model=model,
                gap_percent=gap_percent(found.value, model),
            )
        )
        self.last, self.predicted = found, predicted

    def _base(self, found: Found) -> tuple[FloatArray, FloatArray]:
        """Return the pair whose inputs are worth a trial, and its outputs as far as known.

        That is the best known pair, unless the optimum fails and nothing near it is known.
        """
        samples = self.samples
        if self._is_new(found) or samples.best > _NEAR * found.value:
            places = list(samples.best_places)
            u, y = samples.points[places], samples.values[places]
            apart = [np.abs(u[k] - found.u[0]).sum() for k in (0, 1)]
            return (u, y) if apart[0] <= apart[1] else (u[::-1], y[::-1])
        y = samples.values[samples.places_of(found.u)]
        return found.u, np.where(np.isfinite(y), y, samples.surrogate(found.u))

    def _try_one(self, u: FloatArray, y: FloatArray) -> bool:
        """Compute the most promising change of one input; return whether there was one."""
        trials = self._trials(u, y)
        if not trials:
            return False
        _, trial = max(trials, key=lambda t: t[0])
        reached = float((self.samples.add(trial.u[None])[0] * trial.sums).sum())
        self._tried[trial.half].add(trial.place)
        if np.isfinite(reached):
            self._errors[trial.half][trial.place] = reached - trial.predicted
        return True

    def _trials(self, u: FloatArray, y: FloatArray) -> list[tuple[float, _Trial]]:
        """Return the changes not tried yet, each with its expected improvement."""
        samples = self.samples
        signs = np.where(y[0] >= y[1], 1.0, -1.0) * self._weights
        scale = abs(pair_value(y, self._weights)) + np.finfo(float).tiny
        trials = []
        for half, sums in enumerate((signs, -signs)):
            thrown = np.repeat(u[half][None], len(u[half]), axis=0)
            np.fill_diagonal(thrown, 1.0 - np.round(u[half]))
            predicted = (samples.surrogate(thrown) * sums).sum(axis=1)
            error = self._error(half, len(thrown), _FIRST_ERROR * scale)
            gains = _expected_improvement((y[half] * sums).sum() - predicted, error)
            trials += [
                (
                    float(gains[k]),
                    _Trial(half=half, place=k, u=thrown[k], sums=sums, predicted=predicted[k]),
                )
                for k in range(len(thrown))
                if k not in self._tried[half] and not samples.known(thrown[k])
            ]
        return trials

    def _error(self, half: int, n: int, first: float) -> FloatArray:
        """Return what the prediction of each input's trial is wrong by, root mean square, (n,).

        That is what trials of the same model have shown; an input that was mistaken for the other
        model is likely to be mistaken here.
        """
        seen = self._errors[half]
        total = _FIRST_WEIGHT * first**2 + sum(e * e for e in seen.values())
        squares, counts = np.full(n, total), np.full(n, _FIRST_WEIGHT + len(seen))
        for k, error in self._errors[1 - half].items():
            squares[k] += _OTHER_WEIGHT * error * error
            counts[k] += _OTHER_WEIGHT
        errors: FloatArray = np.sqrt(squares / counts)
        return errors

    def history(self) -> Repair:
        return Repair(
            goal_percent=self._goal,
            max_models=self._max,
            n_models=self.samples.n_added,
            n_failed=self.samples.n_failed,
            rounds=tuple(self.rounds),
        )


def _searcher(problem: Problem, samples: _Samples) -> Search:
    """Return the search of a surrogate by the method of the settings."""
    settings = problem.settings

    def watch(report: Progress) -> object:
        return problem.callback is not None and problem.callback(
            Progress(
                stage="repair",
                done=samples.n_added,
                total=settings.n_repair,
                best=samples.best,
                run=report.run,
            )
        )

    def search(surrogate: Surrogate) -> Found:
        if settings.method == "exact":
            return climb_surrogate(problem, surrogate, watch)
        pair = SurrogatePair(surrogate, problem.weights, problem.threads)
        return search_pair(pair, surrogate.n_dimensions, settings, watch)

    return search


def find_repaired_pair(problem: Problem) -> Outcome:
    """Find the most different pair of a surrogate that is repaired on the way.

    Of the last optimum and the best known pair, the one with the larger f in the true model is
    returned.
    """
    first = train(problem.model, problem.settings, problem.callback)
    samples = _Samples(problem.model, first, problem.weights)
    search = _searcher(problem, samples)
    repairing = _Repairing(samples, search, problem.weights, problem.settings)
    begun = time.perf_counter()
    repairing.run()
    return _outcome(repairing, first, problem.weights, time.perf_counter() - begun)


def _outcome(
    repairing: _Repairing, first: Training, weights: FloatArray, seconds: float
) -> Outcome:
    samples, last = repairing.samples, repairing.last
    places = list(samples.best_places) if last is None else samples.places_of(last.u)
    f, predicted = pair_value(samples.values[places], weights), repairing.predicted
    as_searched = f >= samples.best
    if predicted is None or not as_searched:
        places = list(samples.best_places)
        f, predicted = samples.best, samples.surrogate(samples.points[places])
    repair = repairing.history()
    reason = "repaired" if repair.reached else "not_repaired"
    found = Found(
        u=samples.points[places],
        run_values=last.run_values if last else (samples.best,),
        best_run=last.best_run if last else 0,
        history=last.history if last else np.array([samples.best]),
        n_evaluations=repairing.n_evaluations,
        stop_reason="cancelled" if repairing.cancelled else reason,
        evidence=last.evidence if last is not None and as_searched else None,
    )
    return Outcome(
        found=found,
        y=samples.values[places],
        y_surrogate=predicted,
        objective_surrogate=last.value if last else pair_value(predicted, weights),
        objective_model=f if np.isfinite(f) else None,
        training=replace(
            first, surrogate=samples.surrogate, points=samples.points, values=samples.values
        ),
        seconds={
            "sampling": first.seconds_sampling,
            "fit": first.seconds_fit,
            "search": seconds,
            "verify": 0.0,
        },
        repair=repair,
    )
