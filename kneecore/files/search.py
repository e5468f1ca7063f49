"""A search result as JSON and CSV, and back. The schema is ``assets/result.schema.json``."""

import csv
import io
import json
import math
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from kneecore.errors import FileFormatError, KneecoreError
from kneecore.files.evidence import (
    comparison_table,
    evidence_table,
    number_or_none,
    optional,
    read_evidence,
    read_repair,
    read_rivals,
    repair_table,
)
from kneecore.knee.model import Objective
from kneecore.knee.parameters import ALL_NAMES, LIGAMENTS, N_PARAMETERS, NAMES, check_physical
from kneecore.knee.response import MOMENT, Response, RestLength, Solver, status_text
from kneecore.knee.space import ParameterSpace
from kneecore.numbers import plain
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.search.result import COUNTS, SearchResult
from kneecore.search.settings import Method, SearchSpace

SCHEMA = "kneecore.result/1"
MAX_BYTES = 50_000_000
_N_LOADS = len(MOMENT)

FloatArray = NDArray[np.float64]
_Result = TypeVar("_Result", bound=SearchResult)

# Fields of a response in display units: (key, field, factor from SI, shape behind the loads).
_RESPONSE_FIELDS = (
    ("flexion_deg", "flexion", 180.0 / math.pi, ()),
    ("tension_n", "tension", 1.0, (4,)),
    ("contact_force_n", "contact_force", 1.0, ()),
    ("indentation_mm", "indentation", 1e3, ()),
    ("ap_position_mm", "ap_position", 1e3, ()),
    ("tibia_position_mm", "tibia_position", 1e3, (2,)),
)


def _named(x: FloatArray) -> dict[str, float]:
    return dict(zip(ALL_NAMES[: len(x)], x.tolist(), strict=True))


def to_document(result: SearchResult) -> dict[str, Any]:
    """Return `result` as JSON-ready values."""
    space = result.space
    models = result.models
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "summary": result.summary(),
        "objective_surrogate": optional(result.objective_surrogate),
        "objective_model": optional(result.objective_model),
        "gap_percent": optional(result.gap_percent),
        "extension_difference_deg": optional(result.extension_difference_deg),
        "extension_difference_percent": optional(result.extension_difference_percent),
        "seed": result.seed,
        "case": result.case,
        "method": result.method,
        "solver": result.solver,
        "space": result.search_space,
        "objective": result.objective,
        "rest_length": result.rest_length,
        "stop_reason": result.stop_reason,
        "counts": dict(result.counts),
        "parameters": [_named(x) for x in result.x],
        "at_bounds": [
            {
                n: ("upper" if s > 0 else "lower")
                for n, s in zip(space.names, sides, strict=True)
                if s
            }
            for sides in space.at_bounds(result.x)
        ],
        "moment_nm": MOMENT.tolist(),
    }
    for key, field, factor, _ in _RESPONSE_FIELDS:
        document[key] = {n: plain(getattr(r, field), factor) for n, r in models.items()}
    document["settled"] = {n: r.settled.tolist() for n, r in models.items()}
    document["status"] = {n: r.status for n, r in models.items()}
    document["refinements"] = {n: r.refinements for n, r in models.items()}
    document["lost_at_nm"] = {n: plain(r.lost_at) for n, r in models.items()}
    document["ligament_rest_length_mm"] = {n: plain(r.rest_length, 1e3) for n, r in models.items()}
    document["load_free_position_mm"] = {
        n: plain(r.load_free_position, 1e3) for n, r in models.items()
    }
    document["predicted_flexion_deg"] = _predicted(result)
    document["training"] = _training(result)
    document["evidence"] = evidence_table(result.evidence)
    document["repair"] = repair_table(result.repair)
    document["comparison"] = comparison_table(result)
    document["search"] = {
        "pop_size": result.pop_size,
        "generations": result.n_generations,
        "runs": result.n_runs,
        "training_samples": result.training_samples,
        "options": {k: getattr(result.options, k) for k in GeneticOptions.__dataclass_fields__},
        "run_values": plain(result.run_values),
        "history": plain(result.history),
    }
    document["baseline"] = {
        "title": space.title,
        "note": space.note,
        "parameters": _named(space.baseline),
        "geometry_bound_mm": space.geometry_bound_mm,
        "slope_bound_deg": space.slope_bound_deg,
        "material_bound_percent": space.material_bound_percent,
        "rest_length_bound_mm": space.rest_length_bound_mm,
        "rest_length_bound_percent": space.rest_length_bound_percent,
        "centre": None if space.is_around_baseline else _named(space.centre),
        "half_ranges": dict(space.half_ranges) if space.half_ranges is not None else None,
        "sources": list(space.sources) if space.sources is not None else None,
        "lower": _named(space.lower),
        "upper": _named(space.upper),
    }
    document["command"] = result.command()
    document["versions"] = dict(result.versions)
    document["seconds"] = {k: round(v, 6) for k, v in result.seconds.items()}
    document["threads"] = result.threads
    return document


