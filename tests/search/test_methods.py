"""The search's methods side by side."""

import numpy as np
import pytest

from kneecore import Cancelled, ParameterSpace, simulate_batch, worst_case
from kneecore.search.compare import compare_methods

SPACE = ParameterSpace(case="geometry", geometry_bound_mm=0.6)


@pytest.fixture(scope="module", params=["equilibrium", "dynamics"])
def found(request):
    return compare_methods(SPACE, solver=request.param, threads=1)


def test_every_f_is_the_true_models_of_its_pair(found):
    for name, trace in found.items():
        solver = trace.result.solver
        angles = np.degrees(simulate_batch(trace.result.x, solver=solver).flexion)
        f = np.abs(angles[0] - angles[1]).sum()
        assert trace.objective[-1] == pytest.approx(f, rel=1e-9), name


def test_traces_rise_and_end_with_the_models_that_were_run(found):
    for trace in found.values():
        assert (np.diff(trace.n_models) > 0).all()
        assert (np.diff(trace.objective) >= 0).all()
    exact = found["exact"].result.evidence
    assert found["exact"].n_models[-1] == exact.n_evaluations + exact.n_in_motion
    ga = found["ga"].result
    # Its pairs, and before and after them what the search looks at by itself.
    assert found["ga"].n_models[-1] == 2 * ga.counts["pairs_evaluated"]
    assert 0 <= ga.counts["models_simulated"] - found["ga"].n_models[-1] <= 4
    assert len(found["ga"].n_models) == 101
    assert found["ga_surrogate"].n_models.tolist() == [52]
    repaired = found["repair"]
    assert repaired.n_models[-1] == repaired.result.counts["models_simulated"] <= 50 + 40
    assert repaired.objective[-1] > found["ga_surrogate"].objective[-1]


def test_the_exact_search_is_not_beaten(found):
    best = max(t.objective[-1] for t in found.values())
    assert found["exact"].shortfall_percent(best) < 1e-9
    assert found["ga_surrogate"].shortfall_percent(best) > 0.0


def test_it_is_what_each_search_finds_by_itself(found):
    solver = found["exact"].result.solver
    exact = worst_case(SPACE, method="exact", solver=solver)
    assert found["exact"].result.x.tobytes() == exact.x.tobytes()
    main = worst_case(SPACE, solver=solver)
    assert found["ga_surrogate"].result.x.tobytes() == main.x.tobytes()


def test_progress_rises_over_all_methods_and_cancels():
    seen = []
    compare_methods(SPACE, solver="equilibrium", callback=lambda r: seen.append(r.done / r.total))
    assert seen == sorted(seen)
    assert seen[0] == 0.0
    assert seen[-1] > 0.9
    with pytest.raises(Cancelled):
        compare_methods(SPACE, solver="equilibrium", callback=lambda r: r.done / r.total > 0.5)
