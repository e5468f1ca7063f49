"""Variance-based sensitivity: which inputs decide an output's spread.

The design is Saltelli's (Comput. Phys. Commun. 181:259-270, 2010): two independent Sobol' samples A
and B, and for each input the rows of A with that input taken from B. The estimators are those of
`scipy.stats.sobol_indices`, which takes powers of two only: here an output that failed in some
rows has those that it did not fail in. Intervals come from resampling the base rows.

Examples
--------
>>> from kneecore.numerics.sensitivity import sobol_indices
>>> found = sobol_indices(lambda u: u @ [[2.0], [1.0], [0.0]], 3, n_base=256)
>>> found.first_order[0].round(2)
array([0.8, 0.2, 0. ])
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import scipy  # its subpackages are loaded when they are used: a page's start needs none
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.numerics.sampling import n_drawn
from kneecore.numerics.sampling_options import check_seed

__all__ = ["Indices", "sobol_indices"]

FloatArray = NDArray[np.float64]
BATCH = 64
"""Base rows that are evaluated at once; a power of two."""
MAX_TRIES = 4
"""Base rows that are tried at most for each that is wanted, where models fail."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Indices:
    """First-order and total indices of s outputs on d inputs."""

    first_order: FloatArray
    """Share of the output's variance that the input explains alone, shape (s, d)."""
    total_order: FloatArray
    """Share that would be left if all other inputs were known, shape (s, d)."""
    first_order_interval: FloatArray | None
    """95 % bootstrap interval, shape (2, s, d), or None where none was asked for."""
    total_order_interval: FloatArray | None
    """95 % bootstrap interval, shape (2, s, d)."""
    constant: NDArray[np.bool_]
    """Outputs without variance, shape (s,): their indices are NaN."""
    n_base: int
    """Base rows used: a power of two."""
    n_evaluations: int
    n_failed_rows: int
    """Base rows that were replaced: no output was known in all of their d + 2 evaluations."""
    n_used: NDArray[np.int64] | None = None
    """Base rows behind each output's indices, shape (s,), where some failed in some outputs only;
    an output that has less than a quarter of `n_base` has no indices (NaN)."""

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Outputs that failed too often to have indices, shape (s,)."""
        if self.n_used is None:
            return np.zeros(len(self.constant), dtype=bool)
        return _too_few(self.n_used, self.n_base)


def _too_few(n_used: NDArray[np.int64], n_base: int) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = n_used * MAX_TRIES < n_base
    return found


def _evaluate_rows(model: Callable[[FloatArray], FloatArray], base: FloatArray) -> "_Rows":
    """Return what a model gives for base rows (n, 2 d)."""
    n, d = len(base), base.shape[1] // 2
    a, b = base[:, :d], base[:, d:]
    mixed = np.repeat(a[:, None], d, axis=1)
    index = np.arange(d)
    mixed[:, index, index] = b
    points = np.concatenate([a[:, None], b[:, None], mixed], axis=1)
    values = np.asarray(model(points.reshape(n * (d + 2), d))).reshape(n, d + 2, -1)
    return _Rows(values[:, 0], values[:, 1], values[:, 2:])


@dataclass(frozen=True, eq=False)
class _Rows:
    """What the model gave for base rows."""

    f_a: FloatArray
    """Shape (n, s)."""
    f_b: FloatArray
    f_ab: FloatArray
    """Shape (n, d, s)."""

    @property
    def whole(self) -> NDArray[np.bool_]:
        """In which rows each output is known in all evaluations, shape (n, s)."""
        known: NDArray[np.bool_] = (
            np.isfinite(self.f_a) & np.isfinite(self.f_b) & np.isfinite(self.f_ab).all(axis=1)
        )
        return known

    def part(self, rows: Any, outputs: Any = slice(None)) -> "_Rows":
        """Return some rows and outputs."""
        parts = (f[rows][..., outputs] for f in (self.f_a, self.f_b, self.f_ab))
        return _Rows(*parts)


def _joined(parts: Sequence[_Rows]) -> _Rows:
    return _Rows(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(_Rows)))


def _design(
    model: Callable[[FloatArray], FloatArray],
    n_dimensions: int,
    n_base: int,
    seed: int,
    batch: int,
    callback: Callable[[int, int], object] | None,
) -> tuple[_Rows, int, int]:
    """Evaluate base rows until `n_base` of them serve; also count evaluations and failures."""
    engine = scipy.stats.qmc.Sobol(2 * n_dimensions, rng=np.random.default_rng(seed))
    kept: list[_Rows] = []
    n_good = n_tried = 0
    size = min(batch, n_base)
    while n_good < n_base:
        if n_tried >= MAX_TRIES * n_base:
            raise ModelError(
                f"{n_tried - n_good} of {n_tried} rows of the sensitivity design hold a failed "
                "model; narrower bounds are needed"
            )
        if callback is not None and callback(min(n_good, n_base), n_base):
            raise InterruptedError
        rows = _evaluate_rows(model, engine.random(size))
        good = rows.whole.any(axis=1)
        kept.append(rows.part(good))
        n_good += int(np.count_nonzero(good))
        n_tried += size
    used = _joined(kept).part(slice(n_base))
    return used, n_tried * (n_dimensions + 2), n_tried - n_good


def _estimate(rows: _Rows) -> tuple[FloatArray, FloatArray]:
    """Return first-order and total indices, shapes (s, d)."""
    f_a, f_b = (np.ascontiguousarray(f.T) for f in (rows.f_a, rows.f_b))
    f_ab = np.ascontiguousarray(rows.f_ab.transpose(1, 2, 0))
    mean = np.mean([f_a, f_b], axis=(0, -1))[:, None]  # which makes the sums below exact
    f_a, f_b, f_ab = f_a - mean, f_b - mean, f_ab - mean
    variance = np.var([f_a, f_b], axis=(0, -1))
    one = np.where(variance > 0.0, variance, np.inf)  # resampled rows may be all the same
    first = np.mean(f_b * (f_ab - f_a), axis=-1) / one  # the paper's table 2, (b)
    total = 0.5 * np.mean((f_a - f_ab) ** 2, axis=-1) / one  # (f)
    return first.T, total.T


def _resampled(rows: _Rows, n_resamples: int, seed: int) -> list[FloatArray]:
    """Return 95 % intervals of first-order and total indices, shape (2, s, d) each."""
    rng, n = np.random.default_rng(seed), len(rows.f_a)
    found = [_estimate(rows.part(rng.integers(0, n, n))) for _ in range(n_resamples)]
    return [np.percentile([one[k] for one in found], [2.5, 97.5], axis=0) for k in range(2)]


def _alike(whole: NDArray[np.bool_], wanted: NDArray[np.bool_]) -> Iterator[tuple[Any, Any]]:
    """Yield (rows, outputs) of those wanted outputs that have the same rows."""
    patterns, which = np.unique(whole[:, wanted], axis=1, return_inverse=True)
    places = np.flatnonzero(wanted)
    for k in range(patterns.shape[1]):
        yield np.flatnonzero(patterns[:, k]), places[which.ravel() == k]


def _constant(rows: _Rows, whole: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which outputs do not vary over their rows, shape (s,)."""
    both = np.concatenate([np.where(whole, f, np.nan) for f in (rows.f_a, rows.f_b)])
    known = np.flatnonzero(whole.any(axis=0))
    constant = np.zeros(whole.shape[1], dtype=np.bool_)
    low, high = np.nanmin(both[:, known], axis=0), np.nanmax(both[:, known], axis=0)
    constant[known] = high - low <= 1e-12 * np.maximum(np.abs(low), np.abs(high))
    return constant


