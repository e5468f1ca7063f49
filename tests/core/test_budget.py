"""What cannot fit is refused in a line, for every whole number that can be asked for."""

import time
from typing import get_args, get_origin, get_type_hints

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
from kneecore.cli import paper, search, sweep, uncertainty
from kneecore.options import options_of
from kneecore.progress import Cancelled
from kneecore.search.budget import search_budget
from kneecore.search.compare import comparison_budgets, methods_of

VERBS = {
    SearchSettings: worst_case,
    SamplingSettings: monte_carlo,
    InfluenceSettings: influence,
    TrainingSweepSettings: training_sweep,
    SurrogateQualitySettings: surrogate_quality,
}
COMMANDS = [
    (search.main, [], search.Options),
    (uncertainty.main, [], uncertainty.Options),
    (sweep.main, ["training"], sweep.Training),
    (sweep.main, ["bound"], sweep.Bound),
    (paper.main, [], paper.Options),
]
SEEDS_ONLY = (BoundSweepSettings, NeededAccuracySettings)
LARGEST = 2**31 - 1
RUNS = {
    "n_samples": "a day's work: the samples are not kept",
    "n_runs": "the same search again",
    "repair_batch": "never more than `repair_models`",
    "max_runs": "no more than the other options need",
}
"""Options whose largest value is allowed on a large machine, and why."""


def _is_whole(option):
    return option.type is int or int in get_args(option.type)


def _counts(kind):
    return [o for o in options_of(kind) if _is_whole(o) and o.name != "seed"]


EVERY = [(k, o) for k in (*VERBS, *SEEDS_ONLY) for o in _counts(k) if o.name not in RUNS]
WHOLE = [(k, o) for k in (*VERBS, *SEEDS_ONLY) for o in options_of(k) if _is_whole(o)]


def _is_row(kind):
    return tuple in map(get_origin, (kind, *get_args(kind)))


def _set(one, value):
    values = {one.name: (value,) if _is_row(one.type) else value}
    return values | ({"repair": True} if one.name == "repair_models" else {})


def _ids(pair):
    return getattr(pair, "name", getattr(pair, "__name__", None))


def _whole_flags(options):
    """Return the flags of a command line that take whole numbers."""
    kinds = get_type_hints(options)
    whole = [name for name, kind in kinds.items() if int in (kind, *get_args(kind))]
    whole += [name for name, kind in kinds.items() if kind == tuple[int, ...]]
    return [f"--{name.replace('_', '-')}" for name in whole]


FLAGS = [(*command, flag) for *command, options in COMMANDS for flag in _whole_flags(options)]


def test_the_flags_that_are_walked_are_the_known_ones():
    flags = {flag for _, _, flag in FLAGS}
    assert {"--threads", "--seed", "--pop-size", "--samples", "--seeds", "--sizes"} <= flags
    assert sum(flag == "--threads" for _, _, flag in FLAGS) == len(COMMANDS)
    assert sum(flag == "--seed" for _, _, flag in FLAGS) == len(COMMANDS)


@pytest.mark.parametrize("value", ["1" + 20 * "0", "1" + 400 * "0", "-1"])
@pytest.mark.parametrize(("main", "words", "flag"), FLAGS)
def test_every_command_line_refuses_a_number_that_nothing_can_count(
    main, words, flag, value, capsys
):
    needs = ["--repair"] if flag == "--repair-models" else []
    needs = ["--influence"] if flag == "--base-samples" else needs
    begun = time.perf_counter()
    assert main([*words, *needs, f"{flag}={value}"]) == 2
    assert time.perf_counter() - begun < 5.0
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert flag.removeprefix("--").replace("-", "_") in err.replace("-", "_")


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


@pytest.mark.parametrize(
    ("main", "words", "verb"),
    [
        (sweep.main, ["bound"], "study.bound_sweep.bound_sweep"),
        (paper.main, [], "paper.redo.redo_paper"),
        (search.main, ["--compare"], "search.worst_case.worst_case"),
    ],
)
def test_long_commands_announce_themselves(main, words, verb, capsys, monkeypatch):
    def stopped(*_arguments, **_options):
        raise Cancelled

    monkeypatch.setattr(f"kneecore.{verb}", stopped)
    monkeypatch.setattr(told, "WORTH_TELLING", 1.0)
    main([*words, "--threads", "1"])
    assert "models to run: about " in capsys.readouterr().err


def test_a_comparison_counts_all_its_methods():
    knee = Knee(threads=1)
    methods = comparison_budgets(knee, SearchSettings())
    assert len(methods) == len(methods_of(knee))
    assert sum(one.models for one in methods) > 15_000  # 100 x 100 pairs in the model


def _written(folder, **files):
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="ascii")


V2, V1 = "sys/fs/cgroup", "sys/fs/cgroup/memory"


@pytest.mark.parametrize(
    ("line", "files", "limit"),
    [
        ("0::/", {f"{V2}/memory.max": "1000\n"}, 1000.0),
        ("0::/", {f"{V2}/memory.max": "max\n"}, float("inf")),
        (
            "0::/a/b",
            {f"{V2}/a/memory.max": "500\n", f"{V2}/a/b/memory.max": "max\n"},
            500.0,
        ),
        ("0::/../../x", {f"{V2}/memory.max": "700"}, 700.0),
        (
            "9:name=systemd:/\n4:cpu,memory:/docker/1",
            {f"{V1}/memory.limit_in_bytes": "2000", f"{V1}/docker/1/memory.limit_in_bytes": "3000"},
            2000.0,
        ),
        ("5:cpuset:/", {f"{V1}/memory.limit_in_bytes": "9"}, float("inf")),
        ("nonsense", {f"{V2}/memory.max": "many"}, float("inf")),
    ],
)
def test_the_limit_of_a_container_is_read(line, files, limit, tmp_path):
    assert budget.container_memory(tmp_path) == float("inf")
    _written(tmp_path, **files, **{"proc/self/cgroup": line + "\n"})
    assert budget.container_memory(tmp_path) == limit


def test_a_container_has_less_than_its_machine(monkeypatch):
    monkeypatch.setattr(budget, "container_memory", lambda: 2.0**20)
    assert budget.installed_memory() == 2.0**20
