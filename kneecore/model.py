"""Any model: inputs that are uncertain, outputs with units, and a function from one to the other.

Examples
--------
Two coupled springs, each stiff within a tolerance; the output is the stretch under three loads:

>>> import numpy as np
>>> from kneecore import Input, Model, Output
>>> model = Model(
...     lambda k: (1.0 / k[0] + 1.0 / k[1]) * np.array([1.0, 2.0, 5.0]),
...     inputs=[
...         Input("k_1", nominal=100.0, tolerance_percent=10, unit="N/mm"),
...         Input("k_2", lower=45.0, upper=55.0, unit="N/mm"),
...     ],
...     outputs=[Output("stretch", unit="mm", axis=(1.0, 2.0, 5.0), axis_unit="N")],
... )
>>> model.evaluate([[100.0, 50.0]]).round(2)
array([[0.03, 0.06, 0.15]])
>>> model.columns[2].label
'5 N'
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore._arguments import flag, number, one_line, shown, text
from kneecore._arrays import numbers
from kneecore._threads import thread_count
from kneecore.errors import ModelError, ParameterError
from kneecore.inputs import Column, Input, Output, all_of, scales_of
from kneecore.returned import jacobian_of, run_all, run_each, shapes_of
from kneecore.shape import Shape

__all__ = ["Evaluation", "Model", "Shape"]

FloatArray = NDArray[np.float64]
Run = Callable[[FloatArray], ArrayLike]
Slopes = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """What running a model for n points has given."""

    y: FloatArray
    """Outputs, shape (n, m); a row that is not finite is a failed run."""
    counts: Mapping[str, int]
    """Runs by what became of them; "failed" is always there."""
    observed: Mapping[str, FloatArray] = field(default_factory=dict)
    """Further quantities by name, shape (n, ...), where they were asked for."""


class Model:
    """A model with uncertain inputs: what every search and every study here works on.

    Parameters
    ----------
    run : callable
        The model: takes one point, shape (d,), and returns its outputs, shape (m,) or one number;
        with `batched`, takes points (n, d) and returns (n, m). NaN marks a failed run.
    inputs : sequence of Input
    outputs : sequence of Output
        In the order of the numbers that `run` returns.
    batched : bool
        Whether `run` takes many points at once.
    gradient : callable, optional
        The derivatives of the outputs by the inputs: points (n, d) to (n, m, d), exact. With it,
        the exact search climbs in the model itself.
    draw : callable, optional
        A picture of one point (d,): a sequence of `Shape`.
    name : str
        What the model is called in reports.
    threads : int, optional
        Threads that a search in a surrogate may use; all available cores for None.

    Raises
    ------
    ParameterError
        If the inputs or outputs are no such lists, share a name, have no width at all, or outputs
        of different units have no `scale`.
    """

    count_names: tuple[str, ...] = ("failed",)
    """What runs are counted by."""
    proxy: "Model | None" = None
    """A model near this one that has gradients; its worst pairs are where to begin to look."""
    in_corners: bool = False
    """Whether its worst pairs are known to lie in corners of the bounds: a repair looks there."""
    watched: int = 0
    """Column of the outputs that is told first."""
    picture_unit: str = ""
    size_name: str = "multiple of the stated bounds"
    size_unit: str = ""
    sizes: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
    """Sizes that a sweep goes through unless told otherwise."""
    goal: float | None = None
    """Largest value of the watched column that is good enough, where one is known."""

    def __init__(
        self,
        run: Run | None,
        inputs: Sequence[Input],
        outputs: Sequence[Output],
        *,
        batched: bool = False,
        gradient: Callable[[FloatArray], ArrayLike] | None = None,
        draw: Callable[[FloatArray], Sequence[Shape]] | None = None,
        name: str = "model",
        threads: int | None = None,
    ) -> None:
        for argument, function in (("run", run), ("gradient", gradient), ("draw", draw)):
            if function is not None and not callable(function):
                raise ParameterError(f"`{argument}` is {shown(function)}; a function is allowed")
        self.inputs = all_of(Input, "inputs", inputs)
        self.outputs = all_of(Output, "outputs", outputs)
        self._run, self._gradient, self._draw = run, gradient, draw
        self._batched = flag("batched", batched)
        self.name = one_line("name", name, 200)
        thread_count(threads)
        self.threads = threads
        self._size = 1.0
        self._scales = np.array(scales_of(self.outputs))
        self.lower = _held([i.lower for i in self.inputs])
        self.upper = _held([i.upper for i in self.inputs])
        self.nominal = _held([number("nominal", i.nominal) for i in self.inputs])
        self.free = self.upper > self.lower
        self.free.setflags(write=False)
        if not self.free.any():
            raise ParameterError("all bounds have zero width; at least one above 0 is needed")

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.name!r}: {len(self.inputs)} inputs, {self.n_free} of "
            f"them free, {self.n_outputs} outputs)"
        )

    # What it is.

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
    def n_outputs(self) -> int:
        """Numbers that one run returns, m."""
        return sum(output.n_columns for output in self.outputs)

    @property
    def columns(self) -> tuple[Column, ...]:
        """What each of the m numbers is."""
        alone = len(self.outputs) == 1
        return tuple(
            Column(output, at, alone)
            for output in self.outputs
            for at in (output.axis if output.axis is not None else (None,))
        )

    @property
    def order(self) -> tuple[int, ...]:
        """The columns in the order in which neighbours change together."""
        return tuple(range(self.n_outputs))

    @property
    def groups(self) -> Mapping[str, str]:
        """Which group each input belongs to, by name; empty where there are none."""
        return {}

    @property
    def computed(self) -> Mapping[str, str]:
        """How its numbers are computed, by name, where there is a choice.

        Results of models that differ here cannot be held against each other.
        """
        return {}

    @property
    def objective_unit(self) -> str:
        """Unit of f; empty where outputs are scaled."""
        return "" if any(o.scale is not None for o in self.outputs) else self.outputs[0].unit

    @property
    def objectives(self) -> Mapping[str, FloatArray]:
        """Which columns count, by the name of a choice: 1 for those that do, shape (m,)."""
        chosen = {"all": np.ones(self.n_outputs)}
        if len(self.outputs) > 1:
            columns = self.columns
            chosen |= {
                o.name: np.array([float(c.output is o) for c in columns]) for o in self.outputs
            }
        return chosen

    def weights(self, objective: str = "all", given: Sequence[float] | None = None) -> FloatArray:
        """Return the weight of each column's difference in f, shape (m,).

        Raises
        ------
        ParameterError
            If there is no such objective, or the given weights are not m numbers of at least 0,
            one above 0 among those that count.
        """
        if text("objective", objective, 200) not in self.objectives:
            raise ParameterError(
                f"`objective` is {shown(objective)}; {', '.join(self.objectives)} is allowed"
            )
        weights: FloatArray = self.objectives[objective] / self._scales
        if given is not None:
            own = numbers("weights", given)
            if own.shape != (self.n_outputs,):
                raise ParameterError(
                    f"`weights` has shape {own.shape}; ({self.n_outputs},) is needed, one for "
                    "each number that the model returns"
                )
            weights = weights * own
        if not weights.any():
            raise ParameterError(
                "`weights` are all 0 where the objective counts; one above 0 is needed"
            )
        return weights

    # Coordinates.

    @property
    def size(self) -> float:
        """How wide the bounds are, in multiples of those that were stated; see `with_size`."""
        return self._size

    def from_free_unit(self, u: ArrayLike) -> FloatArray:
        """Map points of the free inputs' unit cube, shape (..., n_free), to inputs, (..., d)."""
        unit = numbers("u", u)
        if unit.ndim == 0 or unit.shape[-1] != self.n_free:
            raise ParameterError(f"`u` has shape {unit.shape}; (..., {self.n_free}) is allowed")
        full = np.full((*unit.shape[:-1], len(self.inputs)), 0.5)
        full[..., self.free] = unit
        return np.clip(self.lower + full * (self.upper - self.lower), self.lower, self.upper)

    def to_free_unit(self, x: ArrayLike) -> FloatArray:
        """Map inputs, shape (..., d), to the free inputs' unit cube, (..., n_free)."""
        values = self._points("x", x)
        width = (self.upper - self.lower)[self.free]
        unit: FloatArray = (values - self.lower)[..., self.free] / width
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

    def with_size(self, size: float) -> Self:
        """Return the model with bounds `size` times as wide as stated, around the nominal point."""
        factor = number("size", size) / self.size
        if factor <= 0.0:
            raise ParameterError(f"`size` is {size:g}; above 0 is allowed")
        model = self._copy()
        model.inputs = tuple(one.widened(factor) for one in self.inputs)
        model.lower = _held([i.lower for i in model.inputs])
        model.upper = _held([i.upper for i in model.inputs])
        model._size = float(size)
        if self.proxy is not None:
            model.proxy = self.proxy.with_size(size)
        return model

    def _copy(self) -> Self:
        model = object.__new__(type(self))
        model.__dict__.update(self.__dict__)
        return model

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

    # What it can do.

    @property
    def has_gradient(self) -> bool:
        """Whether exact derivatives of the outputs are known."""
        return self._gradient is not None

    @property
    def has_picture(self) -> bool:
        """Whether the model can be drawn."""
        return self._draw is not None

    def evaluate(self, x: ArrayLike) -> FloatArray:
        """Run the model.

        Parameters
        ----------
        x : array_like, shape (n, d)

        Returns
        -------
        ndarray, shape (n, m)
            A row that is not finite is a failed run.

        Raises
        ------
        ParameterError
            If `x` or what the model returns has another shape, or is not made of real numbers.
        """
        points = self._points("x", x)
        if points.ndim != 2:
            raise ParameterError(
                f"`x` has shape {points.shape}; (n, {len(self.inputs)}) is allowed"
            )
        return self.examine(points).y

    def examine(self, x: FloatArray, *, observe: bool = False) -> Evaluation:
        """Run the model for points (n, d) and count what became of the runs.

        With `observe`, further quantities are returned where the model has any.
        """
        del observe
        if self._run is None:
            raise ModelError(
                f"the model {self.name!r} was read from a file, which holds no function; nothing "
                "can be computed with it"
            )
        y = (run_all if self._batched else run_each)(self._run, x, self.n_outputs)
        failed = int(np.count_nonzero(~np.isfinite(y).all(axis=1)))
        return Evaluation(y=y, counts={"failed": failed})

    def slopes(self, u: FloatArray, weights: FloatArray) -> Slopes:
        """Return weighted sums of the outputs with their gradients on the unit cube.

        Parameters
        ----------
        u : ndarray, shape (n, n_free)
        weights : ndarray, shape (n, m)

        Returns
        -------
        tuple of ndarray
            sum w y, shape (n,), minus infinity where a run failed; its gradient, (n, n_free); y,
            (n, m).
        """
        assert self._gradient is not None
        x = self.from_free_unit(u)
        y = self.examine(x).y
        jacobian = jacobian_of(self._gradient, x, self.n_outputs)
        width = (self.upper - self.lower)[self.free]
        slopes = np.einsum("nm,nmd->nd", weights, jacobian)[:, self.free] * width
        values = (weights * y).sum(axis=1)
        good = np.isfinite(values) & np.isfinite(slopes).all(axis=1)
        return np.where(good, values, -np.inf), np.where(good[:, None], slopes, 0.0), y

    def responses(self, x: FloatArray) -> Sequence[Any]:
        """Return all that the model tells of each point (n, d); empty where y is all."""
        del x
        return ()

    def draw(self, x: ArrayLike) -> Sequence[Shape]:
        """Return the picture of one point, shape (d,); empty where the model has none."""
        return () if self._draw is None else shapes_of(self._draw, self._points("x", x))

    def warm_up(self, *, gradient: bool = False) -> None:
        """Load what the first run would have to wait for."""
        del gradient


def _held(values: Sequence[float]) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