def _predicted(result: SearchResult) -> dict[str, Any] | None:
    if result.predicted_flexion is None:
        return None
    one, two = np.degrees(result.predicted_flexion)
    return {"model_1": plain(one), "model_2": plain(two)}


def _training(result: SearchResult) -> dict[str, Any] | None:
    if result.training_x is None or result.training_flexion is None:
        return None
    failed = ~np.isfinite(result.training_flexion).all(axis=1)
    return {
        "n_samples": len(result.training_x),
        "n_failed": int(np.count_nonzero(failed)),
        "loo_rms_deg": optional(result.loo_rms_deg),
        "parameters": result.training_x.tolist(),
        "flexion_deg": plain(result.training_flexion, 180.0 / math.pi),
    }


def to_text(result: SearchResult) -> str:
    """Return `result` as JSON text, ending in a newline."""
    return json.dumps(to_document(result), allow_nan=False, ensure_ascii=False) + "\n"


def curves_csv(result: SearchResult) -> str:
    """Return one row a model and load; unknown values are empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    tensions = [f"tension_{name}_n" for name in LIGAMENTS]
    writer.writerow(
        ["model", "moment_nm", "flexion_deg", *tensions, "contact_force_n", "indentation_mm"]
        + ["ap_position_mm", "settled", "status"]
    )
    for name, response in result.models.items():
        columns = [
            plain(response.flexion, 180.0 / math.pi),
            *(plain(response.tension[:, i]) for i in range(len(LIGAMENTS))),
            plain(response.contact_force),
            plain(response.indentation, 1e3),
            plain(response.ap_position, 1e3),
        ]
        for k, moment in enumerate(MOMENT.tolist()):
            settled = str(bool(response.settled[k])).lower()
            writer.writerow([name, moment, *(c[k] for c in columns), settled, response.status])
    return buffer.getvalue()


def _array(value: Any, shape: tuple[int, ...], where: str) -> FloatArray:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise FileFormatError(f"`{where}` holds something other than numbers") from None
    if len(array.shape) != len(shape) or any(
        want not in (-1, have) for want, have in zip(shape, array.shape, strict=True)
    ):
        raise FileFormatError(f"`{where}` has shape {array.shape}; {shape} is allowed")
    return array


def _response(document: dict[str, Any], name: str) -> Response:
    fields = {
        field: _array(document[key][name], (_N_LOADS, *shape), f"{key}.{name}") / factor
        for key, field, factor, shape in _RESPONSE_FIELDS
    }
    refinements = int(document["refinements"][name])
    if document["status"][name] != status_text(refinements):
        raise FileFormatError(f"`status.{name}` does not fit `refinements.{name}`")
    return Response(
        moment=MOMENT,
        settled=_array(document["settled"][name], (_N_LOADS,), f"settled.{name}").astype(bool),
        refinements=refinements,
        rest_length=_array(document["ligament_rest_length_mm"][name], (4,), "rest") / 1e3,
        load_free_position=_array(document["load_free_position_mm"][name], (2,), "position") / 1e3,
        lost_at=_lost_at(document, name),
        **fields,
    )


def _lost_at(document: dict[str, Any], name: str) -> float:
    # Results that were written before there were equilibria have none.
    lost_at = number_or_none(document["lost_at_nm"], name) if "lost_at_nm" in document else None
    return math.nan if lost_at is None else lost_at


def _vector(table: dict[str, Any], where: str) -> FloatArray:
    names = NAMES if len(table) == N_PARAMETERS else ALL_NAMES
    if set(table) != set(names):
        raise FileFormatError(f"`{where}` must name the 28 parameters")
    return _array([table[name] for name in names], (len(names),), where)


def _two_knees(sets: Any) -> FloatArray:
    if not isinstance(sets, list) or len(sets) != 2:
        raise FileFormatError("`parameters` must hold two knees")
    return check_physical([_vector(knee, "parameters") for knee in sets], "parameters")


def _choice(table: dict[str, Any], key: str, allowed: tuple[Any, ...]) -> Any:
    if table[key] not in allowed:
        raise FileFormatError(f"`{key}` is {table[key]!r}; {', '.join(allowed)} are allowed")
    return table[key]


def _space(document: dict[str, Any]) -> ParameterSpace:
    baseline = document["baseline"]
    return ParameterSpace(
        case=document["case"],
        geometry_bound_mm=baseline["geometry_bound_mm"],
        slope_bound_deg=baseline["slope_bound_deg"],
        material_bound_percent=baseline["material_bound_percent"],
        # Results that were written before rest lengths could be uncertain have none.
        rest_length_bound_mm=baseline.get("rest_length_bound_mm", 0.0),
        rest_length_bound_percent=baseline.get("rest_length_bound_percent", 0.0),
        half_ranges=baseline["half_ranges"],
        sources=None if baseline["sources"] is None else tuple(map(str, baseline["sources"])),
        baseline=_vector(baseline["parameters"], "baseline.parameters"),
        title=str(baseline["title"]),
        note=baseline["note"],
        # Results that were written before a box could be around another knee have none.
        centre=_vector(baseline.get("centre") or baseline["parameters"], "baseline.centre"),
    )


def _from_document(cls: type[_Result], document: dict[str, Any]) -> _Result:
    training, predicted = document["training"], document["predicted_flexion_deg"]
    search = document["search"]
    n = -1 if training is None else len(training["parameters"])
    return cls(
        space=_space(document),
        method=_choice(document, "method", get_args(Method)) if "method" in document else "ga",
        solver=_choice(document, "solver", get_args(Solver))
        if "solver" in document
        else "dynamics",
        evidence=read_evidence(document.get("evidence")),
        repair=read_repair(document.get("repair")),
        rivals=read_rivals(document.get("comparison")),
        search_space=_choice(document, "space", get_args(SearchSpace)),
        objective=_choice(document, "objective", get_args(Objective)),
        rest_length=_choice(document, "rest_length", get_args(RestLength)),
        x=_two_knees(document["parameters"]),
        baseline=_response(document, "baseline"),
        model_1=_response(document, "model_1"),
        model_2=_response(document, "model_2"),
        predicted_flexion=None
        if predicted is None
        else np.radians(
            _array([predicted["model_1"], predicted["model_2"]], (2, _N_LOADS), "predicted")
        ),
        objective_surrogate=number_or_none(document, "objective_surrogate"),
        objective_model=number_or_none(document, "objective_model"),
        gap_percent=number_or_none(document, "gap_percent"),
        training_x=None
        if training is None
        else _array(training["parameters"], (n, -1), "training.parameters"),
        training_flexion=None
        if training is None
        else np.radians(_array(training["flexion_deg"], (n, _N_LOADS), "training.flexion_deg")),
        loo_rms_deg=None if training is None else number_or_none(training, "loo_rms_deg"),
        run_values=tuple(_array(search["run_values"], (-1,), "run_values").tolist()),
        history=_array(search["history"], (-1,), "history"),
        pop_size=int(search["pop_size"]),
        n_generations=int(search["generations"]),
        n_runs=int(search["runs"]),
        training_samples=int(search["training_samples"]),
        options=GeneticOptions(**search["options"]),
        seed=int(document["seed"]),
        stop_reason=str(document["stop_reason"]),
        counts={k: int(document["counts"][k]) for k in COUNTS},
        seconds={k: float(v) for k, v in document["seconds"].items()},
        threads=int(document["threads"]),
        versions={k: str(v) for k, v in document["versions"].items()},
    )


def from_text(cls: type[_Result], text: str) -> _Result:
    """Return the result that `to_text` wrote.

    Raises
    ------
    FileFormatError
        If the text is no result of a known schema.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"not a JSON file: {error}") from None
    schema = document.get("schema") if isinstance(document, dict) else None
    if schema != SCHEMA:
        raise FileFormatError(f"`schema` is {schema!r}; {SCHEMA!r} is allowed")
    try:
        return _from_document(cls, document)
    except FileFormatError:
        raise
    except KneecoreError as error:
        raise FileFormatError(f"no usable result: {error}") from None
    except KeyError as error:
        raise FileFormatError(f"the key {error} is missing") from None
    except (TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise FileFormatError(f"no usable result: {error}") from None


def load(cls: type[_Result], path: str | Path) -> _Result:
    """Return the result in the file, or in the folder, at `path`.

    Raises
    ------
    FileFormatError
        If it cannot be read or is no result; the message names the file.
    """
    path = Path(path)
    if path.is_dir():
        path = path / "result.json"
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FileFormatError(f"larger than {MAX_BYTES:,} bytes")
        return from_text(cls, path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError:
        raise FileFormatError(f"{path}: not a text file in UTF-8") from None
    except FileFormatError as error:
        raise FileFormatError(f"{path}: {error}") from None
