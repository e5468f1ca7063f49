"""What is told of two knees and of no other model: angles, forces, extension."""

import numpy as np
from rich.table import Table

from kneecore.knee.extension import extension_difference_deg, extension_difference_percent
from kneecore.knee.model import Knee
from kneecore.knee.parameters import LIGAMENTS
from kneecore.knee.response import LARGEST_EXTENSION, MOMENT
from kneecore.report.marks import mark
from kneecore.report.tables import number, table
from kneecore.search.result import SearchResult

__all__ = ["difference_lines", "knee_footer", "knee_summary", "knee_tables"]


def _pose(flexion_deg: float) -> str:
    if flexion_deg < 0.0:
        return f"over-extends to {flexion_deg:.1f} deg"
    return f"stops at {flexion_deg:.1f} deg of flexion"


def knee_summary(result: SearchResult) -> str:
    """Return what differs, in one sentence."""
    failed = [n for n, r in result.responses.items() if r.status == "failed"]
    if failed:
        told = f"The true model fails for {' and '.join(failed)}; no angles can be compared."
        if result.settings.search_space == "surrogate":
            told += " A search in the true model leaves such knees out (--space model)."
        return told
    one, two = (
        np.degrees(result.responses[name].flexion[LARGEST_EXTENSION])
        for name in ("model_1", "model_2")
    )
    moment = MOMENT[LARGEST_EXTENSION]
    return f"At {moment:+g} N m model 1 {_pose(one)} and model 2 {_pose(two)}."


def difference_lines(result: SearchResult) -> list[str]:
    """Return the difference in extension."""
    difference = extension_difference_deg(result.responses)
    if difference is None:
        return []
    percent = extension_difference_percent(result.responses)
    share = "" if percent is None else f", {percent:.1f} % of the baseline's range of motion"
    return [f"Difference in extension: {difference:.2f} deg{share}."]


def knee_tables(result: SearchResult) -> list[Table]:
    """Return the angles at all loads, and the forces at the largest."""
    return [_angles(result), _forces(result)]


def _angles(result: SearchResult) -> Table:
    predicted = result.y_surrogate
    columns = ["moment N m", "baseline", "model 1", "model 2", "difference"]
    if predicted is not None:
        columns += ["surrogate 1", "surrogate 2"]
    rows = table("Flexion angle, deg", *columns)
    for k in np.argsort(-MOMENT):
        angles = [np.degrees(m.flexion[k]) for m in result.responses.values()]
        marks = [mark(m, k) for m in result.responses.values()]
        row = [f"{MOMENT[k]:+g}"]
        row += [number(a) + mark for a, mark in zip(angles, marks, strict=True)]
        row.append(number(angles[2] - angles[1]))
        if predicted is not None:
            row += [number(predicted[0, k]), number(predicted[1, k])]
        rows.add_row(*row)
    return rows


def _forces(result: SearchResult) -> Table:
    columns = [name.upper() for name in LIGAMENTS]
    rows = table(
        "Forces, N, and contact position, mm", "moment N m", "model", *columns, "contact", "AP"
    )
    for k in (int(np.argmax(MOMENT)), int(np.argmin(MOMENT))):
        for name, model in result.responses.items():
            forces = [*model.tension[k], model.contact_force[k]]
            rows.add_row(
                f"{MOMENT[k]:+g}",
                name.replace("_", " "),
                *(f"{force:.0f}" for force in forces),
                f"{1e3 * model.ap_position[k]:.2f}",
            )
    return rows


def knee_footer(knee: Knee) -> str:
    """Return which baseline it was, and what a reader must know of it."""
    return f"Baseline: {knee.space.title}. {knee.space.note or ''}".rstrip()
