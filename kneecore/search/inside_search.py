"""A surrogate of a model of one's own, repaired by batches of runs.

How the runs are chosen is in `kneecore.search.inside`.
"""

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Progress
from kneecore.search.discrete import combinations
from kneecore.search.inside import Half, best_places, climbed, is_new, trial
from kneecore.search.problem import Found, Outcome, Problem, pair_value
from kneecore.search.result import Repair, RepairRound, Verdict, gap_percent
from kneecore.search.training import Training, train
from kneecore.search.verdict import judged

__all__ = ["find_inside_pair"]

FloatArray = NDArray[np.float64]

_WORTH = 2e-4  # of f: a climb that promises less above the best sample is not computed
_GAIN = 1e-3  # of f: a smaller gain is none
_QUIET = 24  # runs without a gain after which a search may end, at least
_MEMORY = 0.8  # of a half's earlier errors after each run
_FIRST_ERROR = 0.05  # of f
_FLAT = 1e-12  # of the outputs' size: smaller differences are rounding


class _Search:
    """The state of one search."""

    def __init__(self, problem: Problem, training: Training) -> None:
        self._problem, self._weights, self._box = problem, problem.weights, problem.model.model
        self.points, self.values = training.points, training.values
        self.n_first = len(training.points)
        self._rng = np.random.default_rng([problem.settings.seed, 1])
        self._halves: dict[tuple[float, ...], Half] = {}
        self.rounds: list[RepairRound] = []
        self.history: list[float] = []
        self.cancelled = self.exhausted = False
        self._last_gain = self.n_first
        self.look()

    def look(self) -> None:
        """Fit again, and see what is the best pair and what the surrogate promises."""
        good = np.isfinite(self.values).all(axis=1)
        self.surrogate = Surrogate.fit(self.points[good], self.values[good])
        i, j, best = best_places(self.values, self._weights)
        if self.history and best > self.history[-1] * (1.0 + _GAIN):
            self._last_gain = len(self.points)
        self.places, self.best = [i, j], best
        self.history.append(best)
        y = self.values[self.places]
        signs = np.where(y[0] >= y[1], 1.0, -1.0) * self._weights
        self.halves = [self._half(signs), self._half(-signs)]
        fitted = self.points[good]
        self._climbs = [
            climbed(self.surrogate, h, fitted, self._rng, self._box) for h in self.halves
        ]
        promised = float(sum(values[0] for _, values in self._climbs))
        self.promised = max(promised, best)

    def _half(self, sums: FloatArray) -> Half:
        return self._halves.setdefault(
            tuple(sums.tolist()), Half(sums, error=_FIRST_ERROR * max(self.best, 0.0))
        )

    @property
    def n_added(self) -> int:
        return len(self.points) - self.n_first

    @property
    def constant(self) -> bool:
        size = float(np.nanmax(np.abs(self.values) @ self._weights))
        return self.best <= _FLAT * size

    @property
    def quiet(self) -> bool:
        """Whether runs have found nothing for long, and the surrogate promises nothing."""
        patience = max(_QUIET, 2 * self.points.shape[1])
        goal = self._problem.settings.repair_gap_percent
        return (
            len(self.points) - self._last_gain >= patience
            and 100.0 * (self.promised - self.best) <= goal * self.promised
        )

    @property
    def _done(self) -> bool:
        return self.constant or self.quiet or self.exhausted

    def run(self) -> None:
        """Compute batches until nothing is left to find or the runs are used up."""
        settings = self._problem.settings
        while self.n_added < settings.repair_models and not self._done:
            if self._told():
                self.cancelled = True
                return
            self._batch(min(settings.repair_batch, settings.repair_models - self.n_added))

    def _told(self) -> bool:
        callback, allowed = self._problem.callback, self._problem.settings.repair_models
        return callback is not None and bool(
            callback(
                Progress(
                    stage="repair",
                    done=self.n_added,
                    total=allowed,
                    best=self.best,
                    n_models=len(self.points),
                )
            )
        )

    def _batch(self, size: int) -> None:
        points, halves = self._optima()
        n_optima = len(points)
        if n_optima > size:
            points, halves, n_optima = points[:size], halves[:size], size
        while len(points) < size:
            half = self._doubtful_half()
            known = np.vstack([self.points, *points])
            sums = self.values @ half.sums
            base = self.points[int(np.nanargmax(sums))]
            chosen = trial(self.surrogate, half, base, known, self._rng, self._box)
            if chosen is None:
                self.exhausted = not points
                break
            points.append(chosen[None])
            halves.append(half)
        if self.exhausted:
            return
        u = np.vstack(points)
        predicted = self.surrogate(u)
        y = self._problem.model(u)
        self._learn(halves, predicted, y, n_optima)
        promised = self.promised
        self.points, self.values = np.vstack([self.points, u]), np.vstack([self.values, y])
        failed = not np.isfinite(y[:n_optima]).all()
        self.look()
        if n_optima or not self.rounds:
            model = None if failed else self.best
            self.rounds.append(self._round(promised, model))

    def _round(self, promised: float, model: float | None) -> RepairRound:
        return RepairRound(
            n_models=self.n_added,
            objective_surrogate=promised,
            objective_model=model,
            gap_percent=gap_percent(promised, model),
        )

    def _optima(self) -> tuple[list[FloatArray], list[Half]]:
        """Return the points where the surrogate promises more than is known."""
        points: list[FloatArray] = []
        halves = []
        for half, (ends, values) in zip(self.halves, self._climbs, strict=True):
            known = np.vstack([self.points, *points])
            least = float(np.nanmax(self.values @ half.sums)) + _WORTH * self.best
            new = [u for u, v in zip(ends, values, strict=True) if v > least and is_new(u, known)]
            if new:
                points.append(new[0][None])
                halves.append(half)
        return points, halves

    def _doubtful_half(self) -> Half:
        """Draw a half, the more often the more its predictions have been wrong of late."""
        one, two = (h.error for h in self.halves)
        floor = 0.05 * (one + two)
        share = (one + floor) / (one + two + 2.0 * floor) if floor > 0.0 else 0.5
        return self.halves[0 if self._rng.random() < share else 1]

    def _learn(
        self, halves: list[Half], predicted: FloatArray, y: FloatArray, n_optima: int
    ) -> None:
        for k, half in enumerate(halves):
            reached = float(y[k] @ half.sums)
            if not np.isfinite(reached):
                continue
            error = abs(reached - float(predicted[k] @ half.sums))
            half.error = _MEMORY * half.error + (1.0 - _MEMORY) * error
            if k >= n_optima:
                best = float(np.nanmax(self.values @ half.sums))
                half.learn(reached > best + _GAIN * self.best)


