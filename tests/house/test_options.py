"""An option is born once: from a settings class it comes to flags, files, and the page."""

import dataclasses
import io
import json
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest
import study_models
import tyro
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from results import SCHEMA

import kneecore
from kneecore import (
    AccuracyAllocationSettings,
    BoundSweepSettings,
    GeneticOptions,
    InfluenceSettings,
    Knee,
    NeededAccuracySettings,
    ParameterSpace,
    SamplingSettings,
    SearchSettings,
    SurrogateQualitySettings,
    TrainingSweepSettings,
    accuracy_allocation,
    bound_sweep,
    influence,
    monte_carlo,
    needed_accuracy,
    surrogate_quality,
    training_sweep,
)
from kneecore.cli import run, sweep, uncertainty
from kneecore.cli.flags import flag_names, settings_from, with_flags
from kneecore.cli.search import COMMAND, Options
from kneecore.files.search import _REPAIR as TOLD_BY_THE_REPAIR
from kneecore.files.search import to_dict
from kneecore.files.settings import read_settings, write_settings
from kneecore.options import option, options_of
from kneecore.report.command import command_line
from kneecore.search.result import SearchResult

SETTINGS = {
    SearchSettings: Options,
    SamplingSettings: uncertainty.Options,
    InfluenceSettings: uncertainty.Options,
    BoundSweepSettings: sweep.Bound,
    NeededAccuracySettings: sweep.Bound,
    AccuracyAllocationSettings: sweep.Accuracy,
    TrainingSweepSettings: sweep.Training,
}
"""Each settings class, and the options of its command line."""
NO_COMMAND = {SurrogateQualitySettings}
STUDIES = {
    monte_carlo: SamplingSettings(n_samples=300, sampling="sobol", seed=3),
    influence: InfluenceSettings(n_base=32, intervals=False, seed=3),
    bound_sweep: BoundSweepSettings(sizes=(0.5, 1.0), seed=3),
    needed_accuracy: NeededAccuracySettings(within=50.0, largest=1.5, tolerance=0.05, seed=3),
    accuracy_allocation: AccuracyAllocationSettings(
        within=50.0, costs={"force": 2.0}, tolerance=0.05, seed=3
    ),
    training_sweep: TrainingSweepSettings(sizes=(8, 9), n_seeds=2, method="exact", seed=3),
    surrogate_quality: SurrogateQualitySettings(training_samples=9, n_test=20, seed=3),
}
"""Each study, with an option of its own at another value than usual."""

PAIRS = [(kind, one) for kind in SETTINGS for one in options_of(kind)]


def parsed(options, words):
    """Parse a command line's words, silently."""
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        return run.parse(options, words, COMMAND)


def help_of(options):
    out = io.StringIO()
    with redirect_stdout(out), pytest.raises(SystemExit):
        tyro.cli(options, args=["--help"], config=(tyro.conf.FlagCreatePairsOff,))
    return out.getvalue()


@pytest.mark.parametrize(("kind", "one"), PAIRS, ids=lambda p: getattr(p, "name", ""))
def test_every_option_is_documented_and_has_a_flag(kind, one):
    assert len(one.help) > 5
    assert one.help.endswith(".")
    told = help_of(SETTINGS[kind])
    group = dataclasses.is_dataclass(one.default)
    assert (f"{one.flag}." if group else one.flag) in told
    assert flag_names(kind)[one.name] == one.flag


def test_every_settings_class_is_looked_at_here():
    public = {getattr(kneecore, name) for name in kneecore.__all__ if name.endswith("Settings")}
    assert public == {*SETTINGS, *NO_COMMAND}
    assert {type(how) for how in STUDIES.values()} == public - {SearchSettings}


@pytest.mark.parametrize(
    ("study", "how"), STUDIES.items(), ids=lambda p: getattr(p, "__name__", "")
)
def test_a_studys_settings_survive_its_file(study, how):
    for one in options_of(type(how)):
        assert getattr(how, one.name) != one.default, f"`{one.name}` is as usual"
    result = study(study_models.Levers(), how)
    assert result.settings == how
    assert type(result).from_json(result.to_json()).settings == how


