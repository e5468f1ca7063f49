"""The worst pair of a model of one's own, by batches of runs where a surrogate promises more.

Where that is: `kneecore.search.inside`. How far to trust the end: `kneecore.search.verdict`.
"""

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kneecore.numerics.kriging import Kriging, likely
from kneecore.numerics.surrogate import Surrogate
from kneecore.progress import Cancelled, Clock, Progress
from kneecore.search.checks import MOST, Checks, looked_at
from kneecore.search.discrete import combinations
from kneecore.search.exact_search import climb_surrogate
from kneecore.search.inside import Half, best_places, highest, is_new, thrown
from kneecore.search.problem import Found, Outcome, Problem, pair_value
from kneecore.search.result import Repair, RepairRound, Verdict, gap_percent
from kneecore.search.settings import SearchSettings
from kneecore.search.training import Training, train
from kneecore.search.verdict import Seen, judged, ranks_of

__all__ = ["find_inside_pair"]

FloatArray = NDArray[np.float64]

_WORTH = 2e-4  # of f: a place that promises less above the best run is not computed
_GAIN = 1e-3  # of f: a smaller gain is none
_QUIET = 24  # runs without a gain after which a search may end, at least
_MEMORY = 0.8  # of a half's earlier errors after each run
_FIRST_ERROR = 0.05  # of f
_FLAT = 1e-12  # of the outputs' size: smaller differences are rounding
_GROWTH = 1.05  # of the runs, before the surrogate's lengths are looked for again
_PAIR = 2
_N_ANYWHERE = 200  # random points, where nothing else is new
_DEVIATIONS = 2.0  # above the mean: what counts as possible
_ROUGH = 0.1  # of f: where a left-out run errs by more, a jump is looked for


