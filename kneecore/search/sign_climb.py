"""The worst case by exact gradients: two climbs instead of one search over pairs.

f(x_1, x_2) = sum w |y(x_1) - y(x_2)| is the largest of sum s w (y(x_1) - y(x_2)) over all patterns
of signs s, and for one pattern the two models have nothing to do with each other: one maximises
sum s w y, the other minimises it. So the worst case is two climbs over d inputs for each pattern,
not one search over 2 d.

Patterns
    Outputs that belong to neighbouring loads change together, so only patterns that change their
    sign at most once along the loads are begun with: one curve above the other everywhere, or the
    two crossing once between any two loads. A pair that is found is judged by its own signs; if
    they are others, that pattern is climbed too, so that two crossings are found where they pay.
Basins
    From random starts nearly all climbs of a half end in one corner of the cube, yet a slightly
    higher one may be near, that few starts lead to. So the best corners are left again with a few
    inputs thrown to their other bound, and climbed from there, until that finds nothing for
    several rounds.
Evidence
    What the search says about itself is in `Evidence`. It is no proof: bounds that hold for sure
    are far too wide to be of use.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.numerics.box_climb import Slopes, climb, polish
from kneecore.numerics.sampling_options import check_count, check_seed
from kneecore.progress import Cancelled
from kneecore.search.result import Evidence

__all__ = [
    "ExactPair",
    "ExactSettings",
    "Half",
    "Report",
    "climb_pair",
    "sign_patterns",
]

FloatArray = NDArray[np.float64]

Report = Callable[[float, int], object]
SAME = 1e-4
"""Values are of one basin if they differ by less than this share of f."""


@dataclass(frozen=True, kw_only=True)
class ExactSettings:
    """How much to look for."""

    n_starts: int = 8
    """Random starts of each half of each pattern."""
    n_kicks: int = 48
    """Climbs of a round that leave a half's best corner."""
    quiet_rounds: int = 2
    """Rounds without a find after which a half is left alone."""
    max_rounds: int = 12
    near: float = 0.85
    """Patterns below this share of the best one are not looked at further."""
    thorough: bool = False
    """Whether to evolve for longer where bounds are so wide that models fail within them."""
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("n_starts", "n_kicks", "quiet_rounds", "max_rounds"):
            check_count(name, getattr(self, name))
        check_seed(self.seed)


@dataclass(eq=False)
class Half:
    """The best point for one weighted sum of outputs, and every end of a climb to it."""

    weights: FloatArray
    u: FloatArray
    value: float
    y: FloatArray
    ends: list[float] = field(default_factory=list)
    """Values in which climbs have ended."""
    corners: list[FloatArray] = field(default_factory=list)
    """A point of each basin that was ever the best."""

    def take(self, u: FloatArray, values: FloatArray, y: FloatArray, scale: float) -> bool:
        """Take in ended climbs; return whether the best is better than before."""
        self.ends += [float(v) for v in values if np.isfinite(v)]
        k = int(np.argmax(values))
        if not values[k] > self.value:
            return False
        found = bool(values[k] > self.value + SAME * scale)
        if found or not self.corners:
            self.corners.append(u[k].copy())
        self.u, self.value, self.y = u[k].copy(), float(values[k]), y[k].copy()
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class ExactPair:
    """The most different pair found."""

    u: FloatArray
    """The two models, shape (2, d), unit cube."""
    y: FloatArray
    """Their outputs, shape (2, m)."""
    value: float
    """f"""
    evidence: Evidence
    halves: tuple[tuple[Half, Half], ...]
    """The climbs of each pattern, the best pattern's first."""


