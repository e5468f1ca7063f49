"""What a session's study has found and is doing, and the files it gives away."""

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import kneecore
from kneecore import MOMENT, InfluenceResult, MonteCarloResult, SearchResult
from kneecore.files.study import Study
from kneeviz.jobs.job import StudyJob
from kneeviz.jobs.paper_files import PaperFiles
from kneeviz.views.charts.curves import Band
from kneeviz.views.tabs import study as study_tab


@dataclass
class StudyDesk:
    """What the study has found and is doing."""

    job: StudyJob | None = None
    sampled: MonteCarloResult | None = None
    held_against: SearchResult | None = None
    """The worst case whose place among the samples was counted."""
    band: Band | None = None
    """What the sampling draws behind the curves."""
    with_band: bool = True
    influence: InfluenceResult | None = None
    paper: PaperFiles | None = None
    load: int = int(np.argmax(MOMENT))
    """The load (index) that the charts of influence show."""
    chart: str = study_tab.BARS
    written: tuple[Any, ...] = ()
    """What the texts on screen were made of."""


def study_file(desk: StudyDesk, result: SearchResult | None, name: str) -> bytes | None:
    """Return the content of a download as the command line writes it, or None."""
    if name == "uncertainty.json":
        return None if desk.sampled is None else _document(desk, desk.sampled, result)
    if name.startswith("paper"):
        if desk.paper is None:
            return None
        return desk.paper.page if name == "paper.html" else desk.paper.everything
    if desk.influence is None:
        return None
    if name == "influence.csv":
        return desk.influence.to_csv().encode()
    return (json.dumps(desk.influence.to_dict(), allow_nan=False) + "\n").encode()


def _document(desk: StudyDesk, sampled: MonteCarloResult, result: SearchResult | None) -> bytes:
    """Return samples, and what belongs to the same bounds: influence and the worst case's place."""
    study = Study(sampled=sampled)
    if desk.influence is not None and _same_bounds(desk.influence, sampled):
        study.influence = desk.influence
    if result is not None and result.solver == sampled.solver and _same_bounds(result, sampled):
        if desk.held_against is not result:  # its place among the samples was not counted
            sampled = replace(sampled, below=None)
        study.worst = result
        study.comparison = kneecore.compare_with_sampling(result, sampled)
    return (json.dumps(study.to_dict(), allow_nan=False) + "\n").encode()


def _same_bounds(a: Any, b: Any) -> bool:
    return (
        np.array_equal(a.space.lower, b.space.lower)
        and np.array_equal(a.space.upper, b.space.upper)
        and a.rest_length == b.rest_length
    )
