"""How good the exact search in motion is where bounds are wide: f and time over seeds.

``python tests/benchmarks/wide_bounds.py`` prints a table: bounds of 1, 2 and 3 mm with 10, 20 and
30 per cent, ten seeds each, the plain and the thorough form. The share is of the best f known. On a
machine that others use, processor seconds over the number of cores tell more than the clock.
"""

import sys
import time

import numpy as np

from kneecore import Knee, ParameterSpace, SearchSettings, worst_case

BEST_KNOWN = {1.0: 395.001, 2.0: 732.224, 3.0: 951.77}
"""deg, in motion, all loads; from searches of minutes."""
COLUMNS = (
    "bounds",
    "form",
    "least f, deg",
    "median f",
    "of the best known",
    "median s",
    "most s",
    "processor s",
)


def found(mm, seed, *, thorough):
    """Return (f, seconds, processor seconds) of one search."""
    space = ParameterSpace(
        geometry_bound_mm=mm, slope_bound_deg=mm, material_bound_percent=10.0 * mm
    )
    begun, worked = time.perf_counter(), time.process_time()
    result = worst_case(Knee(space), SearchSettings(method="exact", seed=seed, thorough=thorough))
    return result.objective_model, time.perf_counter() - begun, time.process_time() - worked


def main(n_seeds=10):
    found(3.0, 0, thorough=False)  # the kernels
    print(f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|")
    for mm, best in BEST_KNOWN.items():
        for thorough in (False, True):
            runs = [found(mm, seed, thorough=thorough) for seed in range(n_seeds)]
            f, seconds, worked = np.array(runs).T
            form = "thorough" if thorough else "plain"
            times = f"{np.median(seconds):.2f} | {seconds.max():.2f} | {np.median(worked):.2f}"
            share = f"{100 * f.min() / best:.2f} to {100 * f.max() / best:.2f} %"
            print(
                f"| {mm:g} mm, {10 * mm:g} % | {form} | {f.min():.3f} | {np.median(f):.3f} | "
                f"{share} | {times} |",
                flush=True,
            )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
