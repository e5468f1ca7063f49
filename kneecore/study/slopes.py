"""What the outputs of a worst case gain by each input: slopes at the two models."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import ModelError
from kneecore.search.result import SearchResult
from kneecore.study.influence import check_column
from kneecore.unit_model import UnitModel

__all__ = ["WorstCaseSlopes", "worst_case_slopes"]

FloatArray = NDArray[np.float64]
_STEP = 1e-4  # of an input's range, for central differences


@dataclass(frozen=True, kw_only=True, eq=False)
class WorstCaseSlopes:
    """What the outputs of two models gain over each free input's half-range, by slope."""

    names: tuple[str, ...]
    slopes: FloatArray
    """Change of the outputs for one half-range more of an input, shape (2, m, n_free)."""

    def deciding(self, column: int, count: int = 5) -> list[str]:
        """Return the inputs whose slopes separate the two models most in an output (index)."""
        check_column(column, self.slopes.shape[1])
        weight = np.abs(self.slopes[:, column]).sum(axis=0)
        return [self.names[k] for k in np.argsort(-weight, kind="stable")[:count]]


def worst_case_slopes(result: SearchResult) -> WorstCaseSlopes:
    """Return the slopes of the two worst-case models' outputs, by central differences.

    Raises
    ------
    ModelError
        If a model beside one of the two fails.
    """
    model = result.model
    u = model.to_free_unit(result.x)
    step = model.steps(_STEP)
    steps = np.diag(step)
    # The worst case lies on bounds: keep both sides of the difference within the cube.
    centre = np.clip(u, step, 1.0 - step)
    points = np.concatenate([centre[:, None] + steps, centre[:, None] - steps], axis=1)
    y = UnitModel(model)(points.reshape(-1, model.n_free))
    y = y.reshape(2, 2, model.n_free, model.n_outputs)
    if not np.isfinite(y).all():
        raise ModelError("a model beside the worst case fails; its slopes are not known")
    per_half_range = 0.5 * (y[:, 0] - y[:, 1]) / (2.0 * step[:, None])
    return WorstCaseSlopes(names=model.free_names, slopes=per_half_range.transpose(0, 2, 1))
