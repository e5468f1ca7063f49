"""How near to the true worst pair of public models a search comes, and what it says of itself.

``python tests/benchmarks/any_model.py [FILE.md] [--seeds N] [--first-seed K] [--rivals] [--ego N]``
prints a table, and writes it between the marks of FILE.md, such as ``docs/any_model.md``.

Each search may run a model 150 times, ours with the nominal inputs and the checks of its pair. The
rivals search pairs, as one would use them: a pair costs two runs; their answer is the most
different pair of all their runs. A miss is a shortfall above 5 %; it is silent if the verdict is
"trusted".
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import differential_evolution

sys.path.insert(0, str(Path(__file__).parents[1]))

from public_models import CASES, Case

from kneecore import worst_case
from kneecore.search.inside import best_places
from kneecore.search.settings import SearchSettings

TRUTH = json.loads((Path(__file__).parent / "any_model_truth.json").read_text(encoding="utf-8"))
RUNS = 150
MISS = 5.0  # per cent


class Pairs:
    """f of pairs (n, 2 d), negative; keeps all runs within those allowed."""

    def __init__(self, case: Case) -> None:
        self._case, self._y = case, np.empty((0, case.n_outputs))

    def __call__(self, pairs: np.ndarray) -> np.ndarray:
        y = self._case.unit(pairs.reshape(-1, self._case.d))
        self._y = np.vstack([self._y, y])[:RUNS]
        y = y.reshape(len(pairs), 2, -1)
        return -np.abs(y[:, 0] - y[:, 1]).sum(axis=1)

    @property
    def best(self) -> float:
        """The largest f of any two runs, whether they were tried as a pair or not."""
        return best_places(self._y, np.ones(self._case.n_outputs))[2]


def scipy_de(case: Case, seed: int) -> float:
    pairs, size = Pairs(case), 15
    start = np.random.default_rng(seed).random((size, 2 * case.d))
    differential_evolution(
        lambda u: pairs(u.T), [(0, 1)] * 2 * case.d, rng=seed, init=start, maxiter=4, tol=0,
        polish=False, vectorized=True, updating="deferred",
    )  # fmt: skip
    return pairs.best


def pymoo_ga(case: Case, seed: int) -> float:
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    pairs = Pairs(case)

    class Farthest(Problem):
        def _evaluate(self, x, out, *_, **__):
            out["F"] = pairs(x)[:, None]

    problem = Farthest(n_var=2 * case.d, n_obj=1, xl=0.0, xu=1.0)
    minimize(problem, GA(pop_size=15), ("n_gen", 5), seed=seed)
    return pairs.best


def smt_ego(case: Case, seed: int) -> float:
    from smt.applications import EGO
    from smt.design_space import DesignSpace
    from smt.surrogate_models import KRG

    pairs, n_first = Pairs(case), 25
    space = DesignSpace(np.array([[0.0, 1.0]] * 2 * case.d), seed=seed)
    start = np.random.default_rng(seed).random((n_first, 2 * case.d))
    ego = EGO(n_iter=RUNS // 2 - n_first, criterion="EI", xdoe=start, seed=seed, n_start=5,
              surrogate=KRG(design_space=space, print_global=False, n_start=1))  # fmt: skip
    ego.optimize(fun=lambda x: pairs(x)[:, None])
    return pairs.best


Rival = Callable[[Case, int], float]
RIVALS: dict[str, Rival] = {"SciPy DE": scipy_de, "pymoo GA": pymoo_ga}
BEGIN, END = "<!-- any model: begin -->", "<!-- any model: end -->"


def shortfall(case: Case, f: float) -> float:
    return 100.0 * (1.0 - f / TRUTH[case.name])


def ours(case: Case, seed: int) -> tuple[float, int, str]:
    found = worst_case(case.model(), SearchSettings(max_runs=RUNS, seed=seed))
    runs = found.counts["models_simulated"]
    assert runs <= RUNS
    assert found.verdict is not None
    return shortfall(case, found.objective_model or 0.0), runs, found.verdict.word


def table(seeds: Sequence[int], rivals: dict[str, tuple[Rival, int]]) -> str:
    names = [f"{name}, median" for name in rivals]
    head = ["model", "inputs / outputs", "median", "largest", "runs", "doubtful", *names]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    every = []
    for case in CASES:
        mine = [ours(case, seed) for seed in seeds]
        every += mine
        short = [m[0] for m in mine]
        row = [case.name, f"{case.d} / {case.n_outputs}", f"{np.median(short):.2f}",
               f"{max(short):.2f}", f"{np.mean([m[1] for m in mine]):.0f}",
               f"{sum(m[2] != 'trusted' for m in mine)} of {len(mine)}"]  # fmt: skip
        for search, n in rivals.values():
            theirs = [shortfall(case, search(case, seed)) for seed in seeds[:n]]
            row.append(f"{np.median(theirs):.1f}")
        lines.append(f"| {' | '.join(row)} |")
        print(lines[-1], flush=True)
    return "\n".join([*lines, "", summary(every)]) + "\n"


def summary(every: Sequence[tuple[float, int, str]]) -> str:
    short = np.array([m[0] for m in every])
    trusted = np.array([m[2] == "trusted" for m in every])
    missed = short > MISS
    return (
        f"All {len(every)} searches: median shortfall {np.median(short):.3f} %, 95th percentile "
        f"{np.percentile(short, 95):.2f} %, largest {short.max():.1f} %. Misses above {MISS:g} %: "
        f"{missed.sum()}, silent {np.sum(missed & trusted)}. Right answers called doubtful: "
        f"{np.sum(~missed & ~trusted)} of {np.sum(~missed)}."
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--rivals", action="store_true")
    parser.add_argument("--ego", type=int, default=0, help="seeds of SMT's EGO: minutes each")
    given = parser.parse_args()
    rivals = {name: (rival, given.seeds) for name, rival in RIVALS.items() if given.rivals}
    if given.ego:
        rivals[f"SMT EGO ({given.ego} seeds)"] = smt_ego, given.ego
    begun = time.perf_counter()
    text = table(range(given.first_seed, given.first_seed + given.seeds), rivals)
    text += f"\nShortfalls in per cent of the true f; {time.perf_counter() - begun:.0f} s.\n"
    print(text)
    if given.file:
        before, rest = given.file.read_text(encoding="utf-8").split(BEGIN)
        after = rest.split(END)[1]
        given.file.write_text(f"{before}{BEGIN}\n{text}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
