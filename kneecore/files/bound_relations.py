"""What must agree in the evidence that slopes give for a worst case."""

import numpy as np

from kneecore.files.consistent import ROUNDING, check_equal, check_holds
from kneecore.search.half_bound import MAX_ENUMERATED
from kneecore.search.result import SearchResult

__all__ = ["check_bound"]


def check_bound(result: SearchResult) -> None:
    """Raise a `FileFormatError` if what slopes have shown contradicts itself."""
    if result.evidence is None or result.evidence.bound is None:
        return
    evidence, bound = result.evidence, result.evidence.bound
    where, settings, model = "evidence.bound", result.settings, result.model
    check_holds(where, settings.bound, "it is there only if it was asked for")
    check_equal(f"{where}.inputs", bound.n_inputs, model.n_free)
    rising = (0, bound.n_one_signed, bound.n_one_signed_sampled, bound.n_inputs)
    check_holds(f"{where}.one_signed", np.diff(rising) >= 0, "at most the sampled, and the inputs")
    check_holds(f"{where}.models_lost", bound.n_failed <= bound.n_models, "at most the models")
    left = bound.n_inputs - bound.n_one_signed
    follows = None if left > MAX_ENUMERATED else 2 ** (left + 1)
    check_equal(f"{where}.vertices", bound.n_vertices, follows)
    for f in (bound.vertices_objective, bound.vertices_in_motion):
        check_holds(f"{where}.vertices_objective", follows or f is None, "none without vertices")
    n_counting = np.count_nonzero(model.weights(settings.objective, settings.weights))
    check_equal(f"{where}.patterns", bound.n_patterns, 2.0 ** (n_counting - 1))
    where = f"{where}.sampled_bounds"
    steps = np.diff([-1.0, *(one.widening_percent for one in bound.bounds)])
    check_holds(where, steps > 0.0, "`widening_percent` rises from 0")
    known = max(evidence.objective_proxy or 0.0, bound.vertices_objective or 0.0)
    values = [known, *(one.objective for one in bound.bounds)]
    check_holds(where, np.diff(values) >= -ROUNDING, "none falls, or is below what was found")
    check_holds(where, not (bound.bounds and bound.n_failed), "none where models fail")
    looks = [one.n_looks <= bound.n_patterns for one in bound.bounds]
    check_holds(where, looks, "at most all patterns are looked at")
