"""The state of a model's page as a file, from which a server that starts again goes on."""

from pathlib import Path
from typing import Any

import numpy as np

from kneecore import FileFormatError, Model
from kneecore.files.folder import to_json
from kneecore.files.model import array
from kneeviz.anymodel.snapshot import FloatArray, ModelSnapshot
from kneeviz.anymodel.state import of_this_model
from kneeviz.state.document import (
    check_keys,
    flag,
    read_result,
    read_settings,
    read_state,
    told,
)

SCHEMA = "kneeviz.model-state/1"
_KEYS = {"schema", "inputs", "settings", "overlay", "band", "output", "result"}


def to_text(state: ModelSnapshot, model: Model) -> str:
    """Return a state as JSON: the same state, the same text."""
    return to_json(
        {
            "schema": SCHEMA,
            "inputs": dict(zip(model.names, state.x.tolist(), strict=True)),
            "settings": dict(state.settings),
            "overlay": state.overlay,
            "band": state.band,
            "output": state.column,
            "result": None if state.result is None else told(state.result),
        }
    )


def read(path: str | Path, model: Model) -> ModelSnapshot:
    """Return the state in the file at `path`, of a model's page.

    Raises
    ------
    FileFormatError
        If it cannot be read, is of another version or another model; the message names the file.
    """
    return read_state(path, lambda document: _from_document(document, model))


def _from_document(document: dict[str, Any], model: Model) -> ModelSnapshot:
    check_keys(document, SCHEMA, _KEYS)
    return ModelSnapshot(
        x=_inputs(document["inputs"], model),
        result=read_result(document["result"], lambda result: of_this_model(model, result)),
        overlay=flag(document, "overlay"),
        band=flag(document, "band"),
        column=_output(document["output"], model),
        settings=read_settings(document["settings"]),
    )


def _inputs(table: Any, model: Model) -> FloatArray:
    if not isinstance(table, dict) or tuple(table) != model.names:
        raise FileFormatError(f"`inputs` must name those of the model {model.name[:60]!r}")
    values = list(table.values())
    if any(type(v) not in (int, float) for v in values):
        raise FileFormatError("`inputs` must be numbers")
    x = array(values, (len(values),), "inputs")
    outside = np.flatnonzero((x < model.lower) | (x > model.upper))
    if len(outside):
        raise FileFormatError(f"`inputs.{model.names[outside[0]][:60]}` is beyond its bounds")
    model.check_allowed(x)
    return x


def _output(value: Any, model: Model) -> int:
    if type(value) is not int or not 0 <= value < model.n_outputs:
        raise FileFormatError(
            f"`output` is {str(value)[:40]!r}; 0 to {model.n_outputs - 1} is allowed"
        )
    return value
