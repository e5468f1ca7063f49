"""One small result of every kind that is read from files, and what can be altered in it."""

import copy
import json
from functools import cache
from unittest import mock

import study_models

import kneecore
from kneecore import (
    AccuracyAllocationSettings,
    BoundSweepSettings,
    InfluenceSettings,
    Knee,
    NeededAccuracySettings,
    SamplingSettings,
    SearchSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
)
from kneecore.files.bound_study import BoundStudy
from kneecore.files.folder import to_json
from kneecore.files.response import to_dict as response_to_dict
from kneecore.files.study import Study
from kneecore.paper import redo
from kneecore.paper.experiments import Budget
from kneecore.study.comparison import compare_with_sampling

TINY = Budget(
    pop_size=20,
    n_generations=5,
    n_repeats=2,
    validation_size=10,
    n_validation=1,
    n_samples=50,
    n_base=16,
    n_drawn=20,
)


def _of(model, names):
    search = kneecore.worst_case(model, SearchSettings(pop_size=20, n_generations=5))
    sampled = kneecore.monte_carlo(model, SamplingSettings(n_samples=40), marks=search.y)
    return {
        "search": search,
        "samples": sampled,
        "comparison": compare_with_sampling(search, sampled),
        "influence": kneecore.influence(model, InfluenceSettings(n_base=16)),
        "landscape": kneecore.landscape(model, names, n_points=3),
        "sweep": kneecore.bound_sweep(model, BoundSweepSettings(sizes=(1.0,))),
        "training": kneecore.training_sweep(model, TrainingSweepSettings(sizes=(40,), n_seeds=2)),
        "quality": kneecore.surrogate_quality(model, SurrogateQualitySettings(n_test=20)),
    }


def _studies(made):
    """Return the documents that hold several results, as the command lines write them."""
    sampled, compared, influence = (made[k] for k in ("samples", "comparison", "influence"))
    return {
        "study": Study(sampled=sampled, comparison=compared, influence=influence).to_dict(),
        "bound study": BoundStudy(sweep=made["sweep"], need=made["need"]).to_dict(),
    }


def _paper():
    with mock.patch.object(redo, "QUICK_BUDGET", TINY):
        return redo.redo_paper(Knee(), quick=True)


@cache
def texts():
    """Return the JSON of one result of every kind, by what it is."""
    knee = Knee(solver="equilibrium")
    made = _of(knee, ("acl_femur_x", "acl_femur_y"))
    made["need"] = kneecore.needed_accuracy(knee, NeededAccuracySettings(tolerance=1.0))
    repaired = SearchSettings(method="exact", repair=True, repair_models=6)
    made["repair"] = kneecore.worst_case(knee, repaired)
    made["exact"] = kneecore.worst_case(knee, SearchSettings(method="exact"))
    made["in motion"] = kneecore.worst_case(Knee(), SearchSettings(method="exact"))
    moved = Knee(kneecore.ParameterSpace(case="material"))
    made["bound"] = kneecore.worst_case(moved, SearchSettings(method="exact", bound=True))
    rough = AccuracyAllocationSettings(tolerance=0.2, costs={"acl_femur": 2.0})
    made["allocation"] = kneecore.accuracy_allocation(knee, rough)
    goal = AccuracyAllocationSettings(within=180.0)
    others = _of(study_models.Filter(), ("L", "C"))
    others["allocation"] = kneecore.accuracy_allocation(study_models.Levers(), goal)
    told = {f"knee {kind}": result.to_json() for kind, result in made.items()}
    told |= {f"knee {kind}": to_json(document) for kind, document in _studies(made).items()}
    told |= {f"model {kind}": result.to_json() for kind, result in others.items()}
    told["response"] = to_json(response_to_dict(kneecore.simulate(knee.space.baseline)))
    told["paper"] = _paper().to_json()
    return told


_MANY = 20


def _standing_for_all(table):
    """Return the entries of a table; of one with a number for each of a knee's inputs, two."""
    entries = list(table.items())
    alike = len(entries) > _MANY and all(isinstance(v, float) for v in table.values())
    return [entries[0], entries[-1]] if alike else entries


def numbers_of(value, path=()):
    """Yield the place of one number for each table's key, lists' last entries standing for all."""
    if isinstance(value, dict):
        for key, one in _standing_for_all(value):
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
