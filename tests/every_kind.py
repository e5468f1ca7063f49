"""One small result of every kind that is read from files, and what can be altered in it."""

import copy
import json
from functools import cache

import study_models

import kneecore
from kneecore import (
    BoundSweepSettings,
    InfluenceSettings,
    Knee,
    NeededAccuracySettings,
    SamplingSettings,
    SearchSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
)
from kneecore.files.folder import to_json
from kneecore.files.response import to_dict as response_to_dict
from kneecore.paper.redo import redo_paper
from kneecore.study.comparison import compare_with_sampling


def _of(model, names, prefix):
    search = kneecore.worst_case(model, SearchSettings(pop_size=20, n_generations=5))
    sampled = kneecore.monte_carlo(model, SamplingSettings(n_samples=40), marks=search.y)
    made = {
        "search": search,
        "samples": sampled,
        "comparison": compare_with_sampling(search, sampled),
        "influence": kneecore.influence(model, InfluenceSettings(n_base=16)),
        "landscape": kneecore.landscape(model, names, n_points=3),
        "sweep": kneecore.bound_sweep(model, BoundSweepSettings(sizes=(0.5, 1.0))),
        "training": kneecore.training_sweep(
            model, TrainingSweepSettings(sizes=(40, 50), n_seeds=1)
        ),
        "quality": kneecore.surrogate_quality(model, SurrogateQualitySettings(n_test=20)),
    }
    return {f"{prefix} {kind}": result.to_json() for kind, result in made.items()}


@cache
def texts():
    """Return the JSON of one result of every kind, by what it is."""
    knee = Knee(solver="equilibrium")
    made = _of(knee, ("acl_femur_x", "acl_femur_y"), "knee")
    made |= _of(study_models.Filter(), ("L", "C"), "model")
    wide = NeededAccuracySettings(tolerance=0.2)
    made["knee need"] = kneecore.needed_accuracy(knee, wide).to_json()
    repaired = SearchSettings(method="exact", repair=True)
    made["knee repair"] = kneecore.worst_case(knee, repaired).to_json()
    exact = SearchSettings(method="exact")
    made["knee exact"] = kneecore.worst_case(knee, exact).to_json()
    made["response"] = to_json(response_to_dict(kneecore.simulate(knee.space.baseline)))
    made["paper"] = redo_paper(Knee(), quick=True).to_json()
    return made


def numbers_of(value, path=()):
    """Yield the place of one number for each table's key, lists' last entries standing for all."""
    if isinstance(value, dict):
        for key, one in value.items():
            yield from numbers_of(one, (*path, key))
    elif isinstance(value, list):
        if value:
            yield from numbers_of(value[-1], (*path, len(value) - 1))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def altered(document, path, value):
    """Return a copy of a document with another value at `path`."""
    document = table = copy.copy(document)
    for key in path[:-1]:
        table[key] = copy.copy(table[key])
        table = table[key]
    table[path[-1]] = value
    return document


def without_digest(text):
    """Return a result's document as somebody without a digest would write it."""
    document = json.loads(text)
    document.pop("digest")
    return document
