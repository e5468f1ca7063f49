"""Searches of knees in one line: which options are the knee's, and which the search's."""

import numpy as np

from kneecore import Knee, SearchSettings, worst_case

KNEE = ("solver", "rest_length", "threads")


def knee_of(space=None, options=None):
    """Return the knees of a space; takes the knee's options out of `options`."""
    options = {} if options is None else options
    return Knee(space, **{name: options.pop(name) for name in KNEE if name in options})


def searched(space=None, *, callback=None, **options):
    """Search a space of knees; options are the knee's (solver ...) and the search's (seed ...)."""
    knee = knee_of(space, options)
    return worst_case(knee, SearchSettings(**options), callback=callback)


def f_of(one, two, weights=1.0):
    """Return f of two knees' responses, deg."""
    return float((np.abs(np.degrees(one.flexion - two.flexion)) * weights).sum())


def sum_of(result):
    """Return f of a result's responses, deg: all loads count."""
    return f_of(result.responses["model_1"], result.responses["model_2"])


def same_bytes(*results):
    """Tell whether results agree in every byte but times and threads."""
    documents = [result.to_dict() for result in results]
    for document in documents:
        del document["seconds"], document["threads"]
    return all(document == documents[0] for document in documents[1:])
