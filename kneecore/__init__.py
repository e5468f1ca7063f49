"""kneecore: a 2D dynamic knee and the search for its two most different selves.

The public names; each is loaded when it is first used, so that ``import kneecore`` and ``--help``
stay fast.

Examples
--------
>>> import kneecore
>>> result = kneecore.worst_case(kneecore.ParameterSpace(), seed=1)
>>> bool(result.objective_model > 100)  # deg, summed over the 12 loads
True
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:  # the same names for type checkers, which cannot follow __getattr__
    from kneecore.errors import FileFormatError as FileFormatError
    from kneecore.errors import KneecoreError as KneecoreError
    from kneecore.errors import ModelError as ModelError
    from kneecore.errors import OutputError as OutputError
    from kneecore.errors import ParameterError as ParameterError
    from kneecore.knee.file import Knee as Knee
    from kneecore.knee.file import dump_knee as dump_knee
    from kneecore.knee.file import packaged_knee as packaged_knee
    from kneecore.knee.file import parameter_table as parameter_table
    from kneecore.knee.file import read_knee as read_knee
    from kneecore.knee.gradient import flexion_gradient as flexion_gradient
    from kneecore.knee.model import KneeSurrogate as KneeSurrogate
    from kneecore.knee.model import fit_surrogate as fit_surrogate
    from kneecore.knee.parameters import LIGAMENTS as LIGAMENTS
    from kneecore.knee.parameters import NAMES as NAMES
    from kneecore.knee.parameters import Parameter as Parameter
    from kneecore.knee.response import MOMENT as MOMENT
    from kneecore.knee.response import Response as Response
    from kneecore.knee.response import ResponseBatch as ResponseBatch
    from kneecore.knee.response import simulate as simulate
    from kneecore.knee.response import simulate_batch as simulate_batch
    from kneecore.knee.space import ParameterSpace as ParameterSpace
    from kneecore.knee.trajectory import Trajectory as Trajectory
    from kneecore.knee.trajectory import trajectory as trajectory
    from kneecore.numerics.genetic_options import GeneticOptions as GeneticOptions
    from kneecore.paper.redo import PaperReport as PaperReport
    from kneecore.paper.redo import redo_paper as redo_paper
    from kneecore.progress import Cancelled as Cancelled
    from kneecore.progress import Progress as Progress
    from kneecore.search.result import PairResult as PairResult
    from kneecore.search.result import SearchResult as SearchResult
    from kneecore.search.warm_up import warm_up as warm_up
    from kneecore.search.worst_case import worst_case as worst_case
    from kneecore.study.bound_sweep import BoundSweep as BoundSweep
    from kneecore.study.bound_sweep import bound_sweep as bound_sweep
    from kneecore.study.comparison import Comparison as Comparison
    from kneecore.study.comparison import compare_with_sampling as compare_with_sampling
    from kneecore.study.influence import InfluenceResult as InfluenceResult
    from kneecore.study.influence import influence as influence
    from kneecore.study.influence import worst_case_slopes as worst_case_slopes
    from kneecore.study.landscape import Landscape as Landscape
    from kneecore.study.landscape import landscape as landscape
    from kneecore.study.monte_carlo import MonteCarloResult as MonteCarloResult
    from kneecore.study.monte_carlo import monte_carlo as monte_carlo
    from kneecore.study.needed_accuracy import NeededAccuracy as NeededAccuracy
    from kneecore.study.needed_accuracy import needed_accuracy as needed_accuracy
    from kneecore.study.training_sweep import TrainingSweep as TrainingSweep
    from kneecore.study.training_sweep import training_sweep as training_sweep

_HOME = {
    "FileFormatError": "errors",
    "KneecoreError": "errors",
    "ModelError": "errors",
    "OutputError": "errors",
    "ParameterError": "errors",
    "Knee": "knee.file",
    "dump_knee": "knee.file",
    "packaged_knee": "knee.file",
    "parameter_table": "knee.file",
    "read_knee": "knee.file",
    "flexion_gradient": "knee.gradient",
    "MOMENT": "knee.response",
    "Response": "knee.response",
    "ResponseBatch": "knee.response",
    "simulate": "knee.response",
    "simulate_batch": "knee.response",
    "Trajectory": "knee.trajectory",
    "trajectory": "knee.trajectory",
    "GeneticOptions": "numerics.genetic_options",
    "LIGAMENTS": "knee.parameters",
    "NAMES": "knee.parameters",
    "Parameter": "knee.parameters",
    "KneeSurrogate": "knee.model",
    "fit_surrogate": "knee.model",
    "Cancelled": "progress",
    "Progress": "progress",
    "PairResult": "search.result",
    "SearchResult": "search.result",
    "warm_up": "search.warm_up",
    "worst_case": "search.worst_case",
    "ParameterSpace": "knee.space",
    "BoundSweep": "study.bound_sweep",
    "NeededAccuracy": "study.needed_accuracy",
    "bound_sweep": "study.bound_sweep",
    "needed_accuracy": "study.needed_accuracy",
    "Comparison": "study.comparison",
    "compare_with_sampling": "study.comparison",
    "InfluenceResult": "study.influence",
    "influence": "study.influence",
    "worst_case_slopes": "study.influence",
    "Landscape": "study.landscape",
    "landscape": "study.landscape",
    "MonteCarloResult": "study.monte_carlo",
    "monte_carlo": "study.monte_carlo",
    "PaperReport": "paper.redo",
    "redo_paper": "paper.redo",
    "TrainingSweep": "study.training_sweep",
    "training_sweep": "study.training_sweep",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'kneecore' has no attribute {name!r}")
    value = getattr(import_module(f"kneecore.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
