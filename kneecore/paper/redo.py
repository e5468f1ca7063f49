"""The paper redone: run its computations again for a knee, and judge it claim by claim.

Examples
--------
>>> import kneecore
>>> report = kneecore.redo_paper(quick=True)
>>> report.by_outcome("agrees")[0].claim.statement
'The baseline settles at every load'
"""

import time
from typing import Any

from kneecore._arguments import callback_or_none, flag, shown
from kneecore._threads import thread_count
from kneecore.errors import ParameterError
from kneecore.knee.model import Knee
from kneecore.numerics.sampling_options import check_seed
from kneecore.paper.claims import packaged_paper
from kneecore.paper.experiments import PAPER_BUDGET, QUICK_BUDGET, run_experiments
from kneecore.paper.machine import machine_name
from kneecore.paper.result import PaperReport
from kneecore.paper.verdict import judge_all
from kneecore.progress import Callback

__all__ = ["redo_paper"]


def _checked(knee: Any) -> Knee:
    """Return a knee that is computed as the paper computes its own; the packaged one for None."""
    if not isinstance(knee, Knee | None):
        raise ParameterError(
            f"`knee` is {shown(knee)}; a kneecore.Knee is allowed, such as kneecore.Knee(space)"
        )
    checked: Knee = Knee() if knee is None else knee
    for name, paper in (("solver", "dynamics"), ("rest_length", "recomputed")):
        value = getattr(checked, name)
        if value != paper:
            raise ParameterError(
                f"`knee` has the {name} {value!r}; {paper!r} is allowed, as in the paper"
            )
    return checked


def redo_paper(
    knee: Knee | None = None,
    *,
    quick: bool = False,
    seed: int = 0,
    callback: Callback | None = None,
) -> PaperReport:
    """Compute the whole paper again for a knee, and judge it claim by claim.

    Parameters
    ----------
    knee : Knee, optional
        The packaged baseline with its default bounds for None; its case does not count, all three
        are computed.
    quick : bool
        Smaller searches and fewer samples: seconds, and a preview only.
    seed : int
        The same seed gives the same verdicts, those on times apart.
    callback : callable, optional
        Gets `Progress`, with a sentence for the stage; a true result cancels.

    Raises
    ------
    ParameterError
        If an argument is not allowed.
    ModelError
        If too many models failed to say anything.
    Cancelled
        If the callback cancelled.
    """
    knee = _checked(knee)
    quick = flag("quick", quick)
    callback_or_none(callback)
    seed = check_seed(seed)
    paper = packaged_paper()
    started = time.perf_counter()
    budget = QUICK_BUDGET if quick else PAPER_BUDGET
    done = run_experiments(knee, budget, seed=seed, callback=callback)
    return PaperReport(
        paper=paper,
        verdicts=judge_all(paper.claims, done),
        quick=quick,
        seed=seed,
        title=knee.space.title,
        note=knee.space.note,
        n_failed={
            "searches": sum(run.counts["models_failed"] for run in done.searches),
            "sampling": done.sampling.n_failed,
        },
        machine=machine_name(thread_count(knee.threads)),
        seconds=time.perf_counter() - started,
        versions=dict(done.main.versions),
        experiments=done,
    )
