"""A separable evolution strategy on the unit cube, several independent maxima abreast.

The covariance matrix adaptation of Hansen & Ostermeier with a diagonal matrix (sep-CMA-ES, Ros &
Hansen 2008, PPSN X, LNCS 5199:296-305): 2 d numbers are learned instead of d^2, which suits
functions whose inputs add up more than they interact. Points beyond the cube are moved to its
surface, and are learned from where they have been evaluated. For functions that cannot be derived,
and fail in places.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Evolved", "evolve_abreast"]

FloatArray = NDArray[np.float64]
Objective = Callable[[FloatArray], FloatArray]
"""Maps points (k, n, d), n for each of k functions, to their values (k, n); minus infinity for a
failure."""

_LEAST_VARIANCE = 1e-12
_WIDEST = 1.0  # of the cube: the step size's limit


@dataclass(frozen=True, kw_only=True, eq=False)
class Evolved:
    """The best points found."""

    u: FloatArray
    """Shape (k, d)."""
    values: FloatArray
    """Shape (k,)."""


@dataclass(frozen=True, kw_only=True)
class _Rates:
    """The strategy's constants for a dimension and a population (Ros & Hansen 2008, table 1)."""

    weights: FloatArray
    mu_eff: float
    c_sigma: float
    d_sigma: float
    c_path: float
    c_one: float
    c_mu: float
    mean_norm: float
    """Of a standard normal vector."""

    @classmethod
    def of(cls, d: int, pop_size: int) -> "_Rates":
        mu = pop_size // 2
        weights = np.log(mu + 0.5) - np.log(np.arange(1, mu + 1))
        weights /= weights.sum()
        mu_eff = 1.0 / float((weights**2).sum())
        c_sigma = (mu_eff + 2.0) / (d + mu_eff + 5.0)
        faster = (d + 2.0) / 3.0  # than with a full matrix: there is less to learn
        c_one = min(1.0, faster * 2.0 / ((d + 1.3) ** 2 + mu_eff))
        c_mu = faster * 2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((d + 2.0) ** 2 + mu_eff)
        return cls(
            weights=weights,
            mu_eff=mu_eff,
            c_sigma=c_sigma,
            d_sigma=1.0 + 2.0 * max(0.0, np.sqrt((mu_eff - 1.0) / (d + 1.0)) - 1.0) + c_sigma,
            c_path=(4.0 + mu_eff / d) / (d + 4.0 + 2.0 * mu_eff / d),
            c_one=c_one,
            c_mu=min(1.0 - c_one, c_mu),
            mean_norm=float(np.sqrt(d) * (1.0 - 1.0 / (4.0 * d) + 1.0 / (21.0 * d * d))),
        )


class _Strategy:
    """The state of k strategies: means, step sizes, variances and paths."""

    def __init__(self, start: FloatArray, step: float, rates: _Rates) -> None:
        self.mean, self.rates = start.copy(), rates
        self.sigma = np.full(len(start), step)
        self.variance = np.ones_like(start)
        self.path, self.path_sigma = np.zeros_like(start), np.zeros_like(start)
        self.generation = 0

    def ask(self, n: int, rng: np.random.Generator) -> FloatArray:
        """Return n points for each strategy, shape (k, n, d)."""
        k, d = self.mean.shape
        spread = self.sigma[:, None] * np.sqrt(self.variance)
        points = self.mean[:, None] + spread[:, None] * rng.standard_normal((k, n, d))
        return np.clip(points, 0.0, 1.0)

    def tell(self, points: FloatArray, values: FloatArray) -> None:
        """Learn from the better half of the points."""
        r = self.rates
        best = np.argsort(-values, axis=1, kind="stable")[:, : len(r.weights)]
        steps = np.take_along_axis(points, best[..., None], axis=1) - self.mean[:, None]
        steps /= self.sigma[:, None, None]
        step = np.einsum("i,kid->kd", r.weights, steps)
        self.mean = self.mean + self.sigma[:, None] * step
        self.generation += 1
        whitened = step / np.sqrt(self.variance)
        kept = np.sqrt(r.c_sigma * (2.0 - r.c_sigma) * r.mu_eff)
        self.path_sigma = (1.0 - r.c_sigma) * self.path_sigma + kept * whitened
        norm = np.linalg.norm(self.path_sigma, axis=1)
        settled = np.sqrt(1.0 - (1.0 - r.c_sigma) ** (2 * self.generation))
        short = norm / settled < (1.4 + 2.0 / (points.shape[2] + 1.0)) * r.mean_norm
        kept = np.sqrt(r.c_path * (2.0 - r.c_path) * r.mu_eff)
        self.path = (1.0 - r.c_path) * self.path + np.where(short, kept, 0.0)[:, None] * step
        missing = np.where(short, 0.0, r.c_path * (2.0 - r.c_path))[:, None] * self.variance
        spread = np.einsum("i,kid->kd", r.weights, steps**2)
        self.variance = (
            (1.0 - r.c_one - r.c_mu) * self.variance
            + r.c_one * (self.path**2 + missing)
            + r.c_mu * spread
        )
        self.variance = np.maximum(self.variance, _LEAST_VARIANCE)
        grown = np.exp((r.c_sigma / r.d_sigma) * (norm / r.mean_norm - 1.0))
        self.sigma = np.minimum(self.sigma * grown, _WIDEST)


def evolve_abreast(
    objective: Objective,
    start: FloatArray,
    *,
    pop_size: int,
    n_generations: int,
    step: float,
    rng: np.random.Generator,
) -> Evolved:
    """Maximise k functions over the unit cube, each by a strategy of its own.

    Parameters
    ----------
    objective : callable
        Evaluates a generation of all k functions at once.
    start : ndarray, shape (k, d)
        The strategies' first means.
    pop_size : int
        Points of a generation, at least 4.
    n_generations : int
    step : float
        First step size, a share of the cube's width.
    rng : Generator
        The same state gives the same points.

    Returns
    -------
    Evolved
        The best points evaluated; the start and minus infinity where all have failed.
    """
    strategy = _Strategy(start, step, _Rates.of(start.shape[1], pop_size))
    u, best = start.copy(), np.full(len(start), -np.inf)
    for _ in range(n_generations):
        points = strategy.ask(pop_size, rng)
        values = objective(points)
        k = np.argmax(values, axis=1)
        top = np.take_along_axis(values, k[:, None], axis=1)[:, 0]
        better = top > best
        u[better] = np.take_along_axis(points, k[:, None, None], axis=1)[:, 0][better]
        best = np.where(better, top, best)
        strategy.tell(points, values)
    return Evolved(u=u, values=best)
