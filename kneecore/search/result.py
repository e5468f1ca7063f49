"""What a worst-case search found, with everything needed to judge and to repeat it."""

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from kneecore import __version__
from kneecore.knee.model import Objective
from kneecore.knee.response import MOMENT, Response, RestLength, Solver
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import DIGITS
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.search.repair_history import Repair
from kneecore.search.rival import Rival
from kneecore.search.settings import Method, SearchSpace
from kneecore.search.sign_climb import Evidence

__all__ = ["PairResult", "SearchResult", "versions"]

FloatArray = NDArray[np.float64]
COUNTS = (
    "pairs_evaluated",
    "models_simulated",
    "models_failed",
    "models_refined",
    "models_unsettled",
)
"""Keys of `SearchResult.counts`."""
LARGEST_EXTENSION = int(np.argmax(MOMENT))
LARGEST_FLEXION = int(np.argmin(MOMENT))


@cache
def _installed() -> dict[str, str]:
    # Read once: it takes milliseconds, a good part of a quick search.
    return {name: version(name) for name in ("numpy", "scipy", "numba")}


def versions() -> dict[str, str]:
    """Return the versions that a result's bytes depend on."""
    return {"kneecore": __version__, "python": platform.python_version()} | _installed()


def _degrees(response: Response, load: int) -> float:
    """Return an angle as files hold it, so that what is derived from it survives a file."""
    return round(float(np.degrees(response.flexion[load])), DIGITS)


