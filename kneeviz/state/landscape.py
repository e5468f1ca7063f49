"""What the landscape knows: whether it is shown, of what, and the thread that computes its grid."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kneecore import READINGS, Knee, KneecoreError, Landscape, ParameterSpace, TrainedSurrogate
from kneeviz.jobs import computations
from kneeviz.jobs.messages import Post
from kneeviz.jobs.worker import Actions, Worker
from kneeviz.state.knee import KneeState
from kneeviz.state.origin import Origin, digest, of_space

FloatArray = NDArray[np.float64]

FAVOURITES = ("pcl_femur_x", "condyle_x")
"""The two that decide most in the packaged knee, so that its slope faces the camera."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Slice:
    """What a landscape is asked to be of."""

    x: FloatArray
    knee: Knee
    """The knees within the bounds."""
    surrogate: TrainedSurrogate | None
    names: tuple[str, str]
    own_deg: FloatArray
    """The knee's 12 angles in the true model, deg."""
    predicted_deg: FloatArray | None
    """The same by the surrogate."""

    def same_as(self, other: "Slice | None") -> bool:
        """Tell whether both ask for the same grid."""
        return (
            other is not None and self.origin == other.origin and self.surrogate is other.surrogate
        )

    @property
    def origin(self) -> Origin:
        """What the grid is computed for."""
        box = of_space(self.knee.space, self.knee.rest_length)
        return replace(box, knee=digest(self.x), axes=digest(*self.names))

    def compute(self) -> Landscape:
        """Run kneecore over the grid."""
        return computations.landscape(self.knee, self.x, self.names, self.surrogate)


def free_names(space: ParameterSpace) -> tuple[str, ...]:
    """Return the parameters that the bounds let vary."""
    return tuple(n for n, free in zip(space.names, space.free, strict=True) if free)


class LandscapeFound(NamedTuple):
    """What a request for a landscape came to."""

    asked: Slice | None
    found: Landscape | None
    why: str | None
    """What went wrong, if nothing was found."""


class LandscapeState:
    """The landscape's settings, its grid, and the thread behind it.

    Parameters
    ----------
    post : callable
        Gets "landscape_found" with a `LandscapeFound`.
    """

    def __init__(self, post: Post) -> None:
        self._post = post
        self._worker: Worker | None = None
        self._asked: Slice | None = None
        self.shown = False
        self.names: tuple[str, str] = FAVOURITES
        self.height = READINGS[1]
        self.zoom = False
        self.found: tuple[Slice, Landscape] | None = None
        self.drawn: tuple[Any, ...] = ()
        """What the picture on screen was made of."""
        self.cameras: dict[int, tuple[Any, Any]] = {}
        """Position and target of the cameras that visitors had moved before the landscape came."""

    @property
    def origin(self) -> Origin | None:
        """What the grid on screen was computed for; None without one."""
        return self.found[0].origin if self.shown and self.found is not None else None

    @property
    def axes(self) -> str:
        """The digest of the two parameters that are chosen."""
        return digest(*self.names)

    def stop(self) -> None:
        """End the thread."""
        if self._worker is not None:
            self._worker.stop()

    def choose(self, axis: int, name: str) -> None:
        """Put a parameter on one of the two axes; the other axis takes its place if it had it."""
        names = list(self.names)
        if names[1 - axis] == name:
            names[1 - axis] = names[axis]
        names[axis] = name
        self.names = (names[0], names[1])

    def fit_names(self, space: ParameterSpace) -> bool:
        """Keep to parameters that vary; return whether there are two of them."""
        free = free_names(space)
        if len(free) < 2:
            return False
        if not set(self.names) <= set(free):
            kept = [name for name in (*self.names, *FAVOURITES, *free) if name in free]
            first, second, *_ = dict.fromkeys(kept)
            self.names = (first, second)
        return True

    def ask(self, state: KneeState) -> None:
        """Have the grid computed around the knee on screen, unless it has been asked for."""
        current = state.current
        if current is None or not self.fit_names(state.space):
            return
        predicted = state.predict(current.x)
        wanted = Slice(
            x=current.x,
            knee=state.knees(),
            surrogate=None if predicted is None else state.surrogate,
            names=self.names,
            own_deg=np.degrees(current.response.flexion),
            predicted_deg=None if predicted is None else np.degrees(predicted),
        )
        if wanted.same_as(self._asked):
            return
        self._asked = wanted
        if self._worker is None:
            self._worker = Worker(self._compute, self._failed, name="landscape")
            self._worker.start()
        self._worker.mailbox.post("grid", wanted)

    def _compute(self, actions: Actions) -> None:
        for _, wanted in actions:
            try:
                self._post("landscape_found", LandscapeFound(wanted, wanted.compute(), None))
            except KneecoreError as error:
                self._post("landscape_found", LandscapeFound(wanted, None, str(error)))

    def _failed(self, error: Exception) -> None:
        why = f"{type(error).__name__}: {error}"
        self._post("landscape_found", LandscapeFound(None, None, why))
