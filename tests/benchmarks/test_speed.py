"""Run with ``python -m pytest tests/benchmarks``; plain pytest leaves it out.

Nothing is asserted on times: `python tests/benchmarks/table.py` writes them side by side.
"""

import cases
import numpy as np
import pytest
import rivals

from kneecore.model.dynamics import respond
from kneecore.model.forces import THETA_0

PAIRED = [c for c in cases.CASES if c.rival is not None]


@pytest.mark.parametrize("case", cases.CASES, ids=lambda c: c.name)
def test_ours(benchmark, case):
    benchmark.group = case.name
    benchmark.pedantic(case.ours, rounds=case.repeats, warmup_rounds=1 if case.rival else 0)


@pytest.mark.parametrize("case", PAIRED, ids=lambda c: f"{c.name}: {c.rival_name}")
def test_rival(benchmark, case):
    benchmark.group = case.name
    benchmark.pedantic(case.rival, rounds=case.repeats, warmup_rounds=1)


def test_the_scalar_rival_computes_the_same():
    rows = cases.knees()[:32]
    turned = respond(rows)[0][..., 2]
    np.testing.assert_allclose(rivals.scalar_flexion(rows), THETA_0 - turned, atol=1e-10)


def test_both_searches_find_as_good_a_pair():
    ours = [cases.surrogate_search(seed=s).value for s in range(5)]
    theirs = [cases.numpy_search(seed=s)[0] for s in range(2)]
    assert np.mean(ours) > 0.99 * max(theirs)
