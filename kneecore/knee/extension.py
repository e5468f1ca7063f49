"""What two knees differ by in extension, as files hold it."""

from collections.abc import Mapping

import numpy as np

from kneecore.knee.response import LARGEST_EXTENSION, LARGEST_FLEXION, Response
from kneecore.numbers import DIGITS

__all__ = ["extension_difference_deg", "extension_difference_percent"]


def _degrees(response: Response, load: int) -> float:
    """Return an angle as files hold it, so that what is derived from it survives a file."""
    return round(float(np.degrees(response.flexion[load])), DIGITS)


def extension_difference_deg(responses: Mapping[str, Response]) -> float | None:
    """Return the angle of model 2 less that of model 1 at the largest extension moment, deg.

    `responses` are those of a search's result: baseline, model_1, model_2.
    """
    one, two = (_degrees(responses[name], LARGEST_EXTENSION) for name in ("model_1", "model_2"))
    return two - one if np.isfinite(two - one) else None


def extension_difference_percent(responses: Mapping[str, Response]) -> float | None:
    """Return the same in per cent of the baseline's range of motion between the largest moments."""
    baseline = responses["baseline"]
    motion = _degrees(baseline, LARGEST_FLEXION) - _degrees(baseline, LARGEST_EXTENSION)
    difference = extension_difference_deg(responses)
    if difference is None or not np.isfinite(motion) or motion == 0.0:
        return None
    return 100.0 * difference / motion
