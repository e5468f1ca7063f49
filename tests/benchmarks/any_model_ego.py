"""How near SMT's EGO comes to the worst pairs of public models, with as many runs as ours.

``python tests/benchmarks/any_model_ego.py [--seeds N] [--seconds S]`` adds to `any_model_ego.json`,
which `any_model.py` puts beside the other rivals. EGO fits its surrogate of pairs anew after each
of them, which takes it minutes: a search that needs more than S seconds of processor time is ended,
and so noted. What is in the file already is not done again.
"""

import argparse
import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
from any_model import CASES, RUNS, Case, Pairs, shortfall
from peers import imported

FILE = Path(__file__).with_suffix(".json")
N_FIRST = 25  # pairs before the first surrogate
N_STARTS = 5  # of the search for the next pair


def ego(case: Case, seed: int) -> float:
    """Return the largest f of any two runs of 75 pairs, chosen by their expected improvement."""
    pairs = Pairs(case)
    space = imported("smt.design_space").DesignSpace(np.array([[0.0, 1.0]] * 2 * case.d), seed=seed)
    start = np.random.default_rng(seed).random((N_FIRST, 2 * case.d))
    search = imported("smt.applications").EGO(
        n_iter=RUNS // 2 - N_FIRST, criterion="EI", xdoe=start, seed=seed, n_start=N_STARTS,
        surrogate=imported("smt.surrogate_models").KRG(
            design_space=space, print_global=False, n_start=1
        ),
    )  # fmt: skip
    search.optimize(fun=lambda x: pairs(x)[:, None])
    return pairs.best


def within(seconds: float, case: Case, seed: int) -> float | None:
    """Return EGO's shortfall in per cent, or None if it needs more processor time."""

    def stop(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        return round(shortfall(case, ego(case, seed)), 2)
    except TimeoutError:
        return None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=300.0)
    given = parser.parse_args()
    known = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    for seed in range(given.seeds):
        for case in sorted(CASES, key=lambda case: case.d):
            found = known.setdefault(case.name, [])
            if len(found) <= seed:
                found.append(within(given.seconds, case, seed))
                print(case.name, seed, found[-1], flush=True)
                FILE.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
