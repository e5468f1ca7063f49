"""How often the marks `at_rest` and `implausible` stand, what they cost, and the baseline's::

    python tests/benchmarks/marks.py                 # 4,000 knees within the bounds, 28,000 wide
    python tests/benchmarks/marks.py --knees 400 --wide 2800

Knees are uniform in the bounds, in both rest-length modes where that is said. The first lines are
about the default bounds: which share of the settled loads is more than 0.1 deg from the knee's
equilibrium, and the largest distance. The last is ten times the bounds: which of the knees that
count as good have a pose that no knee takes.
"""

import argparse
import time

import numpy as np

from kneecore import MOMENT, ParameterSpace, simulate, simulate_batch
from kneecore.knee.physics.dynamics import respond
from kneecore.knee.physics.marks import at_rest
from kneecore.knee.response import prepare


def space(times):
    """The packaged baseline with `times` the default bounds (material at most 95 %)."""
    return ParameterSpace(
        geometry_bound_mm=times, slope_bound_deg=times, material_bound_percent=min(10 * times, 95)
    )


def drawn(times, n, seed):
    """Parameters of `n` knees, uniform in the bounds."""
    wide = space(times)
    return wide.from_unit(np.random.default_rng(seed).random((n, len(wide.lower))))


def tell_baseline():
    """Print the distance of the baseline's angles from rest."""
    x = space(1).baseline
    motion, rest = simulate(x), simulate(x, solver="equilibrium")
    away = np.degrees(np.abs(motion.flexion - rest.flexion))
    told = ", ".join(f"{MOMENT[k]:+g} N m {away[k]:.2f} deg" for k in range(12) if away[k] > 0.1)
    print(f"baseline, settled at all loads, not at rest at: {told}")


def tell_default(n, seed):
    """Print how many settled loads are not at rest, and by how much."""
    x = drawn(1, n, seed)
    motion, rest = simulate_batch(x), simulate_batch(x, solver="equilibrium")
    away = np.degrees(np.abs(motion.flexion - rest.flexion))
    away[~np.isnan(rest.lost_at)] = np.nan
    settled = motion.settled & np.isfinite(away)
    moving = settled & ~motion.at_rest
    at = {f"{MOMENT[k]:+g}": int(moving[:, k].sum()) for k in range(12) if moving[:, k].any()}
    print(
        f"{n:,} knees: {settled.sum():,} settled loads, {100 * moving.sum() / settled.sum():.1f} "
        f"% not at rest, at most {away[settled].max():.2f} deg; by load, "
        + ", ".join(f"{load} N m {count:,}" for load, count in at.items())
    )
    print(f"implausible at the default bounds: {motion.n_implausible}")


def tell_wide(n, seed):
    """Print how many knees are implausible at ten times the bounds."""
    batch = simulate_batch(drawn(10, n, seed))
    unmarked = batch.implausible.any(axis=1) & ~batch.failed
    print(
        f"{n:,} knees at ten times the bounds: {batch.n_failed:,} failed, "
        f"{unmarked.sum():,} accepted and implausible"
    )


def tell_cost(n, seed):
    """Print the time of the mark `at_rest` beside that of the motion, in turns."""
    rows = prepare(drawn(1, n, seed), None, "recomputed")
    poses, _, _ = respond(rows)
    motions, marks = [], []
    for _ in range(5):
        start = time.perf_counter()
        respond(rows)
        middle = time.perf_counter()
        at_rest(rows, poses)
        motions.append(middle - start)
        marks.append(time.perf_counter() - middle)
    motion, mark = (1e6 * min(seconds) / n for seconds in (motions, marks))
    print(
        f"at_rest: {mark:.2f} us a knee beside {motion:.1f} of motion, {100 * mark / motion:.1f} %"
    )


def main():
    """Print all of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--knees", type=int, default=4000, help="within the default bounds")
    parser.add_argument("--wide", type=int, default=28000, help="at ten times the bounds")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    tell_baseline()
    tell_default(asked.knees, asked.seed)
    tell_wide(asked.wide, asked.seed)
    tell_cost(asked.knees, asked.seed)


if __name__ == "__main__":
    main()
