"""What a search says about how good its result is, as JSON tables and back."""

from dataclasses import replace
from math import inf, isfinite
from typing import Any

from kneecore.errors import FileFormatError
from kneecore.files.model import digits_of, number_or_none
from kneecore.numbers import DIGITS, plain
from kneecore.report.evidence import way_found
from kneecore.search.result import (
    METHOD_NAMES,
    BoundEvidence,
    Evidence,
    MethodTrace,
    Repair,
    RepairRound,
    SampledBound,
    SearchResult,
    Verdict,
)


def optional(value: float | None, digits: int | None = DIGITS) -> float | None:
    """Return a number as files hold it, with `digits` decimals; what is not finite is not known.

    None for `digits` keeps it whole.
    """
    if value is None or not isfinite(value):
        return None
    return value if digits is None else round(value, digits)


def evidence_table(evidence: Evidence | None, digits: int | None) -> dict[str, Any] | None:
    """Return an exact search's evidence as a table."""
    if evidence is None:
        return None
    return {
        "climbs": evidence.n_climbs,
        "share_reached": plain(evidence.share_reached),
        "second_best": optional(evidence.second_best, digits),
        "objective_at_rest": optional(evidence.objective_proxy, digits),
        "objective_before_climb": optional(evidence.objective_before_climb, digits),
        "patterns": [
            {"signs": list(s), "objective": plain(f, digits=digits)} for s, f in evidence.patterns
        ],
        "models_with_gradient": evidence.n_evaluations,
        "models_lost": evidence.n_failed,
        "models_in_motion": evidence.n_models,
        "description": way_found(evidence),
        "bound": _bound_table(evidence.bound, digits),
    }


def _bound_table(bound: BoundEvidence | None, digits: int | None) -> dict[str, Any] | None:
    if bound is None:
        return None
    return {
        "inputs": bound.n_inputs,
        "one_signed_sampled": bound.n_one_signed_sampled,
        "one_signed": bound.n_one_signed,
        "models": bound.n_models,
        "models_lost": bound.n_failed,
        "vertices": bound.n_vertices,
        "vertices_objective": optional(bound.vertices_objective, digits),
        "vertices_objective_in_motion": optional(bound.vertices_in_motion, digits),
        "patterns": bound.n_patterns,
        "sampled_bounds": [
            {
                "widening_percent": one.widening_percent,
                "objective": optional(one.objective, digits),
                "patterns_looked_at": one.n_looks,
            }
            for one in bound.bounds
        ],
    }


def _read_bound(table: dict[str, Any] | None) -> BoundEvidence | None:
    if table is None:
        return None
    vertices = table["vertices"]
    return BoundEvidence(
        n_inputs=int(table["inputs"]),
        n_one_signed_sampled=int(table["one_signed_sampled"]),
        n_one_signed=int(table["one_signed"]),
        n_models=int(table["models"]),
        n_failed=int(table["models_lost"]),
        n_vertices=None if vertices is None else int(vertices),
        vertices_objective=number_or_none(table, "vertices_objective"),
        vertices_in_motion=number_or_none(table, "vertices_objective_in_motion"),
        n_patterns=int(table["patterns"]),
        bounds=tuple(
            SampledBound(
                widening_percent=float(one["widening_percent"]),
                objective=float(one["objective"]),
                n_looks=int(one["patterns_looked_at"]),
            )
            for one in table["sampled_bounds"]
        ),
    )


def read_evidence(table: dict[str, Any] | None) -> Evidence | None:
    """Return the evidence that `evidence_table` has told."""
    if table is None:
        return None
    return Evidence(
        n_climbs=int(table["climbs"]),
        share_reached=float(table["share_reached"]),
        second_best=number_or_none(table, "second_best"),
        objective_proxy=number_or_none(table, "objective_at_rest"),
        objective_before_climb=number_or_none(table, "objective_before_climb"),
        patterns=tuple(
            # No model could be evaluated for a pattern without a number.
            (
                tuple(int(s) for s in p["signs"]),
                -inf if p["objective"] is None else float(p["objective"]),
            )
            for p in table["patterns"]
        ),
        n_evaluations=int(table["models_with_gradient"]),
        n_failed=int(table["models_lost"]),
        n_models=int(table["models_in_motion"]),
        bound=_read_bound(table.get("bound")),
    )