@pytest.mark.parametrize("kind", SETTINGS)
def test_no_word_gives_the_defaults(kind):
    assert settings_from(kind, parsed(SETTINGS[kind], [])) == kind()


def schema_at(place):
    table = SCHEMA
    for key in place:
        for part in (table, *table.get("oneOf", ())):
            if key in part.get("properties", {}):
                table = part["properties"][key]
                break
        else:
            return None
    return table


@pytest.mark.parametrize("one", options_of(SearchSettings), ids=lambda one: one.name)
def test_every_option_is_in_the_schema(one):
    table = schema_at(one.place)
    assert table is not None, one.place
    told = [value for part in (table, *table.get("oneOf", ())) for value in part.get("enum", ())]
    if one.choices:
        assert set(told) == set(one.choices)
    if dataclasses.is_dataclass(one.default):
        assert table["type"] == "object"


# Random settings and knees.

SHARES = st.floats(0.01, 0.99).map(lambda x: round(x, 3))


@st.composite
def genetic(draw):
    elite, mutation = draw(st.floats(0.05, 0.4)), draw(st.floats(0.05, 0.4))
    values = {
        "elite_fraction": elite,
        "mutation_fraction": mutation,
        "crossover_fraction": 1.0 - elite - mutation,
        "blx_alpha": draw(SHARES),
        "rank_eta_min": draw(SHARES),
        "gene_mutation_probability": draw(SHARES),
    }
    known = {field.name for field in dataclasses.fields(GeneticOptions)}
    return GeneticOptions(**{name: value for name, value in values.items() if name in known})


@st.composite
def searches(draw):
    """Settings of a search, each option at its default or anywhere."""

    def maybe(strategy, name, values):
        if draw(st.booleans()):
            values[name] = draw(strategy)

    values = {"method": draw(st.sampled_from(["ga", "exact"]))}
    values["repair"] = draw(st.booleans())
    spaces = ["surrogate"] if values["repair"] else ["surrogate", "model"]
    maybe(st.sampled_from(spaces), "search_space", values)
    maybe(st.integers(50, 400), "training_samples", values)
    maybe(st.sampled_from(["all", "extension", "flexion"]), "objective", values)
    maybe(st.lists(st.floats(0.1, 9.0), min_size=12, max_size=12).map(tuple), "weights", values)
    maybe(st.integers(0, 2**63 - 1), "seed", values)
    if values["repair"]:
        maybe(st.integers(2, 99), "repair_models", values)
        maybe(SHARES, "repair_gap_percent", values)
    if values["method"] == "exact" and not values["repair"]:
        exact_in_model = values.get("search_space", "model") == "model"
        maybe(st.just(exact_in_model), "thorough", values)
        maybe(st.just(exact_in_model), "bound", values)
    if values["method"] == "ga":
        maybe(st.integers(30, 500), "pop_size", values)
        maybe(st.integers(1, 900), "n_generations", values)
        maybe(st.integers(1, 9), "n_runs", values)
        maybe(genetic(), "options", values)
    return SearchSettings(**values)


@st.composite
def knees(draw):
    bound = st.floats(0.1, 2.0).map(lambda x: round(x, 4))
    space = {
        name: draw(bound)
        for name in ("geometry_bound_mm", "slope_bound_deg", "material_bound_percent")
        if draw(st.booleans())
    }
    rest = draw(st.sampled_from([None, "rest_length_bound_mm", "rest_length_bound_percent"]))
    if rest is not None:
        space[rest] = draw(bound)
    space["distribution"] = draw(st.sampled_from(["uniform", "normal", "truncated-normal"]))
    if space["distribution"] != "uniform":
        space["deviations"] = draw(st.sampled_from([None, 1.5]))
    space["quantile"] = draw(st.sampled_from([None, 0.9]))
    return Knee(
        ParameterSpace(case=draw(st.sampled_from(["both", "geometry", "material"])), **space),
        solver=draw(st.sampled_from(["dynamics", "equilibrium"])),
        rest_length=draw(st.sampled_from(["recomputed", "fixed"])),
    )


