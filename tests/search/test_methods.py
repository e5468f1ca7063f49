"""The search's methods side by side."""

import numpy as np
import pytest
from searches import searched

from kneecore import (
    Cancelled,
    Knee,
    ParameterSpace,
    SearchSettings,
    compare_methods,
    simulate_batch,
)
from kneecore.search.compare import _run_all

SPACE = ParameterSpace(case="geometry", geometry_bound_mm=0.6)


@pytest.fixture(scope="module", params=["equilibrium", "dynamics"])
def found(request):
    knee = Knee(SPACE, solver=request.param, threads=1)
    return {t.trace.method: t for t in _run_all(knee, SearchSettings(), None)}


def test_every_f_is_the_true_models_of_its_pair(found):
    for name, method in found.items():
        solver = method.result.model.solver
        angles = np.degrees(simulate_batch(method.result.x, solver=solver).flexion)
        f = np.abs(angles[0] - angles[1]).sum()
        assert method.trace.objective[-1] == pytest.approx(f, rel=1e-9), name


def test_traces_rise_and_end_with_the_models_that_were_run(found):
    for trace in (method.trace for method in found.values()):
        assert (np.diff(trace.n_models) > 0).all()
        assert (np.diff(trace.objective) >= 0).all()
    exact = found["exact"].result.evidence
    assert found["exact"].trace.n_models[-1] == exact.n_evaluations + exact.n_models
    ga = found["ga"].result
    # Its pairs, and before and after them what the search looks at by itself.
    assert found["ga"].trace.n_models[-1] == 2 * ga.counts["pairs_evaluated"]
    assert 0 <= ga.counts["models_simulated"] - found["ga"].trace.n_models[-1] <= 4
    assert len(found["ga"].trace.n_models) == 101
    assert found["ga_surrogate"].trace.n_models == (52,)
    repaired = found["repair"]
    assert repaired.trace.n_models[-1] == repaired.result.counts["models_simulated"] <= 50 + 40
    assert repaired.trace.objective[-1] > found["ga_surrogate"].trace.objective[-1]


def test_the_exact_search_is_not_beaten(found):
    best = max(t.trace.objective[-1] for t in found.values())
    assert found["exact"].trace.shortfall_percent(best) < 1e-9
    assert found["ga_surrogate"].trace.shortfall_percent(best) > 0.0


def test_it_is_what_each_search_finds_by_itself(found):
    solver = found["exact"].result.model.solver
    exact = searched(SPACE, method="exact", solver=solver)
    assert found["exact"].result.x.tobytes() == exact.x.tobytes()
    main = searched(SPACE, solver=solver)
    assert found["ga_surrogate"].result.x.tobytes() == main.x.tobytes()


def test_progress_rises_over_all_methods_and_cancels():
    seen = []
    knee = Knee(SPACE, solver="equilibrium")
    compare_methods(knee, callback=lambda r: seen.append(r.done / r.total))
    assert seen == sorted(seen)
    assert seen[0] == 0.0
    assert seen[-1] > 0.9
    with pytest.raises(Cancelled):
        compare_methods(knee, callback=lambda r: r.done / r.total > 0.5)
