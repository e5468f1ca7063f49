"""Worst cases over bounds of several sizes as JSON, and back."""

from collections.abc import Iterator
from typing import Any

from kneecore.files.model import array
from kneecore.files.origin import (
    column_of,
    origin_table,
    read_origin,
    read_versions,
    whole_numbers,
)
from kneecore.knee.model import Knee
from kneecore.knee.readings import deficit_deg, over_extension_deg
from kneecore.numbers import exact, plain
from kneecore.presented import Format, rendered
from kneecore.study.best_search import searches_in_model
from kneecore.study.bound_sweep import BoundSweep
from kneecore.study.settings import BoundSweepSettings

__all__ = ["FORMAT", "from_dict", "knee_bounds", "to_dict"]

SCHEMA = "kneecore.bound_sweep/1"


def knee_bounds(knee: Knee) -> dict[str, Any]:
    """Return what changes with the geometry's bound, and what does not."""
    space = knee.space
    return {
        "slope_bound_deg_per_mm": space.slope_bound_deg / space.geometry_bound_mm,
        "material_bound_percent": space.material_bound_percent,
    }


def _knee_part(sweep: BoundSweep, knee: Knee) -> dict[str, Any]:
    return {
        "bound_mm": sweep.size.tolist(),
        "objective_model": plain(sweep.objective),
        "extension_deficit_deg": plain(deficit_deg(sweep.pair)),
        "over_extension_deg": plain(over_extension_deg(sweep.pair)),
        "pair_angle_deg": plain(sweep.pair),
        "least_angle_deg": plain(sweep.extremes[:, 0]),
        "largest_angle_deg": plain(sweep.extremes[:, 1]),
        **knee_bounds(knee),
    }


def _model_part(sweep: BoundSweep) -> dict[str, Any]:
    return {
        "size": sweep.size.tolist(),
        "objective_model": exact(sweep.objective),
        "column": sweep.column,
        "pair": exact(sweep.pair),
        "extremes": exact(sweep.extremes),
        "in_model": sweep.in_model,
    }


def to_dict(sweep: BoundSweep) -> dict[str, Any]:
    """Return a sweep as JSON-ready values."""
    model = sweep.model
    own = _knee_part(sweep, model) if isinstance(model, Knee) else _model_part(sweep)
    return {
        "schema": SCHEMA,
        **own,
        "marks": {name: counts.tolist() for name, counts in sweep.marks.items()},
        "seconds": [round(s, 6) for s in sweep.seconds.tolist()],
        "seed": sweep.settings.seed,
        **origin_table(model),
        "versions": dict(sweep.versions),
    }


def from_dict(document: dict[str, Any]) -> BoundSweep:
    """Return the sweep that `to_dict` has told."""
    model = read_origin(document)
    knee = isinstance(model, Knee)
    size = array(document["bound_mm" if knee else "size"], (-1,), "size")
    n = len(size)
    if knee:
        angles = [document["least_angle_deg"], document["largest_angle_deg"]]
        extremes = array(angles, (2, n), "least_angle_deg").T
    else:
        extremes = array(document["extremes"], (n, 2), "extremes")
    return BoundSweep(
        model=model,
        settings=BoundSweepSettings(sizes=tuple(size.tolist()), seed=document["seed"]),
        column=column_of(document, model),
        size=size,
        objective=array(document["objective_model"], (n,), "objective_model"),
        pair=array(document["pair_angle_deg" if knee else "pair"], (n, 2), "pair"),
        extremes=extremes,
        in_model=searches_in_model(model) if knee else bool(document["in_model"]),
        marks={
            str(name): whole_numbers(counts, (n,), f"marks.{name}")
            for name, counts in document.get("marks", {}).items()
        },
        seconds=array(document["seconds"], (n,), "seconds"),
        versions=read_versions(document),
    )


def _others(sweep: BoundSweep, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(sweep)


FORMAT = Format(
    schema=SCHEMA,
    file="bound_sweep.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
