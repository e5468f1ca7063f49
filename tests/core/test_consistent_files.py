"""A file that contradicts itself is refused, whatever kind of result it is."""

import json
import os
import subprocess
import sys
from fnmatch import fnmatchcase

import every_kind
import pytest

from kneecore import FileFormatError, Input, Model, Output, SearchSettings, worst_case
from kneecore.files.digest import digest_of
from kneecore.files.load import read_document
from kneecore.presented import format_with_schema

KINDS = [
    *(
        f"{model} {kind}"
        for model in ("knee", "model")
        for kind in (
            *("search", "samples", "comparison", "influence"),
            *("landscape", "sweep", "training", "quality"),
        )
    ),
    *("knee allocation", "model allocation"),
    *("knee need", "knee repair", "knee exact", "knee in motion", "knee study"),
    *("knee bound", "knee bound study", "response", "paper"),
]
NOT_DERIVABLE = {
    "what was asked for": (
        *("baseline.rest_length_bound_*", "model.size", "model.watched", "model.inputs.*"),
        *("model.outputs.*.scale", "search.options.*", "seed", "seeds.*", "threads", "column"),
        *("bound_mm.*", "size.*", "tolerance_mm", "training_samples*", "test_points", "x.*"),
    ),
    "what the clock said": ("seconds", "seconds.*", "equal.seconds"),
    "what only the model can tell": (
        *("y.baseline.*", "y.[*].[*].[*]", "flexion_deg.[*].[*].[*]", "objective_model.[*]"),
        *("pair.*", "extremes.*", "least_angle_deg.*", "largest_angle_deg.*"),
        *("sampled_largest_angle_deg", "tried.*", "equal.tried.*", "nominal_value"),
        *("nominal_angle_deg", "measurements.*.adds_deg", "measurements.*.enlarged_deg"),
        *("measurements.*.gain", "sampled_value", "equal.sampled_*", "largest_value"),
        *("equal.largest_value", "equal.largest_angle_deg"),
    ),
    "what only the knee can tell, which a response's file does not hold": (
        *("flexion_deg.[*]", "tension_n.[*].[*]", "contact_force_n.[*]", "indentation_mm.[*]"),
        *("ap_position_mm.[*]", "tibia_position_mm.[*].[*]", "ligament_rest_length_mm.[*]"),
        "load_free_position_mm.[*]",
    ),
    "what became of each run, which is not kept": (
        *("counts.models_refined", "counts.models_unsettled", "counts.models_failed"),
        *("counts.failed", "counts.refined", "counts.unsettled", "counts.not_at_rest"),
        *("counts.implausible", "counts.lost", "marks.*"),
        *("n_failed*", "n_refined", "n_unsettled", "n_not_at_rest", "n_implausible", "n_lost"),
        *("evidence.models_lost", "evidence.patterns.[*].objective", "evidence.second_best"),
        *(
            "evidence.objective_at_rest",
            "n_sampled_failed",
            "n_sampled",
            "n_searches",
            "equal.n_sampled",
            "tolerance",
        ),
    ),
    "what comes from samples that are not kept": (
        *("*bounds_997*.percentile.*", "share_of_samples_below.*", "first_order.*"),
        *("total_order.*", "interval_95.*", "groups_first_order.*", "excess.*", "excess_share.*"),
        *("loo_rms.[*]", "pairs.objective_*", "rank_correlation.*", "rank_correlation_pairs.[*].*"),
        *("rank_correlation_worst_*", "rms_error*", "variance_explained.*"),
    ),
    "what slopes over the bounds have shown": (
        *("evidence.bound.models*", "evidence.bound.vertices_objective_in_motion"),
        *("evidence.bound.sampled_bounds.*", "evidence.objective_before_climb", "evidence.climbs"),
    ),
}
"""Numbers that do not follow from the rest of a file, by why; ``[*]`` stands for an entry."""
CHANGES = {
    "much": lambda v: 1.37 * v + 3,
    "little": lambda v: v + 1 if isinstance(v, int) else 1.001 * v or 1e-3,
}
INSIDE = ("influence.", "needed_accuracy.")
"""Results that stand in others' files."""