def result_of(knee, how):
    """Return a result that nothing was computed for: the baseline, twice."""
    x = np.stack([knee.nominal, knee.nominal])
    y = np.zeros((2, 12))
    baseline = RESPONSE
    return SearchResult(
        model=knee, settings=how, x=x, y=y, y_nominal=y[0], y_surrogate=None,
        responses=dict.fromkeys(("baseline", "model_1", "model_2"), baseline),
        objective_surrogate=None, objective_model=0.0, gap_percent=None, training_x=None,
        training_y=None, loo_rms=None, run_values=(0.0,), history=np.zeros(1),
        stop_reason="converged",
        counts={f"models_{k}": 0 for k in ("simulated", *knee.count_names)}
        | {"pairs_evaluated": 0},
        seconds={}, threads=1, versions={},
    )  # fmt: skip


RESPONSE = Knee().simulate(Knee().nominal)


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(knee=knees(), how=searches())
def test_the_printed_command_gives_equal_settings_and_an_equal_knee(knee, how):
    how = how.of(knee)
    command = command_line(result_of(knee, how))
    assert command.startswith(f"{COMMAND} ") or command == COMMAND
    options = parsed(Options, command.removeprefix(COMMAND).split())
    again = options.subject()
    assert settings_from(SearchSettings, options).of(again) == how
    assert (again.solver, again.rest_length) == (knee.solver, knee.rest_length)
    assert again.space.case == knee.space.case
    assert again.names == knee.names
    assert again.space.likely == knee.space.likely
    np.testing.assert_array_equal([again.lower, again.upper], [knee.lower, knee.upper])


@settings(deadline=None, max_examples=60)
@given(how=searches())
def test_settings_survive_a_file(how):
    document = {}
    write_settings(how, document, without=TOLD_BY_THE_REPAIR)
    repair = {name: getattr(how, name) for name in TOLD_BY_THE_REPAIR}
    assert read_settings(SearchSettings, json.loads(json.dumps(document)), **repair) == how


@settings(deadline=None, max_examples=25)
@given(knee=knees(), how=searches())
def test_every_option_stands_at_its_place_in_a_results_file(knee, how):
    how = how.of(knee)
    document = json.loads(json.dumps(to_dict(result_of(knee, how))))
    for one in options_of(SearchSettings):
        if one.name in (*TOLD_BY_THE_REPAIR, "max_runs"):  # no repair here, and no limit
            continue
        value = document
        for key in one.place:
            value = value[key]
        mine = getattr(how, one.name)
        mine = dataclasses.asdict(mine) if dataclasses.is_dataclass(mine) else mine
        assert value == (list(mine) if isinstance(mine, tuple) else mine), one.name


# One line more.


@dataclass(frozen=True, kw_only=True)
class More(SearchSettings):
    """Settings with options of their own."""

    patience: int = option(7, place=("search", "patience"), metavar="N")
    """Rounds without a find that are waited for."""
    mood: Literal["calm", "bold"] = option("calm", key="temper")
    """How far steps go."""


@dataclass(frozen=True, kw_only=True)
class Plain:
    """No options."""


def test_an_option_that_is_added_arrives_everywhere():
    made = with_flags(Plain, More)
    told = help_of(made)
    for word in ("--patience", "--temper", "Rounds without a find", "{calm,bold}", "--pop-size"):
        assert word in told
    options = parsed(made, ["--patience", "9", "--temper", "bold", "--seed", "3"])
    how = settings_from(More, options)
    assert (how.patience, how.mood, how.seed) == (9, "bold", 3)
    assert flag_names(More)["mood"] == "--temper"
    document = {}
    write_settings(how, document, without=TOLD_BY_THE_REPAIR)
    assert document["search"]["patience"] == 9
    assert document["temper"] == "bold"
    assert read_settings(More, json.loads(json.dumps(document))) == how
    del document["search"]["patience"], document["temper"]  # of before the options were added
    assert read_settings(More, document) == More(seed=3)
    with pytest.raises(ValueError, match="`temper` is 'wild'; 'calm' or 'bold' is allowed"):
        read_settings(More, {**document, "temper": "wild"})


def test_the_check_of_the_schema_would_see_a_new_option():
    new = [one for one in options_of(More) if one.name in ("patience", "mood")]
    assert [schema_at(one.place) for one in new] == [None, None]