@dataclass(frozen=True, kw_only=True, eq=False)
class PairResult:
    """The two most different models of any kind (for the knee: `SearchResult`)."""

    names: tuple[str, ...]
    """Names of the inputs."""
    lower: FloatArray
    """Shape (d,)."""
    upper: FloatArray
    """Shape (d,)."""
    x: FloatArray
    """The two models, shape (2, d)."""
    y: FloatArray
    """The model's outputs for them, shape (2, m)."""
    objective_surrogate: float | None
    """f by the surrogate, of a repaired one the largest that it still promises; None where the
    search was in the model."""
    objective_model: float | None
    """f by the model; None if one of the two fails there."""
    gap_percent: float | None
    """100 (surrogate - model) / surrogate."""
    loo_rms: float | None
    """The surrogate's root mean square leave-one-out error, in the outputs' unit."""
    n_failed: int
    """Training samples whose model failed."""
    run_values: tuple[float, ...]
    """Best f of each run of the genetic algorithm."""
    history: FloatArray
    """Best f after each generation of the best run."""
    n_evaluations: int
    """Pairs that the genetic algorithm evaluated."""
    stop_reason: str
    seed: int
    seconds: Mapping[str, float]
    repair: Repair | None = None
    """How the surrogate was repaired."""

    def __repr__(self) -> str:
        return f"PairResult(objective_model={self.objective_model}, x={self.x.tolist()})"

    def __str__(self) -> str:
        from kneecore.report.search import pair_report

        return pair_report(self)

    def _repr_html_(self) -> str:
        from kneecore.report.search import pair_report

        return pair_report(self, html=True)


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchResult:
    """The two most different knees of a space.

    Model 1 is the one with the smaller angle at the largest extension moment: it over-extends.
    """

    space: ParameterSpace
    """The space that was searched, its baseline included."""
    search_space: SearchSpace
    """Where the search was: in the `surrogate` or in the `model`."""
    objective: Objective
    """Which loads count: `all`, `extension` or `flexion`."""
    rest_length: RestLength
    x: FloatArray
    """The two knees, shape (2, 28), SI."""
    baseline: Response
    """The true model's response of the space's baseline."""
    model_1: Response
    """The true model's response of ``x[0]``."""
    model_2: Response
    """The true model's response of ``x[1]``."""
    predicted_flexion: FloatArray | None
    """The surrogate's angles of the two, shape (2, 12), rad; None where it was not used."""
    objective_surrogate: float | None
    """f by the surrogate, deg summed over the loads that count; of a repaired one, the largest that
    it still promises. None in the true model's space."""
    objective_model: float | None
    """f by the true model, deg; None if one of the two knees fails there."""
    gap_percent: float | None
    """100 (surrogate - model) / surrogate."""
    training_x: FloatArray | None
    """Training knees, shape (n, 28), SI."""
    training_flexion: FloatArray | None
    """Their angles, shape (n, 12), rad; NaN where the model failed."""
    loo_rms_deg: float | None
    """The surrogate's root mean square leave-one-out error, deg."""
    run_values: tuple[float, ...]
    """Best f of each run in the space searched, deg."""
    history: FloatArray
    """Best f after each generation of the best run, deg."""
    pop_size: int
    n_generations: int
    n_runs: int
    """Runs that were asked for; `run_values` tells how many there were."""
    training_samples: int
    options: GeneticOptions
    seed: int
    stop_reason: str
    """`max_generations`, `converged` (an exact search), `repaired` or `not_repaired` (whether the
    surrogate's gap fell below the goal), or `cancelled`."""
    counts: Mapping[str, int]
    """Pairs evaluated; models simulated, failed, refined and unsettled, over the whole search."""
    seconds: Mapping[str, float]
    """compile, sampling, fit, search (the optimisation alone), verify; compare_ and the method for
    each rival."""
    threads: int
    """Threads that the true model was run on; the numbers do not depend on it."""
    versions: Mapping[str, str]
    method: Method = "ga"
    """`ga`, the paper's genetic algorithm, or `exact`, climbs with exact gradients."""
    solver: Solver = "dynamics"
    """Which response of the true model: its motion over 23 s, or `equilibrium`."""
    evidence: Evidence | None = None
    """What an exact search says about how good its result is."""
    repair: Repair | None = None
    """How the surrogate was repaired; None if it was not asked to be."""
    rivals: tuple[Rival, ...] = ()
    """What all methods find in the same space (`kneecore.search.compare.with_rivals`)."""

    @property
    def case(self) -> str:
        """`both`, `geometry` or `material`."""
        return self.space.case

    @property
    def models(self) -> dict[str, Response]:
        """The three responses by name: baseline, model_1, model_2."""
        return {"baseline": self.baseline, "model_1": self.model_1, "model_2": self.model_2}

    @property
    def best_of_all(self) -> float | None:
        """The largest f in the true model, deg, of this search and of all rivals."""
        known = [r.objective[-1] for r in self.rivals if r.objective]
        return max(
            [*known, *([self.objective_model] if self.objective_model else [])], default=None
        )

    @property
    def extension_difference_deg(self) -> float | None:
        """Angle of model 2 less that of model 1 at the largest extension moment, deg."""
        one, two = (_degrees(model, LARGEST_EXTENSION) for model in (self.model_1, self.model_2))
        return two - one if np.isfinite(two - one) else None

    @property
    def extension_difference_percent(self) -> float | None:
        """The same in per cent of the baseline's range of motion between the largest moments."""
        motion = _degrees(self.baseline, LARGEST_FLEXION) - _degrees(
            self.baseline, LARGEST_EXTENSION
        )
        difference = self.extension_difference_deg
        if difference is None or not np.isfinite(motion) or motion == 0.0:
            return None
        return 100.0 * difference / motion

    def __repr__(self) -> str:
        return f"SearchResult({self.summary()!r}, objective_model={self.objective_model})"

    def __str__(self) -> str:
        from kneecore.report.search import result_report

        return result_report(self)

    def _repr_html_(self) -> str:
        from kneecore.report.search import result_html

        return result_html(self)

    def summary(self) -> str:
        """Return what differs, in one sentence."""
        from kneecore.report.search import summary_sentence

        return summary_sentence(self)

    def command(self) -> str:
        """Return the command line that gives this result again.

        Where the space is not the packaged one it reads the `knee.toml` that `save` writes.
        """
        from kneecore.report.command import command_line

        return command_line(self)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON-ready values; see ``result.schema.json`` for their meaning."""
        from kneecore.files.search import to_document

        return to_document(self)

    def to_json(self) -> str:
        """Return the result as JSON text."""
        from kneecore.files.search import to_text

        return to_text(self)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the result that `to_json` wrote.

        Raises
        ------
        FileFormatError
            If the text is no result of a known schema.
        """
        from kneecore.files.search import from_text

        return from_text(cls, text)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Return the result in a `result.json`, or in the folder that holds one.

        Raises
        ------
        FileFormatError
            If it cannot be read or is no result; the message names the file.
        """
        from kneecore.files.search import load

        return load(cls, path)

    def curves_csv(self) -> str:
        """Return angles, forces and positions as CSV text, one row a model and load."""
        from kneecore.files.search import curves_csv

        return curves_csv(self)

    def save(
        self, folder: str | Path, *, force: bool = False, figures: bool = True
    ) -> tuple[Path, ...]:
        """Write `result.json`, `curves.csv` and the figures (PNG and SVG) to `folder`.

        Each file is written whole or not at all, `result.json` last.

        Returns
        -------
        tuple of Path
            The files, in the order written.

        Raises
        ------
        OutputError
            If the folder holds a result already and `force` is not given, or cannot be written.
        """
        from kneecore.files.folder import save

        return save(self, folder, force=force, figures=figures)
