"""What a model's page knows. No widget, no thread."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kneecore import (
    FileFormatError,
    InfluenceResult,
    KneecoreError,
    Landscape,
    Model,
    MonteCarloResult,
    SearchResult,
    Shape,
    TrainedSurrogate,
)
from kneeviz.anymodel.dials import Dial, dials
from kneeviz.anymodel.runs import Ran
from kneeviz.jobs.job import Job

FloatArray = NDArray[np.float64]

FAST_SECONDS = 0.05
"""A model that takes less follows the sliders; any other is run when it is asked to."""
_MEASURED = 5


@dataclass(kw_only=True, eq=False)
class ModelState:
    """A model, the point that the sliders show, and all that was found."""

    model: Model
    x: FloatArray
    """The sliders' point, shape (d,)."""
    dials: Sequence[Dial]
    nominal: FloatArray | None = None
    """Outputs of the nominal inputs, shape (m,)."""
    last: Ran | None = None
    """The last run that gave outputs."""
    surrogate: TrainedSurrogate | None = None
    result: SearchResult | None = None
    sampled: MonteCarloResult | None = None
    influence: InfluenceResult | None = None
    landscape: Landscape | None = None
    shapes: dict[int, Sequence[Shape]] = field(default_factory=dict)
    """The last good pictures, by whose they are."""
    overlay: bool = False
    """Whether both worst models are shown."""
    band: bool = True
    """Whether what was sampled is drawn behind the curves."""
    column: int = 0
    """The output that influence and landscape show."""
    landscape_seconds: float = 0.0
    """What it took."""
    landscape_shown: bool = False
    in_surrogate: bool = False
    """Whether the landscape is that of the surrogate alone."""
    job: Job | None = None
    """The long computation that goes on: one at a time, for they share the model's processes."""
    job_began: float = 0.0
    """When it began, s of `time.monotonic`."""
    rising: list[float] = field(default_factory=list)
    _seconds: deque[float] = field(default_factory=lambda: deque(maxlen=_MEASURED))

    @classmethod
    def of(cls, model: Model) -> "ModelState":
        """Return what is known of a model before it has been run."""
        return cls(model=model, x=model.nominal.copy(), dials=dials(model))

    @property
    def seconds(self) -> float | None:
        """What a run takes undisturbed by others, s; None before the first."""
        return min(self._seconds, default=None)

    @property
    def fast(self) -> bool:
        """Whether the model is fast enough to follow the sliders."""
        return self.seconds is not None and self.seconds <= FAST_SECONDS

    @property
    def slow(self) -> bool:
        """Whether it is known to be too slow for that."""
        return self.seconds is not None and self.seconds > FAST_SECONDS

    @property
    def is_here(self) -> bool:
        """Whether the last run was for the sliders' point."""
        return self.last is not None and np.array_equal(self.last.x, self.x)

    @property
    def at_home(self) -> bool:
        """Whether all sliders are at home."""
        return np.array_equal(self.x, self.model.nominal)

    @property
    def predicted(self) -> FloatArray | None:
        """The surrogate's outputs for the sliders' point, shape (m,)."""
        if self.surrogate is None:
            return None
        try:
            return self.surrogate.predict(self.x)
        except KneecoreError:
            return None

    def take(self, ran: Ran) -> None:
        """Take what became of a run in."""
        if ran.y is not None or not (ran.cancelled or self._seconds):
            self._seconds.append(ran.seconds)  # a failure tells little of what others take
        if ran.y is None:
            return
        self.last = ran
        if np.array_equal(ran.x, self.model.nominal):
            self.nominal = ran.y

    def same_bounds(self, result: SearchResult) -> bool:
        """Tell whether a result that belongs to this model also has its bounds."""
        theirs, ours = result.model, self.model
        return np.array_equal(theirs.lower, ours.lower) and np.array_equal(theirs.upper, ours.upper)


def belongs(result: SearchResult, model: Model) -> bool:
    """Tell whether a result has the inputs and outputs of a model."""
    theirs = result.model
    return theirs.names == model.names and [(o.name, o.axis) for o in theirs.outputs] == [
        (o.name, o.axis) for o in model.outputs
    ]


def of_this_model(model: Model, loaded: object) -> SearchResult:
    """Return what was loaded, if it is a result of the page's model.

    Raises
    ------
    FileFormatError
        If it is something else.
    """
    if not isinstance(loaded, SearchResult):
        raise FileFormatError("it is a knee; a result of this page's model is needed")
    if not belongs(loaded, model):
        raise FileFormatError(
            f"`result` is of the model {loaded.model.name[:60]!r}, whose inputs and outputs are "
            "others than this page's"
        )
    return loaded
