"""Sobol' indices as JSON and CSV, and back."""

import csv
import io
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError
from kneecore.files.model import array
from kneecore.files.origin import (
    numbers_of,
    origin_table,
    read_counts,
    read_origin,
    read_seconds,
    read_versions,
    rounded,
)
from kneecore.files.settings import read_settings, write_settings
from kneecore.knee.model import Knee
from kneecore.knee.response import MOMENT
from kneecore.numerics.sensitivity import Indices
from kneecore.presented import Format, rendered
from kneecore.report.influence import answer
from kneecore.study.influence import InfluenceResult
from kneecore.study.settings import InfluenceSettings

__all__ = ["FORMAT", "INFLUENCE_FILE", "from_dict", "to_csv", "to_dict"]

FloatArray = NDArray[np.float64]
SCHEMA = "kneecore.influence/1"
INFLUENCE_FILE = "influence.csv"
_ORDERS = ("first_order", "total_order")


def to_dict(found: InfluenceResult) -> dict[str, Any]:
    """Return the indices as JSON-ready values."""
    used = found.indices
    knee = isinstance(found.model, Knee)
    told = numbers_of(found.model)
    intervals = {}
    for name in _ORDERS:
        both = getattr(used, f"{name}_interval")
        intervals[name] = None if both is None else {"lower": told(both[0]), "upper": told(both[1])}
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "answer": answer(found),
        **({"moment_nm": MOMENT.tolist()} if knee else {}),
        "parameters": list(found.names),
        "first_order": told(used.first_order),
        "total_order": told(used.total_order),
        "interval_95": intervals,
        "groups_first_order": {name: told(v) for name, v in found.groups.items()},
        "constant": used.constant.tolist(),
        "n_base": used.n_base,
        "n_evaluations": used.n_evaluations,
        "n_failed_rows": used.n_failed_rows,
        **({} if used.n_used is None else {"n_used": used.n_used.tolist()}),
        "counts": dict(found.counts),
        **origin_table(found.model),
        "versions": dict(found.versions),
        "seconds": rounded(found.seconds),
        "threads": found.threads,
    }
    write_settings(found.settings, document, without=frozenset())
    return document


def _indices(document: dict[str, Any], shape: tuple[int, int]) -> Indices:
    read: dict[str, Any] = {name: array(document[name], shape, name) for name in _ORDERS}
    for name in _ORDERS:
        both = document["interval_95"][name]
        read[f"{name}_interval"] = (
            None
            if both is None
            else array([both["lower"], both["upper"]], (2, *shape), "interval_95")
        )
    n_used = document.get("n_used")
    return Indices(
        constant=array(document["constant"], shape[:1], "constant").astype(bool),
        n_base=int(document["n_base"]),
        n_evaluations=int(document["n_evaluations"]),
        n_failed_rows=int(document["n_failed_rows"]),
        n_used=None if n_used is None else array(n_used, shape[:1], "n_used").astype(np.int64),
        **read,
    )


def from_dict(document: dict[str, Any]) -> InfluenceResult:
    """Return the indices that `to_dict` has told."""
    model = read_origin(document)
    names = tuple(str(name) for name in document["parameters"])
    if names != model.free_names:
        raise FileFormatError("`parameters` are not the free inputs of the model")
    return InfluenceResult(
        model=model,
        settings=read_settings(InfluenceSettings, document),
        names=names,
        groups={
            str(name): array(sums, (model.n_outputs,), "groups_first_order")
            for name, sums in document["groups_first_order"].items()
        },
        indices=_indices(document, (model.n_outputs, len(names))),
        counts=read_counts(document),
        seconds=read_seconds(document),
        threads=int(document["threads"]),
        versions=read_versions(document),
    )


def to_csv(found: InfluenceResult) -> str:
    """Return the indices as CSV, one line for each output and input; unknown ones are empty."""
    knee, used = isinstance(found.model, Knee), found.indices
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(
        [
            "moment_nm" if knee else "output",
            "parameter",
            *("first_order", "first_lower", "first_upper"),
            *("total_order", "total_lower", "total_upper"),
        ]
    )
    unknown = np.full((2, *used.first_order.shape), np.nan)
    first = unknown if used.first_order_interval is None else used.first_order_interval
    total = unknown if used.total_order_interval is None else used.total_order_interval
    for k, column in enumerate(found.model.columns):
        for j, name in enumerate(found.names):
            row = (
                used.first_order[k, j],
                *first[:, k, j],
                used.total_order[k, j],
                *total[:, k, j],
            )
            cells = ["" if np.isnan(v) else f"{v:.6g}" for v in row]
            writer.writerow([f"{MOMENT[k]:g}" if knee else column.label, name, *cells])
    return buffer.getvalue()


def _others(found: InfluenceResult, figures: bool) -> Iterator[tuple[str, bytes]]:
    yield INFLUENCE_FILE, to_csv(found).encode()
    if figures:
        yield from rendered(found)


FORMAT = Format(
    schema=SCHEMA,
    file="influence.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
