"""What a study's JSON says of the model, and numbers that are at home in every study's JSON."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._threads import thread_count
from kneecore.errors import FileFormatError
from kneecore.files.model import array, baseline_table, model_table, read_knee, read_model
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.numbers import exact, plain

__all__ = [
    "column_of",
    "numbers_of",
    "origin_table",
    "read_counts",
    "read_origin",
    "read_seconds",
    "read_versions",
    "rounded",
    "whole_numbers",
]

FloatArray = NDArray[np.float64]


def origin_table(model: Model) -> dict[str, Any]:
    """Return what a study was made of: the keys of knees, or one, `model`."""
    if not isinstance(model, Knee):
        return {"model": model_table(model)}
    return {
        "case": model.space.case,
        "solver": model.solver,
        "rest_length": model.rest_length,
        "baseline": baseline_table(model.space),
    }


def read_origin(document: dict[str, Any]) -> Model:
    """Return the model that `origin_table` has told."""
    if "model" in document:
        return read_model(document["model"])
    if "parameters" not in document["baseline"]:
        raise FileFormatError(
            "`baseline` has no `parameters`: the file was written by a version of kneecore whose "
            "studies could not be read back"
        )
    return read_knee({"threads": thread_count(None)} | document)


def numbers_of(model: Model) -> Callable[[Any], Any]:
    """Return what makes numbers JSON-ready: those of knees rounded, others of any size exact.

    None stays None.
    """
    write = plain if isinstance(model, Knee) else exact
    return lambda values: None if values is None else write(values)


def column_of(table: dict[str, Any], model: Model) -> int:
    """Return the watched output of a study; of a knee it is the model's."""
    column = table.get("column", model.watched)
    whole = isinstance(column, int) and not isinstance(column, bool)
    if not whole or not 0 <= column < model.n_outputs:
        raise FileFormatError(
            f"`column` is {column!r}; a whole number from 0 to {model.n_outputs - 1} is allowed"
        )
    return int(column)


def rounded(seconds: Mapping[str, float]) -> dict[str, float]:
    """Return times as files hold them."""
    return {name: round(value, 6) for name, value in seconds.items()}


def read_seconds(document: dict[str, Any]) -> dict[str, float]:
    """Return the times of a study."""
    return {str(name): float(value) for name, value in document["seconds"].items()}


def read_versions(document: dict[str, Any]) -> dict[str, str]:
    """Return the versions that a study was made with."""
    return {str(name): str(value) for name, value in document["versions"].items()}


def read_counts(document: dict[str, Any]) -> dict[str, int]:
    """Return what became of a study's runs; of older files that do not tell, nothing."""
    return {str(name): int(count) for name, count in document.get("counts", {}).items()}


def whole_numbers(value: Any, shape: tuple[int, ...], where: str) -> NDArray[np.int64]:
    """Return whole numbers of a table as an array; see `kneecore.files.model.array`."""
    numbers = array(value, shape, where)
    if not np.array_equal(numbers, np.round(numbers)):
        raise FileFormatError(f"`{where}` holds something other than whole numbers")
    return numbers.astype(np.int64)
