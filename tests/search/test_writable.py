"""Whatever a search's result holds can be written, and reads back to the same bytes."""

import contextlib
import json

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from results import check_comes_back
from searches import searched

from kneecore import Cancelled, ModelError, ParameterSpace
from kneecore.cli.search import main

KINDS = {
    "genetic, surrogate": {"pop_size": 20, "n_generations": 3},
    "genetic, model": {"pop_size": 10, "n_generations": 2, "search_space": "model"},
    "exact, surrogate": {"method": "exact", "search_space": "surrogate"},
    "exact, model": {"method": "exact"},
    "repaired": {"pop_size": 20, "n_generations": 3, "repair": True, "repair_models": 4},
    "repaired, exact": {"method": "exact", "repair": True, "repair_models": 4},
}
"""Every method in every space, small."""


def _width(space):
    return {
        "geometry_bound_mm": space,
        "slope_bound_deg": space,
        "material_bound_percent": 10.0 * space,
    }


class _Stop:
    """Cancels at the n-th report of a search; never for None."""

    def __init__(self, n):
        self.left = n

    def __call__(self, report):
        if self.left is None or report.best is None:
            return False
        self.left -= 1
        return self.left < 0


@settings(
    deadline=None, max_examples=4, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(
    kind=st.sampled_from(sorted(KINDS)),
    solver=st.sampled_from(["dynamics", "equilibrium"]),
    width=st.sampled_from([0.5, 2.0, 3.0, 6.0]),
    case=st.sampled_from(["geometry", "material", "both"]),
    stopped_at=st.sampled_from([None, 1, 3]),
    seed=st.integers(0, 99),
)
@example("exact, model", "dynamics", 3.0, "both", 1, 51)
@example("exact, model", "equilibrium", 6.0, "both", None, 3)
@example("genetic, surrogate", "dynamics", 6.0, "both", None, 0)
@example("repaired", "dynamics", 0.5, "geometry", None, 0)
def test_whatever_a_search_finds_reads_back(kind, solver, width, case, stopped_at, seed):
    given_bounds = _width(width)
    if case == "material":
        del given_bounds["geometry_bound_mm"], given_bounds["slope_bound_deg"]
    elif case == "geometry":
        del given_bounds["material_bound_percent"]
    space = ParameterSpace(case=case, **given_bounds)
    # Where too many knees fail, or it was stopped before there was a pair, there is no result.
    with contextlib.suppress(ModelError, Cancelled):
        result = searched(
            space, solver=solver, seed=seed, callback=_Stop(stopped_at), **KINDS[kind]
        )
        check_comes_back(result)


def test_the_widest_exact_search_of_the_command_line_ends_in_a_result(capsys):
    wide = ["--geometry-bound-mm", "3", "--slope-bound-deg", "3", "--material-bound-percent", "30"]
    assert main(["--method", "exact", "--json", "--quiet", "--seed", "51", *wide]) == 0
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert document["objective_model"] > 900.0
    evidence = document["evidence"]
    assert "an evolution strategy for each of the two" in evidence["description"]
    assert "Nothing is proven" in evidence["description"]