def find_inside_pair(problem: Problem) -> Outcome:
    """Find the most different pair by runs where the surrogate promises most or errs most."""
    first = train(problem.model, problem.settings, problem.callback)
    begun = time.perf_counter()
    search = _Search(problem, first)
    search.run()
    return _outcome(problem, search, first, time.perf_counter() - begun)


def _verdict(problem: Problem, search: _Search, training: Training) -> Verdict:
    all_run = len(training.points) == combinations(problem.model.model) and not training.n_failed
    if all_run and not search.constant:
        return Verdict(word="trusted", reasons=())
    return judged(search.history, training, problem.weights, search.halves, search.promised)


def _outcome(problem: Problem, search: _Search, first: Training, seconds: float) -> Outcome:
    settings, places = problem.settings, search.places
    found = bool(np.isfinite(search.best))
    search.rounds.append(search._round(search.promised, search.best if found else None))
    added = search.values[search.n_first :]
    repair = Repair(
        goal_percent=settings.repair_gap_percent,
        max_models=settings.repair_models,
        n_models=search.n_added,
        n_failed=int(np.count_nonzero(~np.isfinite(added).all(axis=1))),
        rounds=tuple(search.rounds),
    )
    reason = "repaired" if repair.reached else "not_repaired"
    training = replace(
        first, surrogate=search.surrogate, points=search.points, values=search.values
    )
    u = search.points[places]
    predicted = search.surrogate(u)
    return Outcome(
        found=Found(
            u=u,
            run_values=(search.best,),
            best_run=0,
            history=np.array(search.history),
            n_evaluations=0,
            stop_reason="cancelled" if search.cancelled else reason,
        ),
        y=search.values[places],
        y_surrogate=predicted,
        objective_surrogate=search.promised,
        objective_model=pair_value(search.values[places], problem.weights) if found else None,
        training=training,
        seconds={
            "sampling": first.seconds_sampling,
            "fit": first.seconds_fit,
            "search": seconds,
            "verify": 0.0,
        },
        repair=repair,
        verdict=_verdict(problem, search, training),
    )
