"""A Monte-Carlo study as JSON and back: of knees by quantity and unit, of other models as `y`."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from kneecore.files.model import array, named
from kneecore.files.origin import (
    numbers_of,
    origin_table,
    read_origin,
    read_seconds,
    read_versions,
    rounded,
)
from kneecore.files.settings import read_settings, write_settings
from kneecore.knee.model import Knee
from kneecore.knee.response import MOMENT, QUANTITIES
from kneecore.model import Model
from kneecore.presented import Format, rendered
from kneecore.study.monte_carlo import MonteCarloResult, Spread
from kneecore.study.settings import SamplingSettings

__all__ = ["FORMAT", "MARKS", "STUDY_FILE", "from_dict", "to_dict"]

Told = Callable[[Any], Any]
SCHEMA = "kneecore.monte_carlo/1"
STUDY_FILE = "uncertainty.json"
MARKS = "share_of_samples_below"
USED = "samples_used_by_output"
_BOUNDS = ("sigma", "percentile")


def _bounds(spread: Spread, told: Told) -> dict[str, Any]:
    return {
        kind: {side: told(getattr(spread, f"{kind}_{side}")) for side in ("lower", "upper")}
        for kind in _BOUNDS
    }


def _spread_table(spread: Spread, told: Told) -> dict[str, Any]:
    return {
        "mean": told(spread.mean),
        "sd": told(spread.sd),
        "bounds_997": _bounds(spread, told),
    }


def _read_spread(mean: Any, sd: Any, bounds: Any, where: str, n_outputs: int) -> Spread:
    """Return a quantity's spread; its arrays all have the shape of the mean, (m, ...)."""
    shape = np.shape(mean)
    wanted = (n_outputs, *shape[1:])
    sides = {
        f"{kind}_{side}": array(bounds[kind][side], wanted, where)
        for kind in _BOUNDS
        for side in ("lower", "upper")
    }
    return Spread(mean=array(mean, wanted, where), sd=array(sd, wanted, where), **sides)


def _knee_part(study: MonteCarloResult) -> dict[str, Any]:
    y, model = study.y, study.model
    told = numbers_of(model)
    return {
        "moment_nm": MOMENT.tolist(),
        "mean_deg": told(y.mean),
        "sd_deg": told(y.sd),
        "bounds_997_deg": _bounds(y, told),
        **{name: _spread_table(study.observed[name], told) for name, _, _ in QUANTITIES},
        "lower": named(model.names, model.lower),
        "upper": named(model.names, model.upper),
    }


def to_dict(study: MonteCarloResult) -> dict[str, Any]:
    """Return a study as JSON-ready values, units in the keys."""
    told = numbers_of(study.model)
    own = (
        _knee_part(study)
        if isinstance(study.model, Knee)
        else {
            "y": _spread_table(study.y, told),
            "observed": {name: _spread_table(s, told) for name, s in study.observed.items()},
        }
    )
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "n_samples": study.n_samples,
        **{f"n_{name}": count for name, count in study.counts.items()},
        **({} if study.n_used is None else {USED: study.n_used.tolist()}),
        **own,
        MARKS: told(study.below),
        **origin_table(study.model),
        "stop_reason": study.stop_reason,
        "versions": dict(study.versions),
        "seconds": rounded(study.seconds),
        "threads": study.threads,
    }
    write_settings(study.settings, document, without=frozenset())
    return document


def _read_own(document: dict[str, Any], model: Model) -> tuple[Spread, dict[str, Spread]]:
    m = model.n_outputs
    if isinstance(model, Knee):
        y = _read_spread(
            document["mean_deg"], document["sd_deg"], document["bounds_997_deg"], "mean_deg", m
        )
        tables = {name: document[name] for name, _, _ in QUANTITIES}
    else:
        table, tables = document["y"], document["observed"]
        y = _read_spread(table["mean"], table["sd"], table["bounds_997"], "y", m)
    observed = {
        name: _read_spread(
            table["mean"], table["sd"], table["bounds_997"], name, len(table["mean"])
        )
        for name, table in tables.items()
    }
    return y, observed


def _read_counts(document: dict[str, Any]) -> dict[str, int]:
    counts = {"failed": int(document["n_failed"])}
    for key, value in document.items():
        if key.startswith("n_") and key != "n_samples":
            counts[key.removeprefix("n_")] = int(value)
    return counts


def from_dict(document: dict[str, Any]) -> MonteCarloResult:
    """Return the study that `to_dict` has told."""
    model = read_origin(document)
    y, observed = _read_own(document, model)
    below = document[MARKS]
    return MonteCarloResult(
        model=model,
        settings=read_settings(SamplingSettings, document),
        y=y,
        observed=observed,
        n_samples=int(document["n_samples"]),
        counts=_read_counts(document),
        below=None if below is None else array(below, (-1, model.n_outputs), MARKS),
        stop_reason=str(document["stop_reason"]),
        seconds=read_seconds(document),
        threads=int(document["threads"]),
        versions=read_versions(document),
        n_used=_read_used(document.get(USED), model.n_outputs),
    )


def _read_used(told: Any, n_outputs: int) -> Any:
    return None if told is None else array(told, (n_outputs,), USED).astype(np.int64)


def _others(study: MonteCarloResult, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(study)


FORMAT = Format(
    schema=SCHEMA,
    file=STUDY_FILE,
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