def repair_table(repair: Repair | None, digits: int | None, batch: int) -> dict[str, Any] | None:
    """Return the history of a repair as a table."""
    if repair is None:
        return None
    checks = {"models_checked": repair.n_checked, "checks_failed": repair.n_checked_failed}
    return {
        "goal_percent": repair.goal_percent,
        "max_models": repair.max_models,
        "batch": batch,
        "models_added": repair.n_models,
        "models_failed": repair.n_failed,
        **(checks if repair.n_checked else {}),
        "reached": repair.reached,
        "rounds": [
            {
                "models_added": r.n_models,
                "objective_surrogate": optional(r.objective_surrogate, digits),
                "objective_model": optional(r.objective_model, digits),
                "gap_percent": optional(r.gap_percent, digits),
            }
            for r in repair.rounds
        ],
    }


def read_repair(table: dict[str, Any] | None) -> Repair | None:
    """Return the repair that `repair_table` has told."""
    if table is None:
        return None
    return Repair(
        goal_percent=float(table["goal_percent"]),
        max_models=int(table["max_models"]),
        n_models=int(table["models_added"]),
        n_failed=int(table["models_failed"]),
        n_checked=int(table.get("models_checked", 0)),
        n_checked_failed=int(table.get("checks_failed", 0)),
        rounds=tuple(
            RepairRound(
                n_models=int(r["models_added"]),
                objective_surrogate=float(r["objective_surrogate"]),
                objective_model=number_or_none(r, "objective_model"),
                gap_percent=number_or_none(r, "gap_percent"),
            )
            for r in table["rounds"]
        ),
    )


def verdict_table(verdict: Verdict | None) -> dict[str, Any] | None:
    """Return a verdict as a table."""
    if verdict is None:
        return None
    outlook = {"outlook": verdict.outlook} if verdict.outlook else {}
    return {"word": verdict.word, "reasons": list(verdict.reasons), **outlook}


def read_verdict(table: dict[str, Any] | None) -> Verdict | None:
    """Return the verdict that `verdict_table` has told."""
    if table is None:
        return None
    if table["word"] not in ("trusted", "doubtful", "not found"):
        raise FileFormatError("`verdict.word` must be 'trusted', 'doubtful' or 'not found'")
    return Verdict(
        word=table["word"],
        reasons=tuple(str(r) for r in table["reasons"]),
        outlook=str(table.get("outlook", "")),
    )


def comparison_table(result: SearchResult) -> dict[str, Any] | None:
    """Return what all methods find, each with its shortfall from the best of all, or None."""
    digits = digits_of(result.model)
    best = optional(result.best_of_all, digits)
    if not result.methods or best is None:
        return None
    # What is derived is derived from what the file holds: read again, it gives the same.
    traces = [
        replace(t, objective=tuple(plain(t.objective, digits=digits))) for t in result.methods
    ]
    return {
        "best": best,
        "methods": {
            trace.method: {
                "description": METHOD_NAMES[trace.method],
                "promised": optional(trace.promised, digits),
                "objective_model": trace.objective[-1] if trace.objective else None,
                "shortfall_percent": optional(trace.shortfall_percent(best)),
                "models": plain(trace.n_models),
                "best_by_then": list(trace.objective),
            }
            for trace in traces
        },
    }


def read_methods(table: dict[str, Any] | None, seconds: dict[str, Any]) -> tuple[MethodTrace, ...]:
    """Return what `comparison_table` has told of the methods."""
    if table is None:
        return ()
    for name in table["methods"]:
        if name not in METHOD_NAMES:
            raise FileFormatError(
                f"`comparison` names the method {name!r}; {', '.join(METHOD_NAMES)} are allowed"
            )
    return tuple(
        MethodTrace(
            method=name,
            promised=number_or_none(method, "promised"),
            n_models=tuple(float(n) for n in method["models"]),
            objective=tuple(float(f) for f in method["best_by_then"]),
            seconds=float(seconds[f"compare_{name}"]),
        )
        for name, method in table["methods"].items()
    )
