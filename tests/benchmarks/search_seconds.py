"""How long the 200 x 800 search in the surrogate takes over seeds.

``python tests/benchmarks/search_seconds.py [seeds]`` prints the median and the 95th percentile.
"""

import sys
import time

import cases
import numpy as np

from kneecore._threads import available_cores


def seconds(seed):
    begun = time.perf_counter()
    cases.surrogate_search(seed=seed)
    return time.perf_counter() - begun


def main(n_seeds=40):
    seconds(0)  # the kernels, and the surrogate
    ms = 1e3 * np.array([seconds(seed) for seed in range(n_seeds)])
    print(f"200 x 800 in the surrogate, {n_seeds} seeds, {available_cores()} cores:")
    print(f"median {np.median(ms):.1f} ms, p95 {np.percentile(ms, 95):.1f} ms")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