def _name(path):
    name = ".".join("[*]" if isinstance(key, int) else key for key in path)
    for result in INSIDE:
        name = name.removeprefix(result)
    return name


def _fits(name, pattern):
    return fnmatchcase(name, pattern.replace("[*]", "[[][*][]]"))


def _listed(name):
    return any(_fits(name, p) for row in NOT_DERIVABLE.values() for p in row)


def _value(document, path):
    for key in path:
        document = document[key]
    return document


def read(document):
    """Return the result in a document, as `load` does."""
    return read_document(document, format_with_schema(document["schema"]))


def _refused(document):
    """Return why a document is refused, or None."""
    try:
        read(document)
    except FileFormatError as error:
        return str(error)
    return None


def test_the_table_has_every_kind():
    assert set(KINDS) == set(every_kind.texts())


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_altered_is_refused_or_listed(kind):
    document = every_kind.without_digest(every_kind.texts()[kind])
    read(document)  # a file without a digest is read
    passed = set()
    for path in every_kind.numbers_of(document):
        for change in CHANGES.values():
            why = _refused(every_kind.altered(document, path, change(_value(document, path))))
            if why is None:
                passed.add(_name(path))
            assert "\n" not in (why or "")
    assert [name for name in sorted(passed) if not _listed(name)] == []


@pytest.mark.parametrize("kind", KINDS)
def test_the_digest_finds_what_nothing_else_does(kind):
    document = json.loads(every_kind.texts()[kind])
    assert document["digest"] == digest_of(document)
    read(document)
    free = [p for p in every_kind.numbers_of(document) if _listed(_name(p))]
    for path in free[:: max(len(free) // 10, 1)]:
        with pytest.raises(FileFormatError):
            read(every_kind.altered(document, path, _value(document, path) * 1.37 + 3))
    with pytest.raises(FileFormatError, match="`digest` is"):
        read(document | {"digest": "sha256:" + 64 * "0"})


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("objective_model",), 99999.0, "`objective_model` is 99999.0; .* follows from the rest"),
        (("gap_percent",), 1.0, "`gap_percent` is 1.0; "),
        (("flexion_deg", "model_1"), [None] * 12, "`flexion.model_1` lacks numbers, .* is 'ok'"),
        (("parameters", 0, "acl_femur_x"), 0.15, r"`parameters\[0\].acl_femur_x` is 0.15; its bo"),
        (("seconds", "search"), -1.0, "`seconds.search` is -1; a number of at least 0"),
        (("extension_difference_deg",), 1.0, "`extension_difference_deg` is 1.0; "),
        (("counts", "models_failed"), 1.5, "`counts.models_failed` is 1.5; a whole number"),
        (("at_bounds", 0), {}, "at_bounds"),
        (("training", "n_failed"), 7, "`training.n_failed` is 7; 0 follows"),
        (("search", "run_values", 0), 1.0, "`search.run_values` is 1.0; "),
        (("surprise",), 1.0, "the key 'surprise' is none"),
    ],
)
def test_what_contradicts_itself_is_named(path, value, said):
    document = every_kind.without_digest(every_kind.texts()["knee search"])
    with pytest.raises(FileFormatError, match=said):
        read(every_kind.altered(document, path, value))


def test_small_numbers_of_other_models_are_held_to_their_own_size():
    def run(x):
        return 1e-9 * x @ [[1.0, 2.0], [3.0, -1.0]]

    inputs = [Input(name, lower=0.0, upper=1.0) for name in ("a", "b")]
    model = Model(run, inputs, [Output("y", axis=(1, 2))], batched=True)
    settings = SearchSettings(training_samples=5, pop_size=20, n_generations=5)
    document = every_kind.without_digest(worst_case(model, settings).to_json())
    read(document)
    with pytest.raises(FileFormatError, match="`objective_model` is "):
        read(document | {"objective_model": 1.001 * document["objective_model"]})


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "response"])
@pytest.mark.parametrize("key", ["title", "flexion_at_rest_deg"])
def test_what_stands_beside_a_response_stands_nowhere_else(kind, key):
    document = every_kind.without_digest(every_kind.texts()[kind])
    with pytest.raises(FileFormatError, match=f"the key '{key}' is none"):
        read(document | {key: "surprise"})


