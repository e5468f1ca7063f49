"""Which measurement must be how good, as JSON, and back."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError
from kneecore.files import needed_accuracy
from kneecore.files.model import array, number_or_none
from kneecore.files.origin import column_of, numbers_of, origin_table, read_origin, read_versions
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.numbers import exact
from kneecore.presented import Format, rendered
from kneecore.report.accuracy_allocation import WORDS
from kneecore.study.accuracy_allocation import AccuracyAllocation
from kneecore.study.best_search import searches_in_model
from kneecore.study.settings import AccuracyAllocationSettings

__all__ = ["FORMAT", "from_dict", "to_dict"]

FloatArray = NDArray[np.float64]
SCHEMA = "kneecore.accuracy_allocation/1"
_NAMES = ("within", "tolerance", "nominal_value", "largest_value", "sampled_value", "gain", "alone")
_KNEE_KEYS: Mapping[str, str] = {
    "within": "within_deg",
    "tolerance": "tolerance_mm",
    "nominal_value": "nominal_angle_deg",
    "largest_value": "largest_angle_deg",
    "sampled_value": "sampled_largest_angle_deg",
    "gain": "adds_deg",
    "alone": "enlarged_deg",
}
"""What a knee's numbers are called: with their units."""
_KNEE_ORIGIN = frozenset({"case", "solver", "rest_length", "baseline", "model"})
_TOLD_ABOVE = _KNEE_ORIGIN | {"schema", "within", "within_deg", "seed", "versions"}
_TOLD_ABOVE |= {"tolerance", "tolerance_mm", "column", "in_model"}


def _keys(model: Model) -> Mapping[str, str]:
    return _KNEE_KEYS if isinstance(model, Knee) else {name: name for name in _NAMES}


def _entry(values: FloatArray | None, k: int) -> float | None:
    return None if values is None else exact(values[k])


def _measurement(found: AccuracyAllocation, k: int) -> dict[str, Any]:
    key, told = _keys(found.model), numbers_of(found.model)
    tolerances = [
        None if shares is None else exact(found.stated[k] * shares[k])
        for shares in (found.equal_factors, found.factors)
    ]
    return {
        "name": found.names[k],
        "inputs": list(found.inputs[k]),
        "unit": found.units[k],
        "stated": exact(found.stated[k]),
        "equal": tolerances[0],
        "cheapest": tolerances[1],
        "equal_share": _entry(found.equal_factors, k),
        "cheapest_share": _entry(found.factors, k),
        "as_stated": bool(found.as_stated[k]),
        "cost": exact(found.costs[k]),
        key["gain"]: told(_entry(found.gains, k)),
        key["alone"]: told(_entry(found.enlarged, k)),
    }


def to_dict(found: AccuracyAllocation) -> dict[str, Any]:
    """Return the answer as JSON-ready values."""
    model, settings = found.model, found.settings
    key, told = _keys(model), numbers_of(model)
    equal = needed_accuracy.to_dict(found.equal)
    knee = isinstance(model, Knee)
    return {
        "schema": SCHEMA,
        "answer": WORDS.summary(found),
        key["within"]: settings.within,
        "measurements": [_measurement(found, k) for k in range(len(found.names))],
        "equal_cost": found.equal_cost,
        "cheapest_cost": found.cost,
        key["nominal_value"]: told(found.nominal_value),
        key["largest_value"]: told(found.largest_value),
        key["sampled_value"]: told(found.sampled_value),
        "n_sampled": found.n_sampled,
        "n_sampled_failed": found.n_sampled_failed,
        "n_searches": found.n_searches,
        "equal": {name: value for name, value in equal.items() if name not in _TOLD_ABOVE},
        "seconds": round(found.seconds, 6),
        "costs": settings.costs,
        key["tolerance"]: settings.tolerance,
        "seed": settings.seed,
        **({} if knee else {"column": found.column, "in_model": found.in_model}),
        **origin_table(model),
        "versions": dict(found.versions),
    }


def _column(rows: list[dict[str, Any]], key: str) -> FloatArray | None:
    """Return one number a measurement; None where no measurement has one."""
    values = [number_or_none(row, key) for row in rows]
    if all(value is None for value in values):
        return None
    return np.array([np.nan if value is None else value for value in values])


def _shares(rows: list[dict[str, Any]], key: str) -> FloatArray | None:
    shares = _column(rows, key)
    if shares is not None and not (shares > 0.0).all():
        raise FileFormatError(f"`measurements.{key}` has none for some; a number above 0 is needed")
    return shares


def from_dict(document: dict[str, Any]) -> AccuracyAllocation:
    """Return the answer that `to_dict` has told."""
    model = read_origin(document)
    key, rows = _keys(model), document["measurements"]
    knee, factors = isinstance(model, Knee), _shares(rows, "cheapest_share")
    enlarged = _column(rows, key["alone"])
    if enlarged is None and factors is not None:
        enlarged = np.full(len(rows), np.nan)
    return AccuracyAllocation(
        model=model,
        settings=AccuracyAllocationSettings(
            within=document[key["within"]],
            costs=document["costs"],
            tolerance=document[key["tolerance"]],
            seed=document["seed"],
        ),
        column=column_of(document, model),
        equal=needed_accuracy.from_dict(document | document["equal"]),
        names=tuple(str(row["name"]) for row in rows),
        inputs=tuple(tuple(map(str, row["inputs"])) for row in rows),
        stated=array([row["stated"] for row in rows], (len(rows),), "stated"),
        units=tuple(str(row["unit"]) for row in rows),
        costs=array([row["cost"] for row in rows], (len(rows),), "cost"),
        equal_factors=_shares(rows, "equal_share"),
        factors=factors,
        gains=_column(rows, key["gain"]),
        enlarged=enlarged,
        nominal_value=float(document[key["nominal_value"]]),
        largest_value=float(document[key["largest_value"]]),
        sampled_value=number_or_none(document, key["sampled_value"]),
        n_sampled=int(document["n_sampled"]),
        n_sampled_failed=int(document["n_sampled_failed"]),
        n_searches=int(document["n_searches"]),
        in_model=searches_in_model(model) if knee else bool(document["in_model"]),
        seconds=float(document["seconds"]),
        versions=read_versions(document),
    )


def _others(found: AccuracyAllocation, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(found)


FORMAT = Format(
    schema=SCHEMA,
    file="accuracy_allocation.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
