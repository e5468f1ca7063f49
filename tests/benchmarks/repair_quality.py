"""How well a repaired surrogate does, over cases, responses, methods and seeds::

    python tests/benchmarks/repair_quality.py        # 20 seeds
    python tests/benchmarks/repair_quality.py 5

Each line: the true f of the plain surrogate's optimum and of the repaired one's, in per cent of the
exact search's in the true model (the worst seed, and the mean), the largest gap at the repaired
surrogate's optimum, and the models that it took.
"""

import sys
from dataclasses import replace
from typing import get_args

import numpy as np

from kneecore import Knee, ParameterSpace, SearchSettings, worst_case
from kneecore.knee.response import Solver
from kneecore.knee.space import CASES
from kneecore.search.exact_model import exact_pair
from kneecore.search.settings import Method


def measured(case, solver, method, seeds):
    """Return a table's line, and whether the aim was met: gap under 1 %, f at least 99 %."""
    knee = Knee(ParameterSpace(case=case), solver=solver)
    exact = exact_pair(knee).objective
    settings = [SearchSettings(search_space="surrogate", method=method, seed=s) for s in seeds]
    plain = [worst_case(knee, s).objective_model / exact for s in settings]
    found = [worst_case(knee, replace(s, repair=True)) for s in settings]
    shares = np.array([r.objective_model / exact for r in found])
    gaps = [abs(r.repair.rounds[-1].gap_percent) for r in found]
    models = [r.repair.n_models for r in found]
    met = shares.min() >= 0.99 and max(gaps) < 1.0 and max(models) <= 40
    return (
        f"| {case} | {solver} | {method} | {100 * min(plain):.2f} | {100 * shares.min():.2f} | "
        f"{100 * shares.mean():.2f} | {max(gaps):.2f} | {min(models)} to {max(models)} |"
    ), met


def main():
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
    columns = ("case", "response", "method", "plain, worst %", "repaired, worst %", "mean %")
    columns += ("largest gap %", "models")
    print(f"| {' | '.join(columns)} |\n{'|---' * len(columns)}|", flush=True)
    all_met = True
    for case in CASES:
        for solver in get_args(Solver):
            for method in get_args(Method):
                line, met = measured(case, solver, method, seeds)
                all_met &= met
                print(line, flush=True)
    print(f"{len(seeds)} seeds; gap under 1 %, f at least 99 %, at most 40 models:", all_met)


if __name__ == "__main__":
    main()
