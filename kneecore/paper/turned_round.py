"""By how much f changes when a worst-case knee's stiffness is turned round."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.model import Knee
from kneecore.knee.parameters import LIGAMENTS, NAMES
from kneecore.search.result import SearchResult

__all__ = ["turned_round_percent"]

FloatArray = NDArray[np.float64]
STIFFNESS = [NAMES.index(f"{ligament}_stiffness") for ligament in LIGAMENTS]


def turned_round_percent(knee: Knee, pairs: Sequence[SearchResult]) -> FloatArray:
    """Return the change of the true f for each pair, model and ligament.

    One stiffness of one of the two knees is mirrored about the baseline's, all else is kept.

    Parameters
    ----------
    knee : Knee
    pairs : sequence of SearchResult, length n

    Returns
    -------
    ndarray, shape (n, 2, 4)
        In per cent of the pair's f; positive where turning makes the pair worse. NaN where a knee
        failed.
    """
    found = np.array([pair.y for pair in pairs])
    knees = np.array([pair.x for pair in pairs])
    changed = np.repeat(knees[:, :, None], len(STIFFNESS), axis=2)
    for k, column in enumerate(STIFFNESS):
        mirrored = 2.0 * knee.space.baseline[column] - knees[:, :, column]
        changed[:, :, k, column] = np.clip(
            mirrored, knee.space.lower[column], knee.space.upper[column]
        )
    shape = changed.shape[:3]
    turned = knee.examine(changed.reshape(-1, knees.shape[-1])).y.reshape(*shape, -1)
    other = found[:, ::-1, None]
    weights = knee.weights()
    f = (np.abs(found[:, 0] - found[:, 1]) * weights).sum(axis=-1)
    changes = (np.abs(turned - other) * weights).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        percent: FloatArray = 100.0 * (changes / f[:, None, None] - 1.0)
    return percent
