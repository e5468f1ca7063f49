"""How near to the true worst pair of public models a search comes, and what it says of itself.

``python tests/benchmarks/any_model.py [FILE.md] [--seeds N] [--fresh K] [--keep FILE] [--rivals]``
prints a table, and writes it between the marks of FILE.md, such as ``docs/any_model.md``.
``--fresh`` adds what comes out for N seeds from K on, which no limit was chosen on; ``--keep FILE``
keeps what was searched, so that it can be ended and go on. SMT's EGO takes minutes a search:
`any_model_ego.py` keeps what it found, and the table shows it.

Each search may run a model 150 times, ours with the nominal inputs and the checks of its pair. The
rivals search pairs, as one would use them: a pair costs two runs; their answer is the most
different pair of all their runs. A miss is a shortfall above 5 %; it is silent if the verdict is
"trusted".
"""

import argparse
import json
import sys
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
_EGO_FILE = Path(__file__).with_name("any_model_ego.json")
EGO = json.loads(_EGO_FILE.read_text(encoding="utf-8")) if _EGO_FILE.exists() else {}
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


Found = tuple[float, int, str]
"""Shortfall in per cent, runs, the verdict's word."""
Rival = Callable[[Case, int], float]
RIVALS: dict[str, Rival] = {"SciPy DE": scipy_de, "pymoo GA": pymoo_ga}
BEGIN, END = "<!-- any model: begin -->", "<!-- any model: end -->"


def shortfall(case: Case, f: float) -> float:
    return 100.0 * (1.0 - f / TRUTH[case.name])


def ours(case: Case, seed: int) -> Found:
    found = worst_case(case.model(), SearchSettings(max_runs=RUNS, seed=seed))
    runs = found.counts["models_simulated"]
    assert runs <= RUNS
    assert found.verdict is not None
    return shortfall(case, found.objective_model or 0.0), runs, found.verdict.word


class Kept:
    """Searches that were done already, a line of JSON each: a benchmark that takes long goes on."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        lines = file.read_text(encoding="utf-8").splitlines() if file and file.exists() else []
        rows = [json.loads(line) for line in lines]
        self._known = {(name, seed): (short, runs, word) for name, seed, short, runs, word in rows}

    def __call__(self, case: Case, seed: int) -> Found:
        key = case.name, seed
        if key not in self._known:
            self._known[key] = ours(case, seed)
            if self._file:
                with self._file.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([*key, *self._known[key]]) + "\n")
        return self._known[key]


def told_ego(case: Case) -> list[str]:
    """Return the cell of SMT's EGO: its median; a dash where it needed too long; or nothing yet."""
    if not EGO:
        return []
    found = EGO.get(case.name, [])
    if None in found:
        return ["-"]
    return [f"{np.median(found):.1f}" if found else ""]


def table(search: Kept, seeds: Sequence[int], rivals: dict[str, Rival]) -> tuple[str, list[Found]]:
    names = [f"{name}, median" for name in rivals] + ["SMT EGO"] * bool(EGO)
    head = ["model", "inputs / outputs", "median", "largest", "runs", "doubtful", *names]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    every = []
    for case in CASES:
        mine = [search(case, seed) for seed in seeds]
        every += mine
        short = [m[0] for m in mine]
        row = [case.name, f"{case.d} / {case.n_outputs}", f"{np.median(short):.2f}",
               f"{max(short):.2f}", f"{np.mean([m[1] for m in mine]):.0f}",
               f"{sum(m[2] != 'trusted' for m in mine)} of {len(mine)}"]  # fmt: skip
        for rival in rivals.values():
            theirs = [shortfall(case, rival(case, seed)) for seed in seeds]
            row += [f"{np.median(theirs):.1f}"]
        row += told_ego(case)
        lines.append(f"| {' | '.join(row)} |")
        print(lines[-1], flush=True)
    return "\n".join(lines), every


def summary(every: Sequence[Found], seeds: Sequence[int]) -> str:
    short = np.array([m[0] for m in every])
    trusted = np.array([m[2] == "trusted" for m in every])
    missed = short > MISS
    return (
        f"Seeds {seeds[0]} to {seeds[-1]}, {len(every)} searches: median shortfall "
        f"{np.median(short):.3f} %, 95th percentile {np.percentile(short, 95):.2f} %, largest "
        f"{short.max():.1f} %. Misses above {MISS:g} %: {missed.sum()}, silent "
        f"{np.sum(missed & trusted)}. Right answers called doubtful: {np.sum(~missed & ~trusted)} "
        f"of {np.sum(~missed)}."
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--fresh", type=int, default=0)
    parser.add_argument("--rivals", action="store_true")
    parser.add_argument("--keep", type=Path, help="go on from the searches in this file")
    given = parser.parse_args()
    search = Kept(given.keep)
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    lines, every = table(search, seeds, RIVALS if given.rivals else {})
    text = f"{lines}\n\nShortfalls in per cent of the true f. {summary(every, seeds)}\n"
    if given.fresh:
        fresh = range(given.fresh, given.fresh + given.seeds)
        found = [search(case, seed) for case in CASES for seed in fresh]
        text += f"\nOn which no limit was chosen: {summary(found, fresh)}\n"
    print(text)
    if given.file:
        before, rest = given.file.read_text(encoding="utf-8").split(BEGIN)
        after = rest.split(END)[1]
        given.file.write_text(f"{before}{BEGIN}\n{text}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
