"""Run with ``python -m pytest tests/benchmarks``; plain pytest leaves it out.

It needs the libraries of ``python -m pip install ".[bench]"``. Nothing is asserted on times:
`python tests/benchmarks/table.py` writes them side by side. Quality and accuracy are.
"""

import cases
import numpy as np
import peers
import pytest
import quality
import rivals
import table

from kneecore import InfluenceSettings, Knee, influence

PAIRED = [c for c in cases.CASES if c.rival is not None]


@pytest.mark.parametrize("case", cases.CASES, ids=lambda c: f"{c.name}: {c.rival_name}")
def test_ours(benchmark, case):
    benchmark.group = case.name
    benchmark.pedantic(case.ours, rounds=case.repeats, warmup_rounds=1 if case.rival else 0)


@pytest.mark.parametrize("case", PAIRED, ids=lambda c: f"{c.name}: {c.rival_name}")
def test_rival(benchmark, case):
    benchmark.group = case.name
    benchmark.pedantic(case.rival, rounds=case.rival_repeats or case.repeats)


def test_the_scalar_rival_computes_the_same():
    rows = cases.knees()[:32]
    np.testing.assert_allclose(rivals.scalar_flexion(rows), cases.flexion(rows), atol=1e-10)


def test_solve_ivp_computes_the_same():
    # It integrates the motion itself, we in steps of 4 ms: that is the difference.
    rows = cases.knees()[:3]
    apart = np.degrees(rivals.solve_ivp_flexion(rows) - cases.flexion(rows))
    assert np.abs(apart).max() < 0.01


def test_the_rivals_and_peers_have_our_objective():
    pairs = np.random.default_rng(0).random((20, quality.N_GENES))
    ours = [quality.pair_objective().exact(pair) for pair in pairs]
    for objective in (quality.matrix_product(), quality.interpolated()):
        np.testing.assert_allclose(objective(pairs), ours, rtol=1e-9)
    np.testing.assert_allclose(quality.pair_objective()(pairs), ours, rtol=1e-5)


def test_both_searches_find_as_good_a_pair_over_20_seeds():
    exact = quality.pair_objective().exact
    theirs = [exact(cases.numpy_search(seed=s)[1]) for s in range(20)]
    ours = [exact(cases.surrogate_search(seed=s).x) for s in range(20)]
    assert np.mean(ours) > 0.999 * np.mean(theirs)
    assert min(ours) > 0.99 * min(theirs)


@pytest.mark.parametrize("search", [peers.scipy_search, peers.deap_search, peers.pymoo_search])
def test_a_peer_keeps_to_the_bounds_and_the_budget(search):
    counted = quality.Counted(lambda x: -((x - 0.3) ** 2).sum(axis=1))
    x = search(counted, 6, 4000, 0)
    assert x.shape == (6,)
    assert x.min() >= 0.0
    assert x.max() <= 1.0
    assert 3800 <= counted.n <= 4200
    assert np.abs(x - 0.3).max() < 0.05


def test_salib_finds_the_same_indices():
    ours = influence(Knee(), InfluenceSettings(intervals=False)).indices
    theirs = cases.sobol_by_salib()
    np.testing.assert_allclose(ours.first_order, theirs[0], atol=0.1)
    np.testing.assert_allclose(ours.total_order, theirs[1], atol=0.1)


def test_a_missing_peer_is_named_with_what_installs_it():
    with pytest.raises(peers.PeerMissingError, match=r"`no_such_peer` is not .*\.\[bench\]"):
        peers.imported("no_such_peer")


def test_the_table_is_written_between_the_marks_or_not_at_all(tmp_path):
    path = tmp_path / "README.md"
    path.write_text(f"above\n{table.BEGIN}\nold\n{table.END}\nbelow\n", encoding="utf-8")
    table.write(path, "| new |")
    assert path.read_text() == f"above\n{table.BEGIN}\n| new |\n{table.END}\nbelow\n"
    assert [p.name for p in tmp_path.iterdir()] == ["README.md"]
    path.write_text("no marks", encoding="utf-8")
    with pytest.raises(ValueError, match="one file with one"):
        table.check([str(path)])
