"""The side of a model that is run: here or elsewhere, kept, timed out, its failures told."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kneecore import runs
from kneecore.box import Box
from kneecore.errors import ModelError, ParameterError
from kneecore.inputs import Input
from kneecore.outputs import Output
from kneecore.progress import Cancelled
from kneecore.runs.evaluation import Evaluation, Watch
from kneecore.runs.options import RunOptions

if TYPE_CHECKING:
    from kneecore.runs.engine import Engine
    from kneecore.runs.part import Failure
    from kneecore.runs.work import Work

__all__ = ["Run", "Runner"]

FloatArray = NDArray[np.float64]
Run = Callable[[FloatArray], ArrayLike]


class Runner(Box):
    """Inputs, and a function that is run for them.

    Parameters
    ----------
    run : callable, optional
    inputs : sequence of Input
    outputs : tuple of Output
    batched : bool
    options : RunOptions
    """

    name: str
    threads: int | None
    file: str | None = None
    """File that it was read from."""
    can_keep = True
    """Whether runs are worth a line in a file."""

    def __init__(
        self,
        run: Run | None,
        inputs: Sequence[Input],
        outputs: tuple[Output, ...],
        *,
        batched: bool,
        options: RunOptions,
        correlation: Any = None,
    ) -> None:
        super().__init__(inputs, correlation)
        self.outputs = outputs
        self._run, self._batched = run, batched
        self._take_options(options)

    def _take_options(self, options: RunOptions) -> None:
        if options.keep is not None and not self.can_keep:
            raise ParameterError(
                f"`keep` is {options.keep!r}; this model is run faster than a file is read: "
                "its runs are not kept"
            )
        self._options = options
        self._engine: Engine | None = None
        self._plain: Work | None = None
        self._examined: tuple[int, Work] | None = None
        if self._run is not None:
            kind = runs.work.BatchWork if self._batched else runs.work.RowWork
            self._plain = kind(self._run, self.n_outputs, options.retries)
        elif options.workers is None and options.timeout_s is None:
            return  # nothing stands between the caller and what examines itself
        told = [(i.name, i.unit) for i in self.inputs], [(o.name, o.axis) for o in self.outputs]
        self._engine = runs.engine.Engine(
            options,
            digest="" if options.keep is None else runs.identity.digest_of(self._run, *told),
            stop=getattr(self._run, "stop_programs", None),
        )

    @property
    def n_outputs(self) -> int:
        """Numbers that one run returns, m."""
        return sum(output.n_columns for output in self.outputs)

    def with_runs(self, **options: Any) -> Self:
        """Return the model with its runs done in another way.

        Parameters
        ----------
        **options
            `workers`, `keep`, `timeout_s`, `on_failure`, `retries`, `rerun_failures`, as for
            `Model`; those that are not given stay as they are.

        Raises
        ------
        ParameterError
            If one is not allowed.
        """
        known = vars(self._options)
        unknown = set(options) - set(known)
        if unknown:
            raise ParameterError(
                f"`{min(unknown)}` is no option of runs; {', '.join(known)} are allowed"
            )
        model = self._copy()
        model._take_options(replace(self._options, **options))
        return model

    @property
    def run_options(self) -> RunOptions:
        """How its runs are done; see `with_runs`."""
        return self._options

    @property
    def failures(self) -> "tuple[Failure, ...]":
        """The runs that failed until now, the first thousand: inputs, message, where files are.

        Models that were made from this one (`with_size`) share them. A model with counts of its
        own, such as `Knee`, tells its failures by those.
        """
        return () if self._engine is None else tuple(self._engine.failures)

    @property
    def told_failure(self) -> str:
        """The last failure as the end of a message, such as "; run 7 raised ..."; or nothing."""
        return f"; {self.failures[-1]}" if self.failures else ""

    def close(self) -> None:
        """End the workers, and let go of the file of runs; a later run begins anew."""
        if self._engine is not None:
            self._engine.close()

    def evaluate(self, x: ArrayLike) -> FloatArray:
        """Run the model.

        Parameters
        ----------
        x : array_like, shape (n, d)

        Returns
        -------
        ndarray, shape (n, m)
            A row that is not finite is a failed run; `failures` has its reason.

        Raises
        ------
        ParameterError
            If `x`, or what the model returns for its first run, has another shape, or is not made
            of real numbers.
        ModelError
            If the first three runs of the model all fail, or one fails and `on_failure` is "abort".
        """
        points = self._points("x", x)
        if points.ndim != 2:
            raise ParameterError(
                f"`x` has shape {points.shape}; (n, {len(self.inputs)}) is allowed"
            )
        self.check_allowed(points)
        return self.examine(points).y

    @property
    def screening(self) -> Self:
        """The model as a search of very many points may use it: doomed runs may fail early.

        A run that does not fail gives what it always gives.
        """
        return self

    def marks(self, x: FloatArray) -> Mapping[str, int]:
        """Return how many of the points (n, d) bear each of the model's marks, such as "unsettled".

        Empty where a model has none.
        """
        del x
        return {}

    def examine(
        self, x: FloatArray, *, observe: bool = False, watch: Watch | None = None
    ) -> Evaluation:
        """Run the model for points (n, d) and count what became of the runs.

        With `observe`, further quantities are returned where the model has any. `watch` gets the
        number of runs done, now and then; a true result cancels (raises `Cancelled`).
        """
        for done in self._stream([x], observe=observe, watch=watch):
            if len(done.y) == len(x):
                return done
        raise Cancelled

    def stream(
        self, batches: Iterable[FloatArray], *, observe: bool = False, watch: Watch | None = None
    ) -> Iterator[Evaluation]:
        """Yield what becomes of batches of points (n, d), in order, while later ones are run.

        `watch` gets the number of runs done, now and then; after a true result the stream ends
        early, with what was done.
        """
        if type(self).examine is Runner.examine:
            yield from self._stream(batches, observe=observe, watch=watch)
            return
        n_done = 0  # a model that examines in a way of its own
        for x in batches:
            if watch is not None and watch(n_done) and n_done:
                return
            yield self.examine(x, observe=observe)
            n_done += len(x)

    def _stream(
        self, batches: Iterable[FloatArray], *, observe: bool, watch: Watch | None
    ) -> Iterator[Evaluation]:
        engine = self._engine
        if self._plain is not None:
            assert engine is not None
            yield from engine.stream(self._plain, batches, observe=observe, watch=watch)
        elif engine is not None:
            yield from engine.stream(self._sent(), batches, observe=observe, watch=watch)
        else:
            n_done = 0
            for x in batches:
                if watch is not None and watch(n_done) and n_done:
                    return
                yield self._examine(x, observe=observe)
                n_done += len(x)

    def _examine(self, x: FloatArray, *, observe: bool) -> Evaluation:
        """Run a model that has no plain function; to be overridden."""
        raise ModelError(
            f"the model {self.name!r} was read from a file, which holds no function; nothing "
            "can be computed with it"
        )

    def _sent(self) -> "Work":
        """Return a model with counts of its own as workers get it: for one thread."""
        if self._examined is None or self._examined[0] != id(self):
            model = self._copy()
            model._engine, model._examined, model.threads = None, None, 1
            self._examined = id(self), runs.work.ExamineWork(model)
        return self._examined[1]

    def warm_up(self, *, gradient: bool = False) -> None:
        """Load what the first run would have to wait for."""
        del gradient
