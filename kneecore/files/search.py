"""A search's result as JSON and CSV, and back. The schema is ``assets/result.schema.json``."""

import csv
import io
from collections.abc import Iterator
from typing import Any

import numpy as np

from kneecore.errors import FileFormatError
from kneecore.figures.names import SEARCH_FILES
from kneecore.files.evidence import (
    comparison_table,
    evidence_table,
    optional,
    read_evidence,
    read_methods,
    read_repair,
    read_verdict,
    repair_table,
    verdict_table,
)
from kneecore.files.knee_pair import knee_curves, knee_part, read_knee_part
from kneecore.files.model import (
    array,
    digits_of,
    model_table,
    named,
    number_or_none,
    read_model,
    read_vector,
)
from kneecore.files.settings import read_settings, write_settings
from kneecore.knee.bounds import needs_file
from kneecore.knee.model import Knee
from kneecore.numbers import plain
from kneecore.presented import Format, rendered
from kneecore.report.command import command_line
from kneecore.report.search import WORDS
from kneecore.search.result import MODELS, SearchResult
from kneecore.search.settings import SearchSettings

SCHEMA = "kneecore.result/1"
_REPAIR = frozenset({"repair", "repair_gap_percent", "repair_models", "repair_batch"})
"""Options that the table of the repair tells."""


def to_dict(result: SearchResult) -> dict[str, Any]:
    """Return a result as JSON-ready values."""
    digits = digits_of(result.model)
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "summary": WORDS.summary(result),
        "objective_surrogate": optional(result.objective_surrogate, digits),
        "objective_model": optional(result.objective_model, digits),
        "gap_percent": optional(result.gap_percent, digits),
        "stop_reason": result.stop_reason,
        "counts": dict(result.counts),
        "parameters": [named(result.model.names, x) for x in result.x],
        "at_bounds": _at_bounds(result),
        "evidence": evidence_table(result.evidence, digits),
        "repair": repair_table(result.repair, digits, result.settings.repair_batch),
        "verdict": verdict_table(result.verdict),
        "comparison": comparison_table(result),
        "search": {
            "run_values": plain(result.run_values, digits=digits),
            "history": plain(result.history, digits=digits),
        },
        "command": command_line(result),
        "versions": dict(result.versions),
        "seconds": {k: round(v, 6) for k, v in result.seconds.items()},
        "threads": result.threads,
    }
    unset = {"max_runs"} if result.settings.max_runs is None else set()
    write_settings(result.settings, document, without=_REPAIR | unset)
    own = knee_part(result) if isinstance(result.model, Knee) else _model_part(result)
    return document | own


def _at_bounds(result: SearchResult) -> list[dict[str, str]]:
    return [
        {
            name: "upper" if side > 0 else "lower"
            for name, side in zip(result.model.names, sides, strict=True)
            if side
        }
        for sides in result.model.at_bounds(result.x)
    ]


def _model_part(result: SearchResult) -> dict[str, Any]:
    """Return what is told of a model that is no knee."""
    curves = dict(zip(MODELS, (result.y_nominal, *result.y), strict=True))
    predicted, training = result.y_surrogate, None
    if result.training_x is not None and result.training_y is not None:
        failed = ~np.isfinite(result.training_y).all(axis=1)
        training = {
            "n_samples": len(result.training_x),
            "n_failed": int(np.count_nonzero(failed)),
            "loo_rms": optional(result.loo_rms, None),
            "parameters": result.training_x.tolist(),
            "y": plain(result.training_y, digits=None),
        }
    return {
        "model": model_table(result.model),
        "y": {name: plain(y, digits=None) for name, y in curves.items()},
        "predicted_y": None
        if predicted is None
        else {name: plain(y, digits=None) for name, y in zip(MODELS[1:], predicted, strict=True)},
        "training": training,
    }


def from_dict(document: dict[str, Any]) -> SearchResult:
    """Return the result that `to_dict` has told."""
    own = _read_model_part(document) if "model" in document else read_knee_part(document)
    repair = read_repair(document.get("repair"))
    known: dict[str, Any] = {"repair": repair is not None}
    if repair is not None:
        known |= {"repair_gap_percent": repair.goal_percent, "repair_models": repair.max_models}
        known["repair_batch"] = int(document["repair"].get("batch", 4))
    search = document["search"]
    if "method" not in search and "method" not in document:  # there was one
        known["method"] = "ga"
    counted = [f"models_{name}" for name in ("simulated", *own["model"].count_names)]
    others = [key for key in document["counts"] if key not in counted]  # of a model's own kinds
    return SearchResult(
        settings=read_settings(SearchSettings, document, **known),
        objective_surrogate=number_or_none(document, "objective_surrogate"),
        objective_model=number_or_none(document, "objective_model"),
        gap_percent=number_or_none(document, "gap_percent"),
        run_values=tuple(array(search["run_values"], (-1,), "run_values").tolist()),
        history=array(search["history"], (-1,), "history"),
        stop_reason=str(document["stop_reason"]),
        counts={k: int(document["counts"][k]) for k in ("pairs_evaluated", *counted, *others)},
        seconds={k: float(v) for k, v in document["seconds"].items()},
        threads=int(document["threads"]),
        versions={k: str(v) for k, v in document["versions"].items()},
        evidence=read_evidence(document.get("evidence")),
        repair=repair,
        verdict=read_verdict(document.get("verdict")),
        methods=read_methods(document.get("comparison"), document["seconds"]),
        **own,
    )


def _read_model_part(document: dict[str, Any]) -> dict[str, Any]:
    model = read_model(document["model"])
    m, n, d = model.n_outputs, -1, len(model.inputs)
    sets, y, predicted = document["parameters"], document["y"], document["predicted_y"]
    if not isinstance(sets, list) or len(sets) != 2:
        raise FileFormatError("`parameters` must hold two models")
    training = document["training"]
    return {
        "model": model,
        "x": np.stack([read_vector(x, model.names, "parameters") for x in sets]),
        "y": array([y[name] for name in MODELS[1:]], (2, m), "y"),
        "y_nominal": array(y[MODELS[0]], (m,), "y.baseline"),
        "y_surrogate": None
        if predicted is None
        else array([predicted[name] for name in MODELS[1:]], (2, m), "predicted_y"),
        "responses": {},
        "training_x": None
        if training is None
        else array(training["parameters"], (n, d), "training.parameters"),
        "training_y": None if training is None else array(training["y"], (n, m), "training.y"),
        "loo_rms": None if training is None else number_or_none(training, "loo_rms"),
    }


def curves_csv(result: SearchResult) -> str:
    """Return the curves as CSV, one row a model and output; unknown values are empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    if isinstance(result.model, Knee):
        writer.writerows(knee_curves(result))
        return buffer.getvalue()
    writer.writerow(["model", "output", "axis", "axis_unit", "value", "unit"])
    for name, y in zip(MODELS, (result.y_nominal, *result.y), strict=True):
        for column, value in zip(result.model.columns, plain(y, digits=None), strict=True):
            output = column.output
            writer.writerow([name, output.name, column.at, output.axis_unit, value, output.unit])
    return buffer.getvalue()


def _others(result: SearchResult, figures: bool) -> Iterator[tuple[str, bytes]]:
    yield "curves.csv", curves_csv(result).encode()
    if isinstance(result.model, Knee) and needs_file(result.model.space):
        yield "knee.toml", result.model.space.to_toml().encode()
    if figures:
        yield from rendered(result)


FORMAT = Format(
    schema=SCHEMA,
    file="result.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
    stale=(*SEARCH_FILES, "curves.csv", "knee.toml"),
)
