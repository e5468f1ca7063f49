"""Variance-based sensitivity: which inputs decide an output's spread.

The design is Saltelli's (Comput. Phys. Commun. 181:259-270, 2010): two independent Sobol' samples A
and B, and for each input the rows of A with that input taken from B. The estimators are SciPy's
(`scipy.stats.sobol_indices`); intervals come from resampling the base rows.

Examples
--------
>>> from kneecore.numerics.sensitivity import sobol_indices
>>> found = sobol_indices(lambda u: u @ [[2.0], [1.0], [0.0]], 3, n_base=256)
>>> found.first_order[0].round(2)
array([0.8, 0.2, 0. ])
"""

from collections.abc import Callable
from dataclasses import dataclass

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
    """Base rows that were replaced since one of their d + 2 evaluations failed."""


def _evaluate_rows(
    model: Callable[[FloatArray], FloatArray], base: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return f_A (n, s), f_B (n, s) and f_AB (n, d, s) for base rows (n, 2 d)."""
    n, d = len(base), base.shape[1] // 2
    a, b = base[:, :d], base[:, d:]
    mixed = np.repeat(a[:, None], d, axis=1)
    index = np.arange(d)
    mixed[:, index, index] = b
    points = np.concatenate([a[:, None], b[:, None], mixed], axis=1)
    values = np.asarray(model(points.reshape(n * (d + 2), d))).reshape(n, d + 2, -1)
    return values[:, 0], values[:, 1], values[:, 2:]


def _design(
    model: Callable[[FloatArray], FloatArray],
    n_dimensions: int,
    n_base: int,
    seed: int,
    batch: int,
    callback: Callable[[int, int], object] | None,
) -> tuple[FloatArray, FloatArray, FloatArray, int, int]:
    """Evaluate base rows until `n_base` of them are whole; also count evaluations and failures."""
    engine = scipy.stats.qmc.Sobol(2 * n_dimensions, rng=np.random.default_rng(seed))
    kept: list[tuple[FloatArray, FloatArray, FloatArray]] = []
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
        parts = _evaluate_rows(model, engine.random(size))
        good = np.logical_and.reduce([np.isfinite(p).reshape(size, -1).all(axis=1) for p in parts])
        kept.append((parts[0][good], parts[1][good], parts[2][good]))
        n_good += int(np.count_nonzero(good))
        n_tried += size
    f_a, f_b, f_ab = (np.concatenate([k[i] for k in kept])[:n_base] for i in range(3))
    return f_a, f_b, f_ab, n_tried * (n_dimensions + 2), n_tried - n_good


def _estimate(
    evaluations: tuple[FloatArray, FloatArray, FloatArray], rows: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Return SciPy's first-order and total indices, shapes (s, d), of some of the base rows."""
    f_a, f_b, f_ab = evaluations
    found = scipy.stats.sobol_indices(
        func={
            "f_A": np.ascontiguousarray(f_a[rows].T),
            "f_B": np.ascontiguousarray(f_b[rows].T),
            "f_AB": np.ascontiguousarray(f_ab[rows].transpose(1, 2, 0)),
        },
        n=len(rows),
    )
    shape = f_ab.shape[2], f_ab.shape[1]  # SciPy drops the axis of a single output or input
    return np.reshape(found.first_order, shape), np.reshape(found.total_order, shape)


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
        Maps points (n, d) of the unit cube to outputs (n, s); NaN is a failure.
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
    f_a, f_b, f_ab, n_evaluations, n_failed = _design(
        model, n_dimensions, n, check_seed(seed), batch, callback
    )
    spread = np.ptp(np.concatenate([f_a, f_b]), axis=0)
    size = np.abs(np.concatenate([f_a, f_b])).max(axis=0)
    constant = spread <= 1e-12 * size
    shape = (len(constant), n_dimensions)
    first, total = np.full(shape, np.nan), np.full(shape, np.nan)
    intervals: list[FloatArray | None] = [None, None]
    varying = np.flatnonzero(~constant)
    if len(varying):
        evaluations = (f_a[:, varying], f_b[:, varying], f_ab[:, :, varying])
        first[varying], total[varying] = _estimate(evaluations, np.arange(n))
        rng = np.random.default_rng(seed)
        resampled = [_estimate(evaluations, rng.integers(0, n, n)) for _ in range(n_resamples)]
        for k in range(2 if n_resamples else 0):
            both = np.full((2, *shape), np.nan)
            both[:, varying] = np.percentile([r[k] for r in resampled], [2.5, 97.5], axis=0)
            intervals[k] = both
    return Indices(
        first_order=first,
        total_order=total,
        first_order_interval=intervals[0],
        total_order_interval=intervals[1],
        constant=constant,
        n_base=n,
        n_evaluations=n_evaluations,
        n_failed_rows=n_failed,
    )
