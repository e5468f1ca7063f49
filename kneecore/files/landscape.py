"""A slice of a model as JSON and CSV, and back; inputs as the model gets them, knees' in SI."""

import csv
import io
from collections.abc import Iterator
from typing import Any

import numpy as np

from kneecore.errors import FileFormatError
from kneecore.files.model import array
from kneecore.files.origin import (
    numbers_of,
    origin_table,
    read_counts,
    read_origin,
    read_versions,
)
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.presented import Format, rendered
from kneecore.study.landscape import Landscape

__all__ = ["FORMAT", "from_dict", "to_csv", "to_dict"]

SCHEMA = "kneecore.landscape/1"


def _keys(model: Model) -> tuple[str, str]:
    """Return the keys of the outputs by the model and by the surrogate."""
    if isinstance(model, Knee):
        return "flexion_deg", "predicted_flexion_deg"
    return "y", "predicted_y"


def to_dict(found: Landscape) -> dict[str, Any]:
    """Return a slice as JSON-ready values."""
    key, predicted = _keys(found.model)
    told = numbers_of(found.model)
    return {
        "schema": SCHEMA,
        "names": list(found.names),
        "axes": [axis.tolist() for axis in found.axes],
        "x": found.x.tolist(),
        key: told(found.y),
        predicted: told(found.y_surrogate),
        "counts": dict(found.counts),
        **origin_table(found.model),
        "versions": dict(found.versions),
    }


def from_dict(document: dict[str, Any]) -> Landscape:
    """Return the slice that `to_dict` has told."""
    model = read_origin(document)
    key, predicted = _keys(model)
    first, second = (str(name) for name in document["names"])
    if not {first, second} <= set(model.free_names) or first == second:
        raise FileFormatError("`names` are not two different free inputs of the model")
    one, two = (array(axis, (-1,), "axes") for axis in document["axes"])
    shape = (len(one), len(two), model.n_outputs)
    other = document[predicted]
    return Landscape(
        model=model,
        names=(first, second),
        x=array(document["x"], (-1,), "x"),
        axes=(one, two),
        y=array(document[key], shape, key),
        y_surrogate=None if other is None else array(other, shape, predicted),
        counts=read_counts(document),
        versions=read_versions(document),
    )


def to_csv(found: Landscape) -> str:
    """Return a slice as CSV, one line a grid point; what is not known is empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    columns = [f"{c.label}, {c.output.unit}".rstrip(", ") for c in found.model.columns]
    sheets = [found.y]
    if found.y_surrogate is not None:
        sheets.append(found.y_surrogate)
    told = ["", "surrogate: "][: len(sheets)]
    writer.writerow([*found.names, *(before + name for before in told for name in columns)])
    for i, one in enumerate(found.axes[0]):
        for j, two in enumerate(found.axes[1]):
            values = np.concatenate([sheet[i, j] for sheet in sheets])
            writer.writerow([repr(float(one)), repr(float(two)), *numbers_of(found.model)(values)])
    return buffer.getvalue()


def _others(found: Landscape, figures: bool) -> Iterator[tuple[str, bytes]]:
    yield "landscape.csv", to_csv(found).encode()
    if figures:
        yield from rendered(found)


FORMAT = Format(
    schema=SCHEMA,
    file="landscape.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
