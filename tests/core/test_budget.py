"""What cannot fit is refused in a line, for every whole number that can be asked for."""

import time
from typing import get_args

import pytest

from kneecore import (
    BoundSweepSettings,
    InfluenceSettings,
    Knee,
    KneecoreError,
    NeededAccuracySettings,
    ParameterError,
    SamplingSettings,
    SearchSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
    budget,
    influence,
    landscape,
    monte_carlo,
    surrogate_quality,
    training_sweep,
    worst_case,
)
from kneecore.cli import budget as told
from kneecore.cli import search, sweep, uncertainty
from kneecore.options import options_of
from kneecore.search.budget import search_budget

VERBS = {
    SearchSettings: worst_case,
    SamplingSettings: monte_carlo,
    InfluenceSettings: influence,
    TrainingSweepSettings: training_sweep,
    SurrogateQualitySettings: surrogate_quality,
}
SEEDS_ONLY = (BoundSweepSettings, NeededAccuracySettings)
LARGEST = 2**31 - 1
RUNS = {"n_samples": "a day's work: the samples are not kept", "n_runs": "the same search again"}
"""Options whose largest value is allowed on a large machine, and why."""


def _is_whole(option):
    return option.type is int or int in get_args(option.type)


def _counts(kind):
    return [o for o in options_of(kind) if _is_whole(o) and o.name != "seed"]


EVERY = [(k, o) for k in (*VERBS, *SEEDS_ONLY) for o in _counts(k) if o.name not in RUNS]
WHOLE = [(k, o) for k in (*VERBS, *SEEDS_ONLY) for o in options_of(k) if _is_whole(o)]


def _set(one, value):
    values = {one.name: (value,) if get_args(one.type) else value}
    return values | ({"repair": True} if one.name == "repair_models" else {})


def _ids(pair):
    return getattr(pair, "name", getattr(pair, "__name__", None))


@pytest.mark.parametrize(("kind", "one"), WHOLE, ids=_ids)
@pytest.mark.parametrize("value", [2**63, 10**20, 10**400, -1])
def test_numbers_that_no_machine_can_count_are_refused(kind, one, value):
    with pytest.raises(ParameterError, match=f"`{one.name}` is .*whole number") as refused:
        kind(**_set(one, value))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("kind", "one"), EVERY, ids=_ids)
def test_the_largest_count_is_refused_before_anything_is_done(kind, one, monkeypatch):
    monkeypatch.setattr(budget, "installed_memory", lambda: 8 * 2.0**30)
    begun = time.perf_counter()
    with pytest.raises(ParameterError, match=f"`{one.name}` is") as why:
        VERBS[kind](Knee(), kind(**_set(one, LARGEST)))
    assert "GiB" in str(why.value) or "years" in str(why.value)
    assert time.perf_counter() - begun < 5.0


def test_a_landscape_that_cannot_fit_is_refused():
    with pytest.raises(ParameterError, match=r"`n_points` is 1000000; that needs about .* GiB"):
        landscape(Knee(), ("acl_femur_x", "acl_femur_y"), n_points=1_000_000)


def test_a_search_that_takes_years_is_refused():
    settings = SearchSettings(n_generations=10**7, n_runs=10**6)
    with pytest.raises(
        KneecoreError, match=r"`n_generations` is 10000000; that takes about .*years"
    ):
        worst_case(Knee(), settings)


@pytest.mark.parametrize(
    ("main", "words", "flag"),
    [
        (search.main, ["--pop-size", "1000000000"], "--pop-size"),
        (search.main, ["--pop-size", "1" + "0" * 20], "--pop-size"),
        (uncertainty.main, ["--samples", "1000000000000"], "--samples"),
        (uncertainty.main, ["--influence", "--base-samples", "2000000000"], "--base-samples"),
        (sweep.main, ["training", "--seeds", "2000000000"], "--seeds"),
        (sweep.main, ["training", "--sizes", "2000000000"], "--sizes"),
    ],
)
def test_command_lines_say_it_with_the_flag(main, words, flag, capsys):
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert f"`{flag}` is" in err


def test_a_large_run_is_announced_and_a_small_or_quiet_one_is_not(capsys):
    knee = Knee(threads=1)
    small = search_budget(SearchSettings().of(knee), knee)
    large = small._replace(models=1_000_000)
    for asked, quiet, said in ((small, False, False), (large, True, False), (large, False, True)):
        told.tell_budget("kneecore", knee, asked, quiet=quiet)
        out, err = capsys.readouterr()
        assert out == ""
        assert ("1,000,000 models to run: about " in err) is said
