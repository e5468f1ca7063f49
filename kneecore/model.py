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
from os import PathLike
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore import runs
from kneecore._arguments import flag, number, one_line, shown, text
from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.inputs import Input, all_of
from kneecore.outputs import Column, Output, scales_of, weights_of
from kneecore.returned import jacobian_of, shapes_of
from kneecore.runner import Run, Runner
from kneecore.runs.evaluation import Evaluation
from kneecore.runs.options import OnFailure, RunOptions
from kneecore.shape import Shape

if TYPE_CHECKING:
    from kneecore.runs.program import KeepRuns

__all__ = ["Evaluation", "Model", "Shape"]

FloatArray = NDArray[np.float64]
Slopes = tuple[FloatArray, FloatArray, FloatArray]


class Model(Runner):
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
    picture_unit : str
        Unit of its points, for axes and a scale.
    correlation : array_like, shape (d, d), or sequence of (name, name, number), optional
        How the inputs' samples depend on each other: the correlations of their normal scores (a
        Gaussian copula), which are those of normal inputs themselves. Searches do not look at it.
    name : str
        What the model is called in reports.
    threads : int, optional
        Threads that a search in a surrogate may use; all available cores for None.
    workers : int, str or executor, optional
        Who does the runs. None: this process, one after the other. A number: so many processes, of
        which one that hangs or crashes is replaced. ``tcp://host:port``: the workers of a
        dask.distributed scheduler. Anything else: an executor with `submit` or `map`. The numbers
        do not depend on it; a `batched` function must not let rows depend on each other.
    keep : str or path, optional
        A file to which each run is added when it is done, and from which runs are taken that were
        done before: a study that was killed goes on from there.
    timeout_s : float, optional
        Seconds after which a run (of a `batched` function: a call) is ended and has failed. It is
        then run in a process of its own.
    on_failure : {"continue", "abort"}
        Whether a run that fails is a row without outputs, told by `failures`, or ends everything.
    retries : int
        How often a run that raised, hung or crashed is tried again.
    rerun_failures : bool
        Whether runs that failed before are not taken from `keep`.

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
        picture_unit: str = "",
        correlation: Any = None,
        name: str = "model",
        threads: int | None = None,
        workers: Any = None,
        keep: str | PathLike[str] | None = None,
        timeout_s: float | None = None,
        on_failure: OnFailure = "continue",
        retries: int = 0,
        rerun_failures: bool = False,
    ) -> None:
        for argument, function in (("run", run), ("gradient", gradient), ("draw", draw)):
            if function is not None and not callable(function):
                raise ParameterError(f"`{argument}` is {shown(function)}; a function is allowed")
        super().__init__(
            run,
            inputs,
            all_of(Output, "outputs", outputs),
            batched=flag("batched", batched),
            correlation=correlation,
            options=RunOptions(
                workers=workers,
                keep=keep,  # type: ignore[arg-type]  # a path becomes text there
                timeout_s=timeout_s,
                on_failure=on_failure,
                retries=retries,
                rerun_failures=rerun_failures,
            ),
        )
        self._gradient, self._draw = gradient, draw
        self.name = one_line("name", name, 200)
        self.picture_unit = one_line("picture_unit", picture_unit, 200) or self.picture_unit
        thread_count(threads)
        self.threads = threads
        self._size = 1.0
        self._scales = np.array(scales_of(self.outputs))

    @classmethod
    def from_program(
        cls,
        command: str | Sequence[str],
        template: str | PathLike[str] | None,
        read: Any,
        inputs: Sequence[Input],
        outputs: Sequence[Output],
        *,
        files: Sequence[str | PathLike[str]] = (),
        folder: str | PathLike[str] | None = None,
        keep_runs: "KeepRuns" = "failed",
        **options: Any,
    ) -> Self:
        """Return a model whose runs are those of an external program.

        Parameters
        ----------
        command : str or sequence of str
            The program and its arguments; ``{input}`` stands for the filled template, ``{folder}``
            for the run's folder, and fields such as ``{k_1}`` for inputs. No shell is involved.
        template : str or path, optional
            The program's input file, with a field such as ``{k_1}`` or ``{k_1:.6e}`` in the place
            of each input; without one all fields are in the command.
        read : callable or sequence of callables
            What is in the run's folder, as numbers: a `JsonOutput`, `CsvOutput`, `TextOutput`, or
            a function of the folder's path.
        inputs : sequence of Input
        outputs : sequence of Output
        files : sequence of str or path
            What else each run's folder needs.
        folder : str or path, optional
            Where the runs' folders are made; the system's temporary folder for None.
        keep_runs : {"failed", "all", "none"}
            Which of them stay.
        **options
            As for `Model`; `timeout_s` ends a program with all that it has started.

        Raises
        ------
        ParameterError, FileFormatError
            If an argument is not allowed, an uncertain input has no field, or the template cannot
            be read.
        """
        inputs = all_of(Input, "inputs", inputs)
        program = runs.program.Program(
            command,
            template,
            read,
            names=[i.name for i in inputs],
            whole=[i.name for i in inputs if i.whole],
            needed=[i.name for i in inputs if i.upper > i.lower],
            files=files,
            folder=folder,
            keep_runs=keep_runs,
            timeout_s=options.get("timeout_s"),
        )
        return cls(program, inputs, outputs, **options)

    @classmethod
    def from_file(cls, path: str | PathLike[str]) -> Self:
        """Return the model that a TOML file describes.

        Such a file names code that is run: read none that you would not run as a program.

        Raises
        ------
        FileFormatError
            If the file cannot be used; the line names the file and the key.
        """
        made: Self = runs.model_file.read_model_file(path, cls)
        return made

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.name!r}: {len(self.inputs)} inputs, {self.n_free} of "
            f"them free, {self.n_outputs} outputs)"
        )

    # What it is.

    @property
    def identity(self) -> bytes:
        """What tells its runs from those of models with other bounds or another name."""
        name = f"{type(self).__name__} {self.name}".encode()
        return b"\0".join([name, *self._identities()])

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
        return weights_of(self.objectives[objective] / self._scales, given)

    # Bounds.

    @property
    def size(self) -> float:
        """How wide the bounds are, in multiples of those that were stated; see `with_size`."""
        return self._size

    def with_size(self, size: float) -> Self:
        """Return the model with bounds `size` times as wide as stated, around the nominal point."""
        factor = number("size", size) / self.size
        if factor <= 0.0:
            raise ParameterError(f"`size` is {size:g}; above 0 is allowed")
        model = self._bounded([i.widened(factor) for i in self.inputs], lambda m: m.with_size(size))
        model._size = float(size)
        return model

    def with_widths(self, factors: ArrayLike) -> Self:
        """Return the model with each input's bounds `factors` times as wide, (d,).

        Raises
        ------
        ParameterError
            If they are not d numbers of at least 0, or leave no input to vary.
        """
        shares = self._factors(factors).tolist()
        inputs = [i.widened(f) for i, f in zip(self.inputs, shares, strict=True)]
        return self._bounded(inputs, lambda proxy: proxy.with_widths(factors))

    def with_quantile(self, quantile: float | None) -> Self:
        """Return the model with bounds that hold the central `quantile` of each distribution.

        Inputs that are whole numbers or choices keep theirs. None goes back to the stated bounds.
        What is drawn for sampling and influence stays as it is.
        """
        inputs = [one.with_quantile(quantile) for one in self.inputs]
        return self._bounded(inputs, lambda proxy: proxy.with_quantile(quantile))

    def _bounded(self, inputs: Sequence[Input], likewise: "Callable[[Model], Model]") -> Self:
        """Return the model with other bounds, its proxy treated likewise."""
        model = self._copy()
        model.inputs = tuple(inputs)
        model._lay_bounds()
        if self.proxy is not None:
            model.proxy = likewise(self.proxy)
        return model

    # What it can do.

    @property
    def has_gradient(self) -> bool:
        """Whether exact derivatives of the outputs are known by every input that varies."""
        return self._gradient is not None and not self._grids

    @property
    def has_picture(self) -> bool:
        """Whether the model can be drawn."""
        return self._draw is not None

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
        slopes = np.einsum("nm,nmd->nd", weights, jacobian)[:, self.free]
        slopes *= (self.upper - self.lower)[self.free]
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