class _Search:
    """The state of one search."""

    def __init__(self, problem: Problem, training: Training) -> None:
        self._problem, self._weights, self.box = problem, problem.weights, problem.model.model
        self.points, self.values = training.points, training.values
        self.n_first = len(training.points)
        self._rng = np.random.default_rng([problem.settings.seed, 1])
        self._halves: dict[tuple[float, ...], list[Half]] = {}
        self._theta: FloatArray | None = None
        self._lengths_due = 0.0
        self.rounds: list[RepairRound] = []
        self.history: list[float] = []
        self.cancelled = self.exhausted = False
        self.checks = Checks()
        self.n_failed_best = 0
        self._clock = Clock()
        self._last_gain = self.n_first
        self.look()

    def look(self) -> None:
        """See which pair is the best, and what the surrogate of its signs promises."""
        i, j, best = best_places(self.values, self._weights)
        if self.history and best > self.history[-1] * (1.0 + _GAIN):
            self._last_gain = len(self.points)
        self.places, self.best, self.promised = [i, j], best, best
        self.history.append(best)
        self.halves = self._halves_of(self.values[i], self.values[j])
        if self.constant:
            return
        self.process = self._fitted(self.halves[0].sums)
        self._tops = [self._highest(half, 0.0) for half in self.halves]
        self.promised = max(float(sum(values[0] for _, values in self._tops)), best)
        self._others = self._of_other_signs()
        if self._others is not None:
            self.promised = max(self.promised, self._others.value)

    def _of_other_signs(self) -> Found | None:
        """Return the pair that a surrogate of all outputs promises, whatever the signs."""
        if np.count_nonzero(self._weights) == 1:
            return None
        good = np.isfinite(self.values).all(axis=1)
        return climb_surrogate(self._problem, Surrogate.fit(self.points[good], self.values[good]))

    def _halves_of(self, one: FloatArray, two: FloatArray) -> list[Half]:
        signs = np.where(one >= two, 1.0, -1.0)
        signs *= signs[0] * self._weights
        key = tuple(signs.tolist())
        if key not in self._halves:
            error, d = _FIRST_ERROR * max(self.best, 0.0), self.points.shape[1]
            self._halves[key] = [Half(s * signs, s, d, error) for s in (1.0, -1.0)]
            self._lengths_due = 0.0
        return self._halves[key]

    def _fitted(self, signs: FloatArray) -> Kriging:
        """Fit the signed sum of the outputs; where a run failed it is taken to be middling."""
        sums = self.values @ signs
        good = np.isfinite(sums)
        if self._theta is None or len(sums) >= self._lengths_due:
            self._theta = likely(self.points[good], sums[good], self._theta)
            self._lengths_due = _GROWTH * len(sums)
        return Kriging(self.points, np.where(good, sums, np.median(sums[good])), self._theta)

    def _highest(self, half: Half, deviations: float) -> tuple[FloatArray, FloatArray]:
        return highest(self.process, half, deviations, self._best_of(half), self._rng, self.box)

    def _best_of(self, half: Half) -> FloatArray:
        best: FloatArray = self.points[int(np.nanargmax(self.values @ half.sums))]
        return best

    @property
    def possible(self) -> float:
        """The largest f within two standard deviations of the surrogate."""
        tops = (self._highest(half, _DEVIATIONS)[1][0] for half in self.halves)
        return max(float(sum(tops)), self.best)

    @property
    def n_added(self) -> int:
        return len(self.points) - self.n_first

    @property
    def constant(self) -> bool:
        size = float(np.nanmax(np.abs(self.values) @ self._weights))
        return self.best <= _FLAT * size

    @property
    def quiet(self) -> bool:
        """Whether runs have found nothing for long, and what was found would be trusted."""
        patience = max(_QUIET, 2 * self.points.shape[1])
        goal = self._problem.settings.repair_gap_percent
        return (
            len(self.points) - self._last_gain >= patience
            and 100.0 * (self.promised - self.best) <= goal * self.promised
            and judged(_seen(self)).word == "trusted"
        )

    def ranks(self, n: int | None = None) -> float | None:
        """Return the rank correlation of the first n runs, or all, with what the others predict."""
        sums = self.values @ self.halves[0].sums
        good = np.flatnonzero(np.isfinite(sums[:n]))
        return ranks_of(sums[good], (sums + self.process.loo_errors)[good])

    @property
    def _rough(self) -> bool:
        return bool(np.abs(self.process.loo_errors).max() > _ROUGH * self.best)

    @property
    def _n_kept(self) -> int:
        """Runs that are kept for the checks."""
        enough = self._problem.settings.n_repair > 2 * MOST
        return (MOST if self._rough else _PAIR) if enough else 0

    def run(self) -> None:
        """Compute batches until nothing is left to find or the runs are used up, then check."""
        settings = self._problem.settings
        allowed = settings.n_repair
        try:
            while not self.constant and not self.quiet and not self.exhausted:
                left = allowed - self.n_added - self._n_kept
                if left <= 0:
                    break
                self._batch(min(settings.repair_batch, left))
            if not self.constant and self._n_kept:
                self._check()
        except Cancelled:
            self.cancelled = True

    def _check(self) -> None:
        left = self._problem.settings.n_repair - self.n_added
        self.checks = looked_at(
            self._run,
            self.points,
            self.values,
            self.places,
            self.halves[0].sums,
            rough=self._rough and left >= MOST and not self.box.grids,
        )

    def _run(self, u: FloatArray) -> FloatArray:
        """Run the model; raises `Cancelled`, also between two runs."""
        self._tell(0)
        return self._problem.model(u, self._tell)

    def _tell(self, done: int) -> bool:
        """Report so many runs more than are known; raise `Cancelled` if that is to be the end."""
        allowed, done = self._problem.settings.n_repair, self.n_added + done
        report = Progress(
            stage="repair",
            done=done,
            total=allowed,
            best=self.best,
            n_models=self.n_first + done,
            seconds_left=self._clock.left(done, allowed - done),
        )
        if self._problem.callback is not None and self._problem.callback(report):
            raise Cancelled
        return False

    def _batch(self, size: int) -> None:
        chosen = self._optima()[:size]
        n_optima = len(chosen)
        while len(chosen) < size:
            half = self._doubtful_half()
            u = self._trial(half, [u for _, u in chosen])
            if u is None:
                break
            chosen.append((half, u))
        if not chosen:
            self.exhausted = True
            return
        u = np.vstack([point for _, point in chosen])
        predicted = self.process(u)[0]
        y = self._run(u)
        self._learn([half for half, _ in chosen], predicted, y)
        promised = self.promised
        self.points, self.values = np.vstack([self.points, u]), np.vstack([self.values, y])
        failed = ~np.isfinite(y[:n_optima]).all(axis=1)
        self.n_failed_best += int(np.count_nonzero(failed))
        self.look()
        if n_optima or not self.rounds:
            self.rounds.append(self._round(promised, None if failed.any() else self.best))

    def _round(self, promised: float, model: float | None) -> RepairRound:
        return RepairRound(
            n_models=self.n_added,
            objective_surrogate=promised,
            objective_model=model,
            gap_percent=gap_percent(promised, model),
        )

    def _optima(self) -> list[tuple[Half, FloatArray]]:
        """Return the points where the surrogate promises more than is known."""
        chosen: list[tuple[Half, FloatArray]] = []
        for half, (ends, values) in zip(self.halves, self._tops, strict=True):
            known = np.vstack([self.points, *(u for _, u in chosen)])
            least = float(np.nanmax(self.values @ half.sums)) + _WORTH * self.best
            new = [u for u, v in zip(ends, values, strict=True) if v > least and is_new(u, known)]
            if new:
                chosen.append((half, new[0]))
        if self._others is not None and self._others.value > self.best * (1.0 + _GAIN):
            for half, u in zip(self.halves, self._others.u, strict=True):
                if is_new(u, np.vstack([self.points, *(v for _, v in chosen)])):
                    chosen.append((half, u))
        return chosen

    def _trial(self, half: Half, chosen: list[FloatArray]) -> FloatArray | None:
        """Return a point that may be better than the surrogate says; None if all are known."""
        known = np.vstack([self.points, *chosen])
        deviations = half.deviations()
        if deviations is None:
            ends = thrown(self.process, half, self._best_of(half), self.box)[None]
        else:
            ends, _ = self._highest(half, deviations)
        anywhere = self.box.snapped(self._rng.random((_N_ANYWHERE, self.points.shape[1])))
        return next((u for u in (*ends, *anywhere) if is_new(u, known)), None)

    def _doubtful_half(self) -> Half:
        """Draw a half, the more often the more its predictions have been wrong of late."""
        one, two = (h.error for h in self.halves)
        floor = 0.05 * (one + two)
        share = (one + floor) / (one + two + 2.0 * floor) if floor > 0.0 else 0.5
        return self.halves[0 if self._rng.random() < share else 1]

    def _learn(self, halves: list[Half], predicted: FloatArray, y: FloatArray) -> None:
        for half, foreseen, reached in zip(halves, predicted, y, strict=True):
            error = abs(float(reached @ half.sums) - half.sign * foreseen)
            if np.isfinite(error):
                half.error = _MEMORY * half.error + (1.0 - _MEMORY) * error


