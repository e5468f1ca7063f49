"""The box of a model's inputs: bounds, the unit cube of those that vary, and samples of it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import number, shown
from kneecore._arrays import numbers
from kneecore.copula import correlation_of, dependent
from kneecore.distributions import Kind
from kneecore.errors import ParameterError
from kneecore.grid import Grid
from kneecore.inputs import Input, all_of

__all__ = ["Box"]

FloatArray = NDArray[np.float64]


class Box:
    """Uncertain inputs, of which some may be held.

    Parameters
    ----------
    inputs : sequence of Input
    correlation : array_like, shape (d, d), or sequence of (name, name, number), optional
        Of the inputs' normal scores.

    Raises
    ------
    ParameterError
        If they are no such list, share a name, or have no width at all.
    """

    def __init__(self, inputs: Sequence[Input], correlation: Any = None) -> None:
        self.inputs: tuple[Input, ...] = all_of(Input, "inputs", inputs)
        self.correlation = correlation_of(self.names, correlation)
        self.nominal = _held([number("nominal", i.nominal) for i in self.inputs])
        self._lay_bounds()

    def _copy(self) -> Self:
        model = object.__new__(type(self))
        model.__dict__.update(self.__dict__)
        return model

    def with_distributions(self, kinds: Mapping[str, tuple[Kind, float | None]]) -> Self:
        """Return the model with samples of some inputs drawn in another way.

        Parameters
        ----------
        kinds : mapping
            By an input's name its distribution, and how many standard deviations its bounds are
            away where it has such; None for 3. Whole numbers and choices stay as they are.

        Raises
        ------
        ParameterError
            If there is no such input, or a distribution does not fit its bounds.
        """
        unknown = next((name for name in kinds if name not in self.names), None)
        if unknown is not None:
            raise ParameterError(
                f"`kinds` names {shown(unknown)}; {', '.join(self.names)} are allowed"
            )
        model = self._copy()
        model.inputs = tuple(
            i.with_distribution(*kinds[i.name]) if i.name in kinds else i for i in self.inputs
        )
        model._lay_bounds()
        return model

    def _lay_bounds(self) -> None:
        boxes = [i.box for i in self.inputs]
        self.lower = _held([lower for lower, _ in boxes])
        self.upper = _held([upper for _, upper in boxes])
        self.free = self.upper > self.lower
        self.free.setflags(write=False)
        if not self.free.any():
            raise ParameterError("all bounds have zero width; at least one above 0 is needed")
        varying = np.flatnonzero(self.free).tolist()
        grids = {k: self.inputs[k].grid for k in varying}
        self._grids = {k: grid for k, grid in grids.items() if grid is not None}
        self._drawn = {
            (j, k): self.inputs[k].drawn
            for j, k in enumerate(varying)
            if (self.inputs[k].distribution, self.inputs[k].quantile) != ("uniform", None)
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(i.name for i in self.inputs)

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the inputs that vary."""
        return tuple(n for n, free in zip(self.names, self.free, strict=True) if free)

    @property
    def n_free(self) -> int:
        """Number of inputs that vary."""
        return int(np.count_nonzero(self.free))

    @property
    def grids(self) -> Mapping[int, Grid]:
        """The allowed values of free inputs that have few, by place among the free ones."""
        places = np.cumsum(self.free) - 1
        return {int(places[k]): grid for k, grid in self._grids.items()}

    @property
    def is_uniform(self) -> bool:
        """Whether samples are independent and uniform between the bounds."""
        return not self._drawn and self.correlation is None

    @property
    def drawn_as(self) -> str:
        """How samples are drawn, in words; empty where uniformly and independently."""
        if self.is_uniform:
            return ""
        free = (one for one, free in zip(self.inputs, self.free, strict=True) if free)
        kinds = Counter(one.drawn.words for one in free)
        told = [kind if len(kinds) == 1 else f"{n} {kind}" for kind, n in kinds.items()]
        return ", ".join([*told, *(["correlated"] if self.correlation is not None else [])])

    @property
    def measurements(self) -> Mapping[str, str]:
        """Which measurement tells each input, by name: it knows all its inputs equally well."""
        return {i.name: i.measurement or i.name for i in self.inputs}

    def stated_tolerance(self, name: str) -> tuple[float, str]:
        """Return how far an input may be from the middle of its bounds, and the unit of that."""
        one = self.inputs[self.names.index(name)]
        if one.tolerance_percent is not None:
            return one.tolerance_percent, "%"
        return one.shown(0.5 * (one.upper - one.lower)), one.label

    def from_free_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the free inputs' unit cube, shape (..., n_free), to inputs, (..., d)."""
        unit = numbers("u", u)
        if unit.ndim == 0 or unit.shape[-1] != self.n_free:
            raise ParameterError(f"`u` has shape {unit.shape}; (..., {self.n_free}) is allowed")
        full = np.full((*unit.shape[:-1], len(self.inputs)), 0.5)
        full[..., self.free] = unit
        x = np.clip(self.lower + full * (self.upper - self.lower), self.lower, self.upper)
        for k, grid in self._grids.items():
            x[..., k] = grid.at(full[..., k])
        return x

    def snapped(self, u: FloatArray) -> FloatArray:
        """Return points of the free inputs' unit cube where allowed values have their own places.

        `from_free_unit` maps both to the same inputs.
        """
        if not self._grids:
            return u
        own = u.copy()
        for j, grid in self.grids.items():
            own[..., j] = grid.snapped(u[..., j])
        return own

    def drawn(self, u: ArrayLike) -> FloatArray:
        """Map independent uniform numbers, shape (..., n_free), to samples of inputs, (..., d)."""
        if self.is_uniform:
            return self.from_free_unit(u)
        chances = numbers("u", u)
        if self.correlation is not None:
            chances = dependent(chances, self.correlation[np.ix_(self.free, self.free)])
        x = self.from_free_unit(chances)
        for (j, k), distribution in self._drawn.items():
            x[..., k] = distribution.quantile(chances[..., j])
        return x

    def to_free_unit(self, x: ArrayLike) -> FloatArray:
        """Map inputs, shape (..., d), to the free inputs' unit cube, (..., n_free)."""
        values = self._points("x", x)
        width = (self.upper - self.lower)[self.free]
        unit: FloatArray = (values - self.lower)[..., self.free] / width
        for j, grid in self.grids.items():
            unit[..., j] = grid.place(values[..., self.free][..., j])
        return unit

    def at_bounds(self, x: ArrayLike, *, tolerance: float = 1e-3) -> NDArray[np.int8]:
        """Tell which inputs lie on a bound: -1 lower, +1 upper, 0 neither (or held).

        `tolerance` is a share of the input's range.
        """
        unit, tolerance = self.to_free_unit(x), number("tolerance", tolerance)
        side = np.where(unit <= tolerance, -1, np.where(unit >= 1.0 - tolerance, 1, 0))
        sides = np.zeros((*unit.shape[:-1], len(self.inputs)), dtype=np.int8)
        sides[..., self.free] = side
        return sides

    def point(self, x: ArrayLike) -> FloatArray:
        """Return one point, shape (d,), checked and copied."""
        values = np.array(self._points("x", x))
        if values.ndim != 1 or not np.isfinite(values).all():
            raise ParameterError(
                f"`x` has shape {values.shape}; one point, ({len(self.inputs)},), of finite "
                "numbers is allowed"
            )
        return values

    def _points(self, argument: str, x: ArrayLike) -> FloatArray:
        allowed = f"(..., {len(self.inputs)}) is allowed"
        values = numbers(argument, x, allowed)
        if np.ma.isMaskedArray(x) or values.ndim == 0 or values.shape[-1] != len(self.inputs):
            raise ParameterError(f"`{argument}` has shape {values.shape}; {allowed}")
        return values

    def steps(self, usual: float) -> FloatArray:
        """Return steps in the free inputs' unit cube for differences, (n_free,): `usual` ones.

        Of an input with few values the step goes to the next.
        """
        steps = np.full(self.n_free, usual)
        for j, grid in self.grids.items():
            steps[j] = min(1.0 / (len(grid.values) - 1), 0.5)
        return steps

    def values_along(self, place: int, n: int) -> FloatArray:
        """Return values of an input from bound to bound, at most n; evenly spaced, or allowed."""
        grid = self._grids.get(place)
        if grid is None:
            return np.linspace(self.lower[place], self.upper[place], n)
        return np.unique(grid.at(np.linspace(0.0, 1.0, n)))

    def check_allowed(self, x: FloatArray) -> None:
        """Raise a `ParameterError` if an input with few values has another, points (..., d)."""
        for k, grid in self._grids.items():
            wrong = ~np.isin(x[..., k], grid.values)
            if wrong.any():
                what = "whole numbers between its bounds" if self.inputs[k].integer else "choices"
                raise ParameterError(
                    f"`x` has {np.atleast_1d(x[..., k])[np.atleast_1d(wrong)][0]:g} for "
                    f"`{self.names[k]}`; its {what} are allowed"
                )

    def _identities(self) -> list[bytes]:
        """Return what tells it from boxes whose samples or bounds are others."""
        bounds = [a.tobytes() for a in (self.lower, self.nominal, self.upper)]
        grids = [grid.values.tobytes() for grid in self._grids.values()]
        drawn = [repr(one).encode() for one in self._drawn.values()]
        correlated = [] if self.correlation is None else [self.correlation.tobytes()]
        return [*bounds, *grids, *drawn, *correlated]

    def _factors(self, factors: ArrayLike) -> FloatArray:
        """Return a factor for each input, checked."""
        n = len(self.inputs)
        values = numbers("factors", factors)
        if values.shape != (n,) or not (np.isfinite(values) & (values >= 0.0)).all():
            raise ParameterError(
                f"`factors` has shape {values.shape}; ({n},) finite numbers of at least 0 are "
                "allowed"
            )
        return values


def _held(values: Sequence[float]) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
