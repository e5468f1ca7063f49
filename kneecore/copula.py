"""Inputs that depend on each other: a Gaussian copula.

Examples
--------
>>> import numpy as np
>>> from kneecore.copula import correlation_of, dependent
>>> correlation = correlation_of(("a", "b"), [("a", "b", 0.8)])
>>> u = np.random.default_rng(0).random((1000, 2))
>>> bool(0.7 < np.corrcoef(dependent(u, correlation).T)[0, 1] < 0.9)
True
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy  # its subpackages are loaded when they are used: independent samples need none
from numpy.typing import NDArray

from kneecore._arguments import number, shown
from kneecore._arrays import numbers
from kneecore.errors import ParameterError

__all__ = ["correlation_of", "dependent", "pairs_of"]

FloatArray = NDArray[np.float64]

_LEAST, _MOST = 2.0**-54, 1.0 - 2.0**-53
"""Probabilities beyond have infinite normal scores."""


def correlation_of(names: Sequence[str], given: Any) -> FloatArray | None:
    """Return the correlations of inputs as a matrix, shape (d, d); None if there are none.

    Parameters
    ----------
    names : sequence of str
        The d inputs.
    given : None, array_like of shape (d, d), or sequence of (name, name, number)

    Raises
    ------
    ParameterError
        If it is none of these, or no correlation matrix.
    """
    if given is None:
        return None
    matrix = _from_pairs(names, given) if _is_pairs(given) else _from_rows(names, given)
    if np.array_equal(matrix, np.eye(len(names))):
        return None
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least <= 1e-12:
        raise ParameterError(
            "`correlation` is not positive definite (its least eigenvalue is "
            f"{least:.3g}): no inputs can depend on each other like that"
        )
    matrix.setflags(write=False)
    return matrix


def _is_pairs(given: Any) -> bool:
    if isinstance(given, str | np.ndarray) or not isinstance(given, Sequence):
        return False
    rows = [row for row in given if isinstance(row, Sequence) and not isinstance(row, str)]
    return len(rows) == len(given) and all(any(isinstance(v, str) for v in row) for row in rows)


def _from_pairs(names: Sequence[str], given: Sequence[Any]) -> FloatArray:
    matrix = np.eye(len(names))
    for pair in given:
        if len(pair) != 3 or pair[0] == pair[1] or not {*map(str, pair[:2])} <= set(names):
            raise ParameterError(
                f"`correlation` has {shown(pair)} in it; (input, input, number) with two different "
                "inputs' names is allowed"
            )
        i, j = names.index(pair[0]), names.index(pair[1])
        if matrix[i, j] != 0.0:
            raise ParameterError(f"`correlation` has {pair[0]!r} with {pair[1]!r} twice")
        value = number(f"correlation of {pair[0]} and {pair[1]}", pair[2], least=-1.0, most=1.0)
        matrix[i, j] = matrix[j, i] = value
    return matrix


def _from_rows(names: Sequence[str], given: Any) -> FloatArray:
    d = len(names)
    allowed = f"a matrix of shape ({d}, {d}), or a list of (input, input, number), is allowed"
    matrix = np.array(numbers("correlation", given, allowed))
    if matrix.shape != (d, d):
        raise ParameterError(f"`correlation` has shape {matrix.shape}; {allowed}")
    proper = np.isfinite(matrix).all() and (np.abs(matrix) <= 1.0).all()
    if not proper or not np.array_equal(matrix, matrix.T) or not (np.diagonal(matrix) == 1.0).all():
        raise ParameterError(
            "`correlation` is no correlation matrix; a symmetric one of numbers from -1 to 1 with "
            "1 on its diagonal is allowed"
        )
    return matrix


def pairs_of(names: Sequence[str], correlation: FloatArray) -> list[tuple[str, str, float]]:
    """Return the correlations that are not 0, as `correlation_of` takes them."""
    return [
        (names[i], names[j], float(correlation[i, j]))
        for i in range(len(names))
        for j in range(i + 1, len(names))
        if correlation[i, j] != 0.0
    ]


def dependent(u: FloatArray, correlation: FloatArray) -> FloatArray:
    """Return uniform numbers (..., d) whose normal scores are correlated, from independent ones."""
    scores = scipy.stats.norm.ppf(np.clip(u, _LEAST, _MOST))
    factor = np.linalg.cholesky(correlation)
    # Not by BLAS, whose last bits depend on the number of rows and threads.
    chances: FloatArray = scipy.stats.norm.cdf(np.einsum("...k,jk->...j", scores, factor))
    return chances
