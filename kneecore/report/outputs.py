"""A model's outputs in tables: a knee's by load, with decimals; any other's by name."""

import numpy as np
from numpy.typing import NDArray

from kneecore.knee.model import Knee
from kneecore.knee.response import MOMENT
from kneecore.model import Model
from kneecore.report.knee_pair import knee_footer
from kneecore.report.tables import number, significant, with_unit

__all__ = [
    "NO_PROOF",
    "drawn_line",
    "failure_lines",
    "heading",
    "label",
    "origin",
    "quantile_line",
    "shown",
    "solver",
    "spread",
]

FloatArray = NDArray[np.float64]

NO_PROOF = "Exact searches: the worst found from many starts, which is no proof of the worst."


MOST_FAILURES = 3
"""Failed runs that a report tells one by one."""


def failure_lines(model: Model) -> list[str]:
    """Return why runs of a model failed, where that is known."""
    failures = model.failures
    lines = [f"Failed: {failure}." for failure in failures[:MOST_FAILURES]]
    if len(failures) > MOST_FAILURES:
        lines.append(f"All {len(failures):,} are in `model.failures`.")
    return lines


def heading(model: Model) -> str:
    """Return what stands above the outputs' names."""
    return "moment N m" if isinstance(model, Knee) else "output"


def label(model: Model, column: int) -> str:
    """Return what an output is called in a table, with its unit."""
    if isinstance(model, Knee):
        return f"{MOMENT[column]:+g}"
    one = model.columns[column]
    return with_unit(f"{one.title},", one.output.unit).rstrip(",")


def shown(model: Model, value: float, digits: int = 2) -> str:
    """Return a value of an output: a knee's with decimals, any other's with six digits."""
    return number(value, digits) if isinstance(model, Knee) else significant(value)


def solver(model: Model) -> str:
    """Return which response of knees it was."""
    return f", solver: {model.solver}" if isinstance(model, Knee) else ""


def origin(model: Model) -> str:
    """Return which model it was, and what a reader must know of it."""
    return knee_footer(model) if isinstance(model, Knee) else f"Model: {model.name}."


def drawn_line(model: Model) -> list[str]:
    """Return how samples are drawn, where it is not uniformly within the bounds."""
    return [f"Inputs: {model.drawn_as}."] if model.drawn_as else []


def quantile_line(model: Model) -> list[str]:
    """Return what a search's bounds are, where they are not the stated ones."""
    free = (one for one, free in zip(model.inputs, model.free, strict=True) if free)
    shares = sorted({one.quantile for one in free if one.quantile is not None})
    if not shares:
        return []
    told = " or ".join(f"{100.0 * share:g}" for share in shares)
    return [f"Bounds: the central {told} % of each distribution ({model.drawn_as})."]


def spread(model: Model, values: FloatArray, digits: int) -> str:
    """Return median and range of f over seeds."""
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return "failed"
    told = [shown(model, v, digits) for v in (known.min(), float(np.median(known)), known.max())]
    return told[1] if len(values) == 1 else f"{told[1]} ({told[0]} to {told[2]})"
