"""How likely the values of an input are: the distributions of samples, by SciPy.

Examples
--------
>>> from kneecore.distributions import Distribution
>>> one = Distribution(kind="normal", lower=94.0, upper=106.0, mode=100.0, deviations=3.0)
>>> one.quantile([0.5, 0.975]).round(2)  # mean 100, standard deviation 2
array([100.  , 103.92])
"""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import scipy  # its subpackages are loaded when they are used: uniform samples need none
from numpy.typing import ArrayLike, NDArray

__all__ = ["KINDS", "USUAL_DEVIATIONS", "WITH_DEVIATIONS", "Distribution", "Kind", "central"]

Kind = Literal["uniform", "normal", "truncated-normal", "log-normal", "triangular"]
KINDS: tuple[Kind, ...] = get_args(Kind)
WITH_DEVIATIONS = frozenset[str]({"normal", "truncated-normal", "log-normal"})
"""Those whose bounds are a number of standard deviations from the middle."""
USUAL_DEVIATIONS = 3.0

FloatArray = NDArray[np.float64]

_LEAST_CHANCE, _LARGEST_CHANCE = 2.0**-54, 1.0 - 2.0**-53
"""Probabilities beyond would be infinitely far away."""


def central(share: float) -> tuple[float, float]:
    """Return the probabilities between which the central `share` of a distribution lies."""
    return 0.5 * (1.0 - share), 0.5 * (1.0 + share)


@dataclass(frozen=True, kw_only=True)
class Distribution:
    """The distribution of one input, from its bounds.

    Uniform between the bounds; triangular between them with its peak at `mode`; normal with the
    bounds `deviations` standard deviations from the mean, which is in their middle; the same cut
    off at the bounds (truncated normal); or log-normal, which is that for the logarithm.
    """

    kind: Kind
    lower: float
    upper: float
    mode: float
    """Most likely value of a triangular one."""
    deviations: float = USUAL_DEVIATIONS
    least: float = -math.inf
    """No value below it is possible: the distribution is cut off there."""
    most: float = math.inf

    def quantile(self, chances: ArrayLike) -> FloatArray:
        """Return the values below which such shares of the distribution lie."""
        p = np.asarray(chances, dtype=np.float64)
        least, most = self._limits
        if self.kind == "uniform":
            linear: FloatArray = least + p * (most - least)
            return linear
        family, shape = self._family()
        if np.isfinite([least, most]).any():
            first, last = family.cdf([least, most], *shape)
            p = first + p * (last - first)
        values = family.ppf(np.clip(p, _LEAST_CHANCE, _LARGEST_CHANCE), *shape)
        within: FloatArray = np.clip(values, least, most)
        return within

    def interval(self, share: float) -> tuple[float, float]:
        """Return the ends of the central `share` of the distribution."""
        lower, upper = self.quantile(central(share)).tolist()
        return lower, upper

    @property
    def words(self) -> str:
        """What it is called in reports."""
        name = self.kind.replace("truncated-", "truncated ")
        if self.kind not in WITH_DEVIATIONS:
            return name
        return f"{name} with bounds at {self.deviations:g} sd"

    @property
    def _limits(self) -> tuple[float, float]:
        if self.kind in ("normal", "log-normal"):
            return self.least, self.most
        return max(self.lower, self.least), min(self.upper, self.most)

    def _family(self) -> "tuple[scipy.stats.rv_continuous, tuple[float, ...]]":
        """Return SciPy's distribution, before it is cut off, and its shape, location and scale."""
        width = self.upper - self.lower
        if self.kind == "triangular":
            return scipy.stats.triang, ((self.mode - self.lower) / width, self.lower, width)
        if self.kind == "log-normal":
            sd = math.log(self.upper / self.lower) / (2.0 * self.deviations)
            median = math.sqrt(self.lower) * math.sqrt(self.upper)
            return scipy.stats.lognorm, (sd, 0.0, median)
        sd = width / (2.0 * self.deviations)
        return scipy.stats.norm, (self.lower + 0.5 * width, sd)
