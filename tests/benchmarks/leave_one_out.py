"""What leave-one-out errors cost: `python tests/benchmarks/leave_one_out.py [RUNS] [INPUTS]`."""

import resource
import sys
import time

import numpy as np

from kneecore.numerics.kriging import Kriging, likely
from kneecore.numerics.surrogate import Surrogate


def told(name, call):
    begun = time.perf_counter()
    call()
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{name}: {time.perf_counter() - begun:.1f} s, {most:.0f} MB at most")


if __name__ == "__main__":
    n, d = (int(a) for a in [*sys.argv[1:], *("1000", "200")[len(sys.argv) - 1 :]])
    x = np.random.default_rng(0).random((n, d))
    y = np.sin(3.0 * x[:, :3]).sum(axis=1, keepdims=True)
    print(f"{n} runs at {d} inputs")
    told("spline", lambda: Surrogate.fit(x, y).loo_errors)
    told("process", lambda: Kriging(x, y[:, 0], likely(x, y[:, 0])).loo_errors)
