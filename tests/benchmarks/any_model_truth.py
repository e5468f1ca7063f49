"""The true worst pairs of the public models, found without kneecore's searches.

Recompute ``any_model_truth.json`` with ``python tests/benchmarks/any_model_truth.py``.

For a pattern s of signs the pair falls apart into the points with the largest and with the smallest
s.y. Patterns begin with those of the farthest pairs among corners and Sobol' points; for each of
them both halves are sought by differential evolution with a polish; signs that the pair then has
are sought in turn.
"""

import itertools
import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import differential_evolution, minimize
from scipy.stats import qmc

sys.path.insert(0, str(Path(__file__).parents[1]))

FILE = Path(__file__).with_suffix(".json")
PATTERNS = 3


def points_of(case):
    sobol = qmc.Sobol(case.d, rng=0).random(4096)
    corners = itertools.islice(itertools.product([0.0, 1.0], repeat=case.d), 4096)
    every = list(corners) if case.d <= 12 else (sobol > 0.5).astype(float)
    return np.vstack([sobol, every])


def half(case, signs, points, y, seed):
    """Return the largest s.y that can be found."""
    order = np.argsort(-(y @ signs))[:20]

    def loss(u):
        return -(case.unit(np.atleast_2d(u.T)) @ signs)

    box = [(0.0, 1.0)] * case.d
    evolved = differential_evolution(
        loss, box, rng=seed, maxiter=300, popsize=12, tol=1e-10, vectorized=True,
        updating="deferred", polish=False, init=np.vstack([points[order], qmc.Sobol(
            case.d, rng=seed).random(64)]),
    )  # fmt: skip
    ends = [evolved.x, *points[order[:6]]]
    polished = [minimize(lambda u: loss(u)[0], u, bounds=box, method="L-BFGS-B") for u in ends]
    best = min(polished, key=lambda r: r.fun)
    return best.x if best.fun <= evolved.fun else evolved.x


def truth(case):
    points = points_of(case)
    y = case.unit(points)
    rng = np.random.default_rng(0)
    ends = np.unique(
        np.concatenate([[np.argmax(y @ s), np.argmin(y @ s)]
                        for s in np.vstack([np.ones(y.shape[1]), np.eye(y.shape[1]),
                                            rng.choice([-1.0, 1.0], (200, y.shape[1]))])])
    )  # fmt: skip
    far = sorted(itertools.combinations(ends, 2), key=lambda p: -np.abs(y[p[0]] - y[p[1]]).sum())[
        :2000
    ]
    waiting, done, best = [], set(), 0.0
    for i, j in far:
        s = np.where(y[i] >= y[j], 1.0, -1.0)
        s *= s[0]
        if len(waiting) < PATTERNS and not any((s == w).all() for w in waiting):
            waiting.append(s)
    while waiting and len(done) < 8:
        s = waiting.pop(0)
        if tuple(s) in done:
            continue
        done.add(tuple(s))
        pair = case.unit(np.stack([half(case, s, points, y, 1), half(case, -s, points, y, 2)]))
        best = max(best, float(np.abs(pair[0] - pair[1]).sum()))
        own = np.where(pair[0] >= pair[1], 1.0, -1.0)
        waiting.append(own * own[0])
    return best


if __name__ == "__main__":
    from public_models import CASES

    found = {case.name: truth(case) for case in CASES}
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