@pytest.mark.parametrize(
    ("kind", "path", "value", "said"),
    [
        ("knee search", ("search", "history", 2), 1e3, "`search.history` contradicts"),
        ("knee search", ("counts", "pairs_evaluated"), 7, "`counts.pairs_evaluated` contradicts"),
        ("knee exact", ("search", "run_values", 0), 1.0, "`search.run_values` is 1.0; "),
        ("knee exact", ("evidence", "second_best"), 1e3, "`evidence.second_best` contradicts"),
        ("knee exact", ("evidence", "patterns", 0, "objective"), 1e3, "`evidence.patterns` contra"),
        ("knee repair", ("search", "history", -1), 1.0, "`search.history` is 1.0; "),
        ("knee repair", ("repair", "models_failed"), 1, "`repair.models_failed` contradicts"),
        ("knee in motion", ("evidence", "objective_before_climb"), 1e3, "before_climb` contradict"),
        ("knee need", ("largest_angle_deg",), 4.0, "`largest_value` is 4.0; "),
        ("knee quality", ("rank_correlation_pairs",), 0.5, "`rank_correlation_pairs` is 0.5; "),
        ("knee study", ("comparison", "excess_share", "model_1", 0), 9.0, "excess_share"),
        (
            "knee exact",
            ("ligament_rest_length_mm", "model_1", 0),
            30.0,
            "rest_length_mm.model_1` is",
        ),
        ("knee exact", ("tension_n", "model_2", 5, 0), 30.0, "`tension_n.model_2` is 30.0; "),
        ("knee exact", ("flexion_deg", "baseline", 5), -3.0, "`tension_n.baseline` is "),
        ("knee exact", ("implausible", "model_1", 3), True, "`implausible.model_1` contradicts"),
    ],
)
def test_what_follows_is_named(kind, path, value, said):
    document = every_kind.without_digest(every_kind.texts()[kind])
    with pytest.raises(FileFormatError, match=said):
        read(every_kind.altered(document, path, value))


_READ = """
import sys
import kneecore
from numba.core.dispatcher import Dispatcher

def refused(kernel, signature):
    raise SystemExit(f"{kernel.py_func.__name__} was compiled")

Dispatcher.compile = refused
for path in sys.argv[1:]:
    kneecore.load(path)
"""


def test_a_file_is_read_without_compiling_anything(tmp_path):
    kinds = ("knee search", "knee repair", "knee exact", "model search", "response")
    for kind in kinds:
        (tmp_path / f"{kind}.json").write_text(every_kind.texts()[kind], encoding="utf-8")
    command = [sys.executable, "-c", _READ, *map(str, sorted(tmp_path.iterdir()))]
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run(command, env=cold, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("inputs", 7), ("one_signed", 5), ("one_signed_sampled", 5), ("models_lost", 10**6),
        ("vertices", None), ("vertices", 4), ("patterns", 1024), ("vertices_objective", 99.0),
        ("models_lost", 1),
    ],
)  # fmt: skip
def test_a_bound_that_contradicts_itself_is_named(key, value):
    document = every_kind.without_digest(every_kind.texts()["knee bound"])
    with pytest.raises(FileFormatError, match=r"evidence\.bound\."):
        read(every_kind.altered(document, ("evidence", "bound", key), value))


@pytest.mark.parametrize(
    ("key", "value"), [("objective", 1.0), ("widening_percent", 0.0), ("patterns_looked_at", 3000)]
)
def test_sampled_bounds_that_fall_are_named(key, value):
    document = every_kind.without_digest(every_kind.texts()["knee bound"])
    path = ("evidence", "bound", "sampled_bounds", 3, key)
    with pytest.raises(FileFormatError, match=r"evidence\.bound\.sampled_bounds"):
        read(every_kind.altered(document, path, value))


def test_a_bound_that_nobody_asked_for_is_refused():
    document = every_kind.without_digest(every_kind.texts()["knee bound"])
    with pytest.raises(FileFormatError, match=r"`evidence\.bound` contradicts"):
        read(document | {"bound": False, "command": None})
