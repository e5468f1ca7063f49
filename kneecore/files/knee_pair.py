"""What a search's result tells of knees beyond their parameters: angles, forces, positions."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError
from kneecore.files.evidence import optional
from kneecore.files.model import array, baseline_table, knee_vector, number_or_none, read_knee
from kneecore.files.response import MARKS, read_response, response_table
from kneecore.knee.extension import extension_difference_deg, extension_difference_percent
from kneecore.knee.model import Knee
from kneecore.knee.parameters import LIGAMENTS, check_physical
from kneecore.knee.response import MOMENT, Response
from kneecore.numbers import plain
from kneecore.search.result import MODELS, SearchResult

__all__ = ["knee_curves", "knee_part", "read_knee_part"]

FloatArray = NDArray[np.float64]

_N_LOADS = len(MOMENT)
_DEGREES = 180.0 / math.pi


def knee_part(result: SearchResult) -> dict[str, Any]:
    """Return what a result tells of knees."""
    knee, models = result.model, result.responses
    assert isinstance(knee, Knee)
    document: dict[str, Any] = {
        "extension_difference_deg": optional(extension_difference_deg(models)),
        "extension_difference_percent": optional(extension_difference_percent(models)),
        "case": knee.space.case,
        "solver": knee.solver,
        "rest_length": knee.rest_length,
        "moment_nm": MOMENT.tolist(),
        "predicted_flexion_deg": _predicted(result),
        "training": _training(result),
        "baseline": baseline_table(knee.space),
    }
    for name, response in models.items():
        for key, value in response_table(response).items():
            document.setdefault(key, {})[name] = value
    return document


def _predicted(result: SearchResult) -> dict[str, Any] | None:
    if result.y_surrogate is None:
        return None
    return {name: plain(y) for name, y in zip(MODELS[1:], result.y_surrogate, strict=True)}


def _training(result: SearchResult) -> dict[str, Any] | None:
    if result.training_x is None or result.training_y is None:
        return None
    failed = ~np.isfinite(result.training_y).all(axis=1)
    return {
        "n_samples": len(result.training_x),
        "n_failed": int(np.count_nonzero(failed)),
        "loo_rms_deg": optional(result.loo_rms),
        "parameters": result.training_x.tolist(),
        "flexion_deg": plain(result.training_y),
    }


def _response(document: dict[str, Any], name: str) -> Response:
    """Return the response of one of the three knees."""
    try:
        return read_response(
            {
                key: table[name]
                for key, table in document.items()
                if isinstance(table, dict) and name in table
            }
        )
    except FileFormatError as error:
        raise FileFormatError(f"{name}: {error}") from None


def read_knee_part(document: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a result that `knee_part` has told."""
    knee = read_knee(document)
    sets, predicted = document["parameters"], document["predicted_flexion_deg"]
    if not isinstance(sets, list) or len(sets) != 2:
        raise FileFormatError("`parameters` must hold two knees")
    flexion = {name: array(document["flexion_deg"][name], (_N_LOADS,), name) for name in MODELS}
    responses = {name: _response(document, name) for name in MODELS}
    training = document["training"]
    n = -1 if training is None else len(training["parameters"])
    return {
        "model": knee,
        "x": check_physical([knee_vector(x, "parameters") for x in sets], "parameters"),
        "y": _outputs(knee, responses, flexion),
        "y_nominal": flexion["baseline"],
        "y_surrogate": None
        if predicted is None
        else array([predicted[name] for name in MODELS[1:]], (2, _N_LOADS), "predicted"),
        "responses": responses,
        "training_x": None
        if training is None
        else array(training["parameters"], (n, -1), "training.parameters"),
        "training_y": None
        if training is None
        else array(training["flexion_deg"], (n, _N_LOADS), "training.flexion_deg"),
        "loo_rms": None if training is None else number_or_none(training, "loo_rms_deg"),
    }


def _outputs(
    knee: Knee, responses: dict[str, Response], flexion: dict[str, FloatArray]
) -> FloatArray:
    """Return the pair's outputs: where a knee at rest has lost its equilibrium, it has none."""
    at_rest = knee.solver == "equilibrium"
    lost = {name: at_rest and not math.isnan(r.lost_at) for name, r in responses.items()}
    nothing = np.full(_N_LOADS, np.nan)
    return np.stack([nothing if lost[name] else flexion[name] for name in MODELS[1:]])


def knee_curves(result: SearchResult) -> Iterator[list[Any]]:
    """Yield the rows of the curves' CSV: one a knee and load."""
    tensions = [f"tension_{name}_n" for name in LIGAMENTS]
    yield [
        *("model", "moment_nm", "flexion_deg", *tensions, "contact_force_n", "indentation_mm"),
        *("ap_position_mm", "settled", "at_rest", "implausible", "status"),
    ]
    for name, response in result.responses.items():
        columns = [
            plain(response.flexion, _DEGREES),
            *(plain(response.tension[:, i]) for i in range(len(LIGAMENTS))),
            plain(response.contact_force),
            plain(response.indentation, 1e3),
            plain(response.ap_position, 1e3),
        ]
        for k, moment in enumerate(MOMENT.tolist()):
            marks = [_mark(response, key, k) for key in ("settled", *MARKS)]
            yield [name, moment, *(c[k] for c in columns), *marks, response.status]


def _mark(response: Response, key: str, k: int) -> str:
    """Return `true` or `false`; nothing where a file has not told."""
    marks = getattr(response, key)
    return "" if marks is None else str(bool(marks[k])).lower()