def find_inside_pair(problem: Problem) -> Outcome:
    """Find the most different pair by runs where a surrogate promises more or is unsure."""
    first = train(problem.model, problem.settings, problem.callback)
    begun = time.perf_counter()
    search = _Search(problem, first)
    search.run()
    return _outcome(problem, search, first, time.perf_counter() - begun)


def _outcome(problem: Problem, search: _Search, first: Training, seconds: float) -> Outcome:
    settings, places = problem.settings, search.places
    found = bool(np.isfinite(search.best))
    search.rounds.append(search._round(search.promised, search.best if found else None))
    reason = "repaired" if _repair(search, settings).reached else "not_repaired"
    good = np.isfinite(search.values).all(axis=1)
    surrogate = Surrogate.fit(search.points[good], search.values[good])
    u = search.points[places]
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
        y_surrogate=surrogate(u),
        objective_surrogate=search.promised,
        objective_model=pair_value(search.values[places], problem.weights) if found else None,
        training=replace(first, surrogate=surrogate, points=search.points, values=search.values),
        seconds={
            "sampling": first.seconds_sampling,
            "fit": first.seconds_fit,
            "search": seconds,
            "verify": 0.0,
        },
        repair=_repair(search, settings),
        verdict=_verdict(search),
    )


def _verdict(search: _Search) -> Verdict:
    if search.constant:
        return judged(None)
    all_run = len(search.points) == combinations(search.box)
    if all_run and np.isfinite(search.values).all():
        return Verdict(word="trusted")
    return judged(_seen(search))


def _repair(search: _Search, settings: SearchSettings) -> Repair:
    added = search.values[search.n_first :]
    return Repair(
        goal_percent=settings.repair_gap_percent,
        max_models=settings.n_repair,
        n_models=search.n_added,
        n_failed=int(np.count_nonzero(~np.isfinite(added).all(axis=1))),
        n_checked=search.checks.n_models,
        n_checked_failed=search.checks.n_failed,
        rounds=tuple(search.rounds),
    )


def _seen(search: _Search) -> Seen:
    checks, failed = search.checks, ~np.isfinite(search.values).all(axis=1)
    return Seen(
        history=search.history,
        promised=search.promised,
        possible=search.possible,
        ranks=search.ranks(),
        first_ranks=search.ranks(search.n_first),
        n_runs=len(search.points),
        n_inputs=search.points.shape[1],
        n_failed=int(np.count_nonzero(failed)),
        n_failed_best=search.n_failed_best,
        error=sum(half.error for half in search.halves) / search.best,
        noise=checks.noise,
        jump=checks.jump,
        jump_width=checks.width,
    )
