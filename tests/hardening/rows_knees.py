"""Rows of the knees: a hundred thousand of them, good and absurd, through both solvers."""

from dataclasses import fields

import numpy as np
from hardening.rows import Outcome, Scale, row

from kneecore import ParameterSpace, simulate_batch
from kneecore.knee.response import ResponseBatch

TIMES = (1.0, 3.0, 10.0)
USUAL = 100_000
_CHUNK = 4000
_MAY_BE_NAN = {"lost_at", "rest_length", "load_free_position"}


def drawn(times: float, n: int, seed: int):
    """Parameters of `n` knees in `times` the default bounds, every third on a corner of them."""
    space = ParameterSpace(
        geometry_bound_mm=times,
        slope_bound_deg=times,
        material_bound_percent=min(10.0 * times, 95.0),
    )
    unit = np.random.default_rng(seed).random((n, len(space.lower)))
    unit[::3] = np.round(unit[::3])
    return space.from_unit(unit)


def arrays(batch: ResponseBatch) -> dict[str, np.ndarray]:
    """Return a batch's fields that have a row for each knee."""
    told = {f.name: getattr(batch, f.name) for f in fields(batch)}
    del told["moment"]
    return told


def differing(batch: ResponseBatch, other: ResponseBatch, at: slice = slice(None)) -> int:
    """Return how many fields of `other` are not bit by bit those of `batch` at these rows."""
    mine, theirs = arrays(batch), arrays(other)
    return sum(
        np.ascontiguousarray(mine[name][at]).tobytes() != np.ascontiguousarray(v).tobytes()
        for name, v in theirs.items()
    )


def faults(batch: ResponseBatch, x: np.ndarray) -> dict[str, int]:
    """Return how many knees of a batch are not marked as their numbers are."""
    theta, failed = np.degrees(batch.flexion), batch.refinements < 0
    bare = np.zeros(len(x), dtype=bool)
    for name, values in arrays(batch).items():
        if name not in _MAY_BE_NAN:
            bare |= ~np.isfinite(values.reshape(len(x), -1).astype(float)).all(axis=1)
    with np.errstate(invalid="ignore"):
        odd = (theta < -60.0) | (theta > 170.0) | (batch.indentation > 0.5 * x[:, 18, None])
    named = np.array(batch.status) == "failed"
    return {
        "unmarked NaN": int((bare & ~failed).sum()),
        "uncounted": int((named != failed).sum()) + abs(batch.n_failed - int(failed.sum())),
        "a failed knee with numbers": int((failed & np.isfinite(theta).any(axis=1)).sum()),
        "implausible, unmarked": int((odd != batch.implausible).sum()),
        "failed, at rest": int(batch.at_rest[failed].sum()),
    }


@row("Knees far beyond the bounds")
def knees(scale: Scale) -> Outcome:
    """Run knees at 1, 3 and 10 times the bounds through both solvers, on one thread and on two."""
    each = max(scale.count(USUAL) // len(TIMES), 1)
    done, wrong, failed, odd = 0, {}, 0, 0
    for number, times in enumerate(TIMES):
        for first in range(0, each, _CHUNK):
            n = min(_CHUNK, each - first)
            x = drawn(times, n, 1000 * number + first)
            done += n
            for solver in ("dynamics", "equilibrium"):
                one = simulate_batch(x, solver=solver, threads=1)
                two = simulate_batch(x, solver=solver, threads=2)
                some = slice(n // 3, n // 3 + 37)
                small = simulate_batch(x[some], solver=solver, threads=2)
                found = faults(one, x) | {
                    "fields that differ with threads": differing(one, two),
                    "fields that differ with batches": differing(one, small, some),
                }
                wrong = {name: wrong.get(name, 0) + count for name, count in found.items()}
                failed += one.n_failed
                odd += one.n_implausible
    bad = ", ".join(f"{count:,} {name}" for name, count in wrong.items() if count)
    return Outcome(
        injected=f"{done:,} knees at 1, 3 and 10 times the bounds, in motion and at rest",
        happened=bad
        or (
            f"no crash, no NaN without its mark ({failed:,} failed, {odd:,} implausible, all "
            "counted); the same bits on 1 and 2 threads and in small batches"
        ),
        sound=not bad,
    )
