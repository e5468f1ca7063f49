"""The exact search beside long genetic algorithms in the true model, and its time::

    python tests/benchmarks/exact_quality.py         # 10 seeds of the genetic algorithm, 3 minutes
    python tests/benchmarks/exact_quality.py 2

Each line: the best f that 200 x 800 pairs find over the seeds, the least f of the exact search over
40 seeds, and the median and the 95th percentile of its time, all 28 parameters free.
"""

import sys
import time
from typing import get_args

import numpy as np

from kneecore import Knee, SearchSettings, worst_case
from kneecore.knee.response import Solver
from kneecore.search.exact_model import exact_pair
from kneecore.search.sign_climb import ExactSettings

EXACT_SEEDS = range(40)
SAME = 1e-4
"""Of f: what counts as reached."""


def measured(solver, seeds):
    """Return a table's line, and whether every exact search reached the best genetic one."""
    knee = Knee(solver=solver)
    genetic = max(
        worst_case(knee, SearchSettings(search_space="model", seed=s)).objective_model
        for s in seeds
    )
    exact_pair(knee)  # loads the kernels
    found, took = [], []
    for seed in EXACT_SEEDS:
        begun = time.perf_counter()
        found.append(exact_pair(knee, settings=ExactSettings(seed=seed)).objective)
        took.append(1e3 * (time.perf_counter() - begun))
    middle, slow = np.percentile(took, [50, 95])
    line = f"| {solver} | {genetic:.3f} | {min(found):.3f} | {middle:.0f} | {slow:.0f} |"
    return line, min(found) >= genetic * (1.0 - SAME)


def main():
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
    columns = ("response", "genetic, best f", "exact, least f", "median ms", "p95 ms")
    print(f"| {' | '.join(columns)} |\n{'|---' * len(columns)}|", flush=True)
    all_met = True
    for solver in get_args(Solver):
        line, met = measured(solver, seeds)
        all_met &= met
        print(line, flush=True)
    print(f"{len(seeds)} genetic and {len(EXACT_SEEDS)} exact seeds; reached by all:", all_met)


if __name__ == "__main__":
    main()
