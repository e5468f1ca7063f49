"""Surrogates by the runs they learned from as JSON, and back; rows are sizes, columns seeds."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from kneecore.files.model import array
from kneecore.files.origin import (
    numbers_of,
    origin_table,
    read_counts,
    read_origin,
    read_versions,
    whole_numbers,
)
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.presented import Format, rendered
from kneecore.study.settings import TrainingSweepSettings
from kneecore.study.training_sweep import TrainingSweep

__all__ = ["FORMAT", "from_dict", "to_dict"]

SCHEMA = "kneecore.training_sweep/1"


def _keys(model: Model) -> dict[str, str]:
    """Return the keys of the table's fields: a knee's have their units."""
    knee = isinstance(model, Knee)
    return {
        "objective_surrogate": "objective_surrogate",
        "objective_model": "objective_model",
        "gap_percent": "gap_percent",
        "rank_f": "rank_correlation_pairs",
        "rank_outputs": f"rank_correlation_worst_{'angle' if knee else 'output'}",
        "rms_error": "rms_error_deg" if knee else "rms_error",
    }


def to_dict(sweep: TrainingSweep) -> dict[str, Any]:
    """Return a sweep as JSON-ready values."""
    settings, told = sweep.settings, numbers_of(sweep.model)
    return {
        "schema": SCHEMA,
        "training_samples": list(settings.sizes),
        "seeds": list(range(settings.seed, settings.seed + settings.n_seeds)),
        "n_failed": sweep.n_failed.tolist(),
        **{key: told(getattr(sweep, name)) for name, key in _keys(sweep.model).items()},
        "seconds": np.round(sweep.seconds, 6).tolist(),
        "n_test": sweep.n_test,
        "counts": dict(sweep.counts),
        "method": settings.method,
        **origin_table(sweep.model),
        "versions": dict(sweep.versions),
    }


def from_dict(document: dict[str, Any]) -> TrainingSweep:
    """Return the sweep that `to_dict` has told."""
    model = read_origin(document)
    seeds = [int(seed) for seed in document["seeds"]]
    settings = TrainingSweepSettings(
        sizes=document["training_samples"],
        n_seeds=len(seeds),
        method=document["method"],
        seed=min(seeds),
    )
    shape = (len(settings.sizes), settings.n_seeds)
    return TrainingSweep(
        model=model,
        settings=settings,
        n_failed=whole_numbers(document["n_failed"], shape, "n_failed"),
        seconds=array(document["seconds"], shape, "seconds"),
        n_test=int(document["n_test"]),
        counts=read_counts(document),
        versions=read_versions(document),
        **{name: array(document[key], shape, key) for name, key in _keys(model).items()},
    )


def _others(sweep: TrainingSweep, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(sweep)


FORMAT = Format(
    schema=SCHEMA,
    file="training_sweep.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
