"""A million knees through Dask, a worker killed: `python tests/benchmarks/million.py [N]`.

The same study is then made without a cluster; the two must be the same to the last bit. It prints
how much came back, what was given out again, the seconds and the memory; it ends with 1 where
anything was lost or doubled.
"""

import argparse
import hashlib
import os
import resource
import signal
import sys
import time

from distributed import LocalCluster
from distributed.diagnostics.plugin import SchedulerPlugin

import kneecore
from kneecore import Knee, SamplingSettings
from kneecore._threads import available_cores


class Given(SchedulerPlugin):
    """Counts the chunks that a scheduler gives to workers, and those that it gives again."""

    def __init__(self):
        self.chunks, self.n = set(), 0

    def transition(self, key, start, finish, *args, **kwargs):
        if finish == "processing":
            self.chunks.add(key)
            self.n += 1

    @property
    def n_again(self):
        return self.n - len(self.chunks)


def digest(study):
    """Return what stands for all numbers of a study: its statistics, its counts, its samples."""
    sha = hashlib.sha256(repr((study.n_samples, sorted(study.counts.items()))).encode())
    for name, spread in [("y", study.y), *sorted(study.observed.items())]:
        for part, values in sorted(vars(spread).items()):
            sha.update(f"{name} {part}".encode() + values.tobytes())
    return sha.hexdigest()


def sampled(knee, n, callback=None):
    """Return a study and the seconds that it took."""
    begun = time.perf_counter()
    study = kneecore.monte_carlo(knee, SamplingSettings(n_samples=n), callback=callback)
    return study, time.perf_counter() - begun


def through_dask(n):
    """Return a study, its seconds and what was given out; one of two workers is killed."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=100
    ) as cluster:
        given, killed = Given(), []
        cluster.scheduler.add_plugin(given)

        def callback(report):
            if not killed and report.done > n // 3:
                killed.append(report.done)
                os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

        knee = Knee(workers=cluster.scheduler_address)
        study, took = sampled(knee, n, callback)
        knee.close()
    print(f"a worker was killed after {killed[0]:,} of {n:,} knees")
    return study, took, given


def peak_mb(who):
    return resource.getrusage(who).ru_maxrss / 1024  # Linux tells KiB


def tell(name, study, took):
    counts = ", ".join(f"{count:,} {kind}" for kind, count in study.counts.items())
    print(f"{name}: {study.n_samples:,} samples ({counts}) in {took:.0f} s, {digest(study)[:16]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("n", type=int, nargs="?", default=1_000_000, help="how many knees")
    n = parser.parse_args().n
    there, took, given = through_dask(n)
    asking, worker = peak_mb(resource.RUSAGE_SELF), peak_mb(resource.RUSAGE_CHILDREN)
    tell("through Dask on 2 workers", there, took)
    print(f"{len(given.chunks):,} chunks, {given.n_again} of them given out again")
    print(f"most memory: {asking:.0f} MB with the scheduler, {worker:.0f} MB a worker", flush=True)
    here, took = sampled(Knee(), n)
    tell(f"here on {available_cores()} threads", here, took)
    same = digest(there) == digest(here)
    print("the same to the last bit" if same else "DIFFERENT")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