def sign_patterns(weights: FloatArray, order: Sequence[int] | None = None) -> FloatArray:
    """Return the patterns that change sign at most once along the outputs that count.

    Parameters
    ----------
    weights : ndarray, shape (m,)
        Weight of each output's difference; those of 0 do not count.
    order : sequence of int, optional
        The outputs in the order in which they change together; their own order for None.

    Returns
    -------
    ndarray, shape (n_counting, m)
        Signs +1 and -1; outputs that do not count have +1. A pattern and its negative are one.
    """
    along = np.arange(len(weights)) if order is None else np.array(order)
    along = along[weights[along] != 0.0]
    patterns = np.ones((max(1, len(along)), len(weights)))
    for k in range(1, len(along)):
        patterns[k, along[:k]] = -1.0
    return patterns


class _Ended(Exception):
    """The report has asked for the search's end."""


class _Search:
    """The state of one search."""

    def __init__(
        self,
        slopes: Slopes,
        n_dimensions: int,
        weights: FloatArray,
        settings: ExactSettings,
        report: Report | None,
    ) -> None:
        self._slopes, self._report = slopes, report
        self.d, self.weights, self.settings = n_dimensions, weights, settings
        self.rng = np.random.default_rng(settings.seed)
        self.n_evaluations = 0
        self.halves: list[tuple[FloatArray, Half, Half]] = []

    def slopes(self, u: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        # Between any two batches: in wide bounds, where models lose their equilibrium, a single
        # climb may take seconds.
        if self._report is not None and self._report(self.best(), self.n_evaluations):
            raise _Ended
        return self._slopes(u, w)

    def known(self, signs: FloatArray) -> bool:
        counts = self.weights != 0.0
        mine = signs[counts]
        return any(
            np.array_equal(s[counts], mine) or np.array_equal(s[counts], -mine)
            for s, _, _ in self.halves
        )

    def begin(self, patterns: FloatArray, starts: FloatArray) -> None:
        """Climb both halves of each of `patterns` from all `starts`."""
        signed = (patterns[:, None, :] * np.array([1.0, -1.0])[:, None]) * self.weights
        weights = signed.reshape(-1, len(self.weights))
        n = len(starts)
        ends = climb(self.slopes, np.tile(starts, (len(weights), 1)), np.repeat(weights, n, axis=0))
        self.n_evaluations += ends.n_evaluations
        halves = []
        for k, w in enumerate(weights):
            half = Half(w, starts[0], -np.inf, np.full(len(w), np.nan))
            part = slice(k * n, (k + 1) * n)
            half.take(ends.u[part], ends.values[part], ends.outputs[part], 1.0)
            halves.append(half)
        for k, pattern in enumerate(patterns):
            self.halves.append((pattern, halves[2 * k], halves[2 * k + 1]))

    def best(self) -> float:
        return max((a.value + b.value for _, a, b in self.halves), default=-np.inf)

    def near(self) -> list[Half]:
        """Return the halves of the patterns that are worth a closer look."""
        limit = self.settings.near * self.best()
        return [h for _, a, b in self.halves if a.value + b.value >= limit for h in (a, b)]

    def kick(self) -> None:
        """Leave the best corners until nothing better is found."""
        quiet: dict[int, int] = {}
        n = self.settings.n_kicks
        for _ in range(self.settings.max_rounds):
            waiting = [h for h in self.near() if quiet.get(id(h), 0) < self.settings.quiet_rounds]
            if not waiting:
                return
            starts = np.concatenate([self._kicked(h.u, n) for h in waiting])
            weights = np.repeat([h.weights for h in waiting], n, axis=0)
            ends = climb(self.slopes, starts, weights, first_reach=1.0)
            self.n_evaluations += ends.n_evaluations
            scale = self.best()
            for k, half in enumerate(waiting):
                part = slice(k * n, (k + 1) * n)
                found = half.take(ends.u[part], ends.values[part], ends.outputs[part], scale)
                quiet[id(half)] = 0 if found else quiet.get(id(half), 0) + 1

    def _kicked(self, u: FloatArray, n: int) -> FloatArray:
        """Return `n` copies of `u` with two to six inputs, on average, at their other bound."""
        shares = self.rng.integers(2, 7, n) / self.d
        thrown = self.rng.random((n, self.d)) < shares[:, None]
        return np.where(thrown, 1.0 - np.round(u), u)

    def polish(self) -> None:
        for half in self.near():
            end = polish(self.slopes, half.u, half.weights)
            self.n_evaluations += end.n_evaluations
            if end.values[0] > half.value:
                half.u, half.value, half.y = end.u[0], float(end.values[0]), end.outputs[0]

    def pair_value(self, a: Half, b: Half) -> float:
        return float((self.weights * np.abs(a.y - b.y)).sum())

    def unclimbed(self) -> list[tuple[FloatArray, FloatArray]]:
        """Return the signs of good pairs that have others than they were climbed for; their ends.

        With its own signs a pair is worth more than with those of its pattern.
        """
        limit = self.settings.near * self.best()
        found = []
        for _, a, b in self.halves:
            signs = np.where(a.y >= b.y, 1.0, -1.0)
            if self.pair_value(a, b) >= limit and not self.known(signs):
                found.append((signs, np.stack([a.u, b.u])))
        return found

    def evidence(self, ranked: list[tuple[FloatArray, Half, Half]]) -> Evidence:
        _, a, b = ranked[0]
        f = self.pair_value(a, b)
        reached = sum(v >= h.value - SAME * f for h in (a, b) for v in h.ends)
        n_climbs = len(a.ends) + len(b.ends)
        lower = [v for h in (a, b) for v in h.ends if v < h.value - SAME * f]
        losses = [h.value - v for h in (a, b) for v in h.ends if v < h.value - SAME * f]
        same = f - min(losses) if lower else -np.inf
        other = max((p.value + q.value for _, p, q in ranked[1:]), default=-np.inf)
        second = max(same, other)
        return Evidence(
            n_climbs=n_climbs,
            share_reached=reached / n_climbs,
            second_best=float(second) if np.isfinite(second) else None,
            patterns=tuple(
                (tuple(int(v) for v in s), float(p.value + q.value))
                for s, p, q in ranked
                if np.isfinite(p.value + q.value)
            ),
            n_evaluations=self.n_evaluations,
        )


def climb_pair(
    slopes: Slopes,
    n_dimensions: int,
    weights: FloatArray,
    *,
    order: Sequence[int] | None = None,
    settings: ExactSettings | None = None,
    report: Report | None = None,
) -> ExactPair:
    """Find the two points of the unit cube whose outputs differ most.

    Parameters
    ----------
    slopes : callable
        See `kneecore.numerics.box_climb.Slopes`.
    n_dimensions : int
        d
    weights : ndarray, shape (m,)
        Weight of each output's difference, none negative.
    order : sequence of int, optional
        As for `sign_patterns`.
    settings : ExactSettings, optional
    report : callable, optional
        Called before each batch of models with the best f so far, minus infinity before the first
        climbs have ended, and the models that it took; a true result ends the search with what it
        has.

    Raises
    ------
    ModelError
        If no model could be evaluated.
    Cancelled
        If `report` ended the search before there was a pair.
    """
    settings = settings or ExactSettings()
    search = _Search(slopes, n_dimensions, weights, settings, report)
    starts = search.rng.random((settings.n_starts, n_dimensions))
    try:
        search.begin(sign_patterns(weights, order), starts)
        if not np.isfinite(search.best()):
            raise ModelError("no model of the search could be evaluated: all of them failed")
        for _ in range(4):
            search.kick()
            search.polish()
            fresh = search.unclimbed()
            if not fresh:
                break
            for signs, ends in fresh:
                if not search.known(signs):
                    search.begin(signs[None], np.concatenate([ends, starts]))
    except _Ended:
        if not search.halves:
            raise Cancelled from None
    ranked = sorted(search.halves, key=lambda h: -(h[1].value + h[2].value))
    _, a, b = ranked[0]
    return ExactPair(
        u=np.stack([a.u, b.u]),
        y=np.stack([a.y, b.y]),
        value=search.pair_value(a, b),
        evidence=search.evidence(ranked),
        halves=tuple((p, q) for _, p, q in ranked),
    )
