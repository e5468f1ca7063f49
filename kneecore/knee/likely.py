"""How likely the knees of a space are: one distribution for all its parameters.

What no knee can have is never drawn: a normal distribution ends at a stiffness of 0, and at a
Poisson's ratio of 0.499.
"""

from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import choice, number
from kneecore.distributions import WITH_DEVIATIONS
from kneecore.errors import ParameterError
from kneecore.inputs import Input
from kneecore.knee.parameters import LARGEST, NAMES, SMALLEST, STRUCTURE
from kneecore.knee.units import si_factor, si_unit

__all__ = ["POISSON_LIMIT", "KneeDistribution", "Likely", "inputs_of"]

KneeDistribution = Literal["uniform", "normal", "truncated-normal", "triangular"]
"""A coordinate may be 0 or below, so that none is log-normal."""
POISSON_LIMIT = 0.499
"""Upper bound of Poisson's ratio: at 0.5 the material is incompressible."""

FloatArray = NDArray[np.float64]

_POISSON = NAMES.index("poissons_ratio")
_IS_LENGTH = np.array([row[2] != "material" and row[0] != "condyle_radius" for row in STRUCTURE])
_LEAST = np.where(_IS_LENGTH, -LARGEST, SMALLEST)
_MOST = np.where(np.arange(len(STRUCTURE)) == _POISSON, POISSON_LIMIT, LARGEST)


class Likely(NamedTuple):
    """A distribution, and which part of it a search looks at."""

    distribution: KneeDistribution = "uniform"
    deviations: float | None = None
    quantile: float | None = None

    def but(
        self,
        distribution: KneeDistribution | None,
        deviations: float | None,
        quantile: float | None,
    ) -> "Likely":
        """Return it with what is given in the place of its own."""
        own = self if distribution is None else Likely(distribution)
        known = own.deviations if deviations is None else deviations
        return Likely(own.distribution, known, own.quantile if quantile is None else quantile)

    @property
    def told(self) -> dict[str, Any]:
        """What files say of it: what is not as usual.

        Raises
        ------
        ParameterError
            As `checked`.
        """
        told = self.checked()._asdict()
        return {key: value for key, value in told.items() if value not in (None, "uniform")}

    def checked(self) -> "Likely":
        """Return it with plain numbers.

        Raises
        ------
        ParameterError
            If a value is not allowed, or belongs to another distribution.
        """
        kind = choice("distribution", self.distribution, get_args(KneeDistribution))
        deviations, quantile = self.deviations, self.quantile
        if deviations is not None:
            deviations = number("deviations", deviations)
            if deviations <= 0.0:
                raise ParameterError(f"`deviations` is {deviations:g}; above 0 is allowed")
            if kind not in WITH_DEVIATIONS:
                raise ParameterError(
                    f"`deviations` is {deviations:g}; a {kind} distribution has none"
                )
        if quantile is not None:
            quantile = number("quantile", quantile)
            if not 0.0 < quantile < 1.0:
                raise ParameterError(f"`quantile` is {quantile:g}; above 0 and below 1 is allowed")
        return Likely(kind, deviations, quantile)


def inputs_of(
    baseline: FloatArray, centre: FloatArray, lower: FloatArray, upper: FloatArray, likely: Likely
) -> list[Input]:
    """Return the parameters of a space of knees, shape (28,) or (32,) each, as a model's inputs."""
    return [
        Input(
            STRUCTURE[k][0],
            nominal=float(baseline[k]),
            unit=si_unit(STRUCTURE[k][3]),
            shown_unit=STRUCTURE[k][3],
            shown_scale=si_factor(STRUCTURE[k][3]),
            **_drawn(k, float(centre[k]), float(lower[k]), float(upper[k]), likely),
        )
        for k in range(len(lower))
    ]


def _drawn(k: int, centre: float, lower: float, upper: float, likely: Likely) -> dict[str, Any]:
    """Return a parameter's bounds and distribution."""
    drawn: dict[str, Any] = {"lower": lower, "upper": upper, **likely._asdict()}
    if likely.distribution == "uniform":
        return drawn
    drawn |= {"least": min(float(_LEAST[k]), lower), "most": max(float(_MOST[k]), upper)}
    if k == _POISSON:  # its mean is the centre, also where its upper bound is clipped
        drawn |= {"upper": max(upper, 2.0 * centre - lower), "most": max(POISSON_LIMIT, upper)}
    if likely.distribution == "triangular":
        drawn["mode"] = centre
    return drawn