def sobol_indices(
    model: Callable[[FloatArray], FloatArray],
    n_dimensions: int,
    *,
    n_base: int = 1024,
    seed: int = 0,
    n_resamples: int = 0,
    batch: int = BATCH,
    callback: Callable[[int, int], object] | None = None,
) -> Indices:
    """Return Sobol' indices of a model on the unit cube, its inputs uniform and independent.

    Parameters
    ----------
    model : callable
        Maps points (n, d) of the unit cube to outputs (n, s); NaN is a failure, which costs its
        output the row; a row in which no output is whole is replaced.
    n_dimensions : int
        d
    n_base : int
        Base rows; rounded up to a power of two. The model is run d + 2 times for each.
    seed : int
        Of the design and of the resampling.
    n_resamples : int
        Bootstrap resamples for 95 % intervals; 0 for none.
    batch : int
        Base rows evaluated at once; a power of two. The numbers do not depend on it.
    callback : callable, optional
        Gets (rows done, rows wanted); a true result cancels (raises `InterruptedError`).

    Raises
    ------
    ModelError
        If most of the rows hold a failed model.
    """
    n = n_drawn(n_base, "sobol")
    rows, n_evaluations, n_failed = _design(
        model, n_dimensions, n, check_seed(seed), batch, callback
    )
    whole = rows.whole
    n_used = whole.sum(axis=0)
    constant = _constant(rows, whole) & ~_too_few(n_used, n)
    shape = (len(constant), n_dimensions)
    orders = [np.full(shape, np.nan), np.full(shape, np.nan)]
    intervals = [np.full((2, *shape), np.nan) for _ in orders] if n_resamples else [None, None]
    for mine, outputs in _alike(whole, ~constant & ~_too_few(n_used, n)):
        part = rows.part(mine, outputs)
        for order, found in zip(orders, _estimate(part), strict=True):
            order[outputs] = found
        if n_resamples:
            for both, found in zip(intervals, _resampled(part, n_resamples, seed), strict=True):
                both[:, outputs] = found  # type: ignore[index]
    return Indices(
        first_order=orders[0],
        total_order=orders[1],
        first_order_interval=intervals[0],
        total_order_interval=intervals[1],
        constant=constant,
        n_base=n,
        n_evaluations=n_evaluations,
        n_failed_rows=n_failed,
        n_used=None if whole.all() else n_used,
    )
