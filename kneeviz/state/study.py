"""What the study has found and is doing: sampling, influence, accuracy, the paper redone."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from kneecore import (
    MOMENT,
    AccuracyAllocation,
    InfluenceResult,
    MonteCarloResult,
    SearchResult,
)
from kneeviz.jobs.job import Job
from kneeviz.jobs.paper_files import PaperFiles
from kneeviz.state.shown import Band

BARS, HEAT_MAP, SLOPES = "Bars", "Heat map", "At the worst case"
"""The charts of influence, as their buttons name them."""


@dataclass
class StudyState:
    """What the study has found and is doing."""

    job: Job | None = None
    sampled: MonteCarloResult | None = None
    held_against: SearchResult | None = None
    """The worst case whose place among the samples was counted."""
    band: Band | None = None
    """What the sampling draws behind the curves."""
    with_band: bool = True
    influence: InfluenceResult | None = None
    accuracy: AccuracyAllocation | None = None
    paper: PaperFiles | None = None
    load: int = int(np.argmax(MOMENT))
    """The load (index) that the charts of influence show."""
    chart: str = BARS
    written: tuple[Any, ...] = ()
    """What the texts on screen were made of."""
