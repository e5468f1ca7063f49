"""What runs in parallel cost and give: `python tests/benchmarks/parallel.py [--quick]`.

Prints, as the tables of ``docs/cluster.md``: what a run costs beyond its own time, by its length,
with one process of this machine and with one worker of dask.distributed (one, so that waiting for
the last of several is not counted); what a chunk costs the scheduler and the process that asks; how
many knees that process takes in; and what follows for a thousand cores. `million.py` has a million
knees through Dask with a worker killed.

Costs of the scheduler and of single steps are processor time, which other work on the machine
changes little; the costs of runs are the least of some repeats.
"""

import argparse
import time
from concurrent.futures import wait

import numpy as np
from distributed import Client, LocalCluster

from kneecore import Input, Knee, Model, Output
from kneecore.runs.chunks import PER_WORKER_S
from kneecore.runs.cluster import Cluster
from kneecore.study.monte_carlo import BATCH, _Sums


class Sleep:
    """A function of one point that takes a while, and counts as long as it really took."""

    def __init__(self, seconds):
        self.seconds = seconds

    def __call__(self, x):
        begun = time.perf_counter()
        if self.seconds:
            time.sleep(self.seconds)
        return [time.perf_counter() - begun, *x[:11]]


def model(seconds, **options):
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in range(28)]
    return Model(Sleep(seconds), inputs, [Output("y", axis=tuple(range(12)))], **options)


def cost_of_a_run(workers, seconds, n, repeats=3):
    """Return the time that each of n runs takes beyond its own, s: the least of some repeats."""
    there = model(seconds, workers=workers)
    x = np.random.default_rng(0).random((n, 28))
    there.evaluate(x[: min(n, 300)])  # starts the worker
    costs = []
    for _ in range(repeats):
        begun = time.perf_counter()
        own = there.evaluate(x)[:, 0].sum()
        costs.append((time.perf_counter() - begun - own) / n)
    there.close()
    return min(costs)


def nothing():
    return None


def cost_of_a_chunk(client, n):
    """Return the processor time of scheduler and asking process for a task, s."""
    executor = client.get_executor(pure=False)
    wait([executor.submit(nothing) for _ in range(100)])
    begun = time.process_time()
    wait([executor.submit(nothing) for _ in range(n)])
    return (time.process_time() - begun) / n


def knees(threads=1):
    knee = Knee(threads=threads)
    x = knee.from_free_unit(np.random.default_rng(0).random((2048, knee.n_free)))
    return knee, x


def run_by_one_core():
    """Return how many knees a second one core runs."""
    knee, x = knees()
    knee._examine(x, observe=True)
    begun = time.process_time()
    for _ in range(3):
        knee._examine(x, observe=True)
    return 3 * len(x) / (time.process_time() - begun)


def taken_in():
    """Return how many knees a second one core puts into the statistics."""
    knee, x = knees()
    done = knee._examine(x, observe=True)
    sums = _Sums(total=1_000_000, marks=None)
    sums.add(done)
    begun, n = time.process_time(), 20
    for _ in range(n):
        sums.add(done)
    return len(x) * n / (time.process_time() - begun)


def tell_costs(address, quick):
    print("| a run takes | one process: more, ms a run | one Dask worker: more, ms a run |")
    print("|---|---|---|")
    for seconds, n in ((0.0, 5000), (0.001, 2000), (0.01, 400), (0.1, 40), (0.5, 16)):
        # Not too few of them: there and back is some 10 ms through Dask, whatever is run.
        n = max(n // 5, 16) if quick else n
        repeats = 6 if seconds >= 0.5 else 3
        costs = [cost_of_a_run(workers, seconds, n, repeats) for workers in (1, address)]
        told = " | ".join(f"{1e3 * cost:.3f}" for cost in costs)
        print(f"| {1e3 * seconds:g} ms | {told} |", flush=True)


def tell_a_thousand(chunk_cost):
    rate = 1.0 / chunk_cost
    print("\n| a run takes | a chunk | chunks a second for 1,000 cores | cores kept busy |")
    print("|---|---|---|---|")
    for seconds in (0.0002, 0.001, 0.01, 0.1, 1.0, 60.0):
        rows = min(max(Cluster.target_s, PER_WORKER_S * 1000) / seconds, BATCH)
        chunk = max(rows, 1) * seconds
        busy = min(1000.0, rate * chunk)
        print(f"| {seconds:g} s | {chunk:.3g} s | {1000 / chunk:,.0f} | {busy:,.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer runs")
    quick = parser.parse_args().quick
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=100
    ) as cluster:
        tell_costs(cluster.scheduler_address, quick)
        with Client(cluster.scheduler_address, set_as_default=False) as client:
            cost = cost_of_a_chunk(client, 300 if quick else 2000)
    print(f"\na chunk costs scheduler and asking process together {1e3 * cost:.2f} ms")
    print(f"one core runs {run_by_one_core():,.0f} knees a second")
    print(f"one core puts {taken_in():,.0f} knees a second into the statistics")
    tell_a_thousand(cost)


if __name__ == "__main__":
    main()
