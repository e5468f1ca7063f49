"""A file that contradicts itself is refused, whatever kind of result it is."""

import json
from fnmatch import fnmatchcase

import every_kind
import pytest

from kneecore import FileFormatError
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
    *("knee need", "knee repair", "knee exact", "response", "paper"),
]
NOT_DERIVABLE = {
    "what was asked for": (
        *("baseline.rest_length_bound_*", "model.size", "model.inputs.*", "model.outputs.*"),
        *("search.options.*", "seeds.*", "bound_mm.*", "size.*", "largest_mm", "tolerance_mm"),
    ),
    "what the clock said": ("seconds.*",),
    "what only the model can tell": (
        *("tension_n.*", "contact_force_n.*", "indentation_mm.*", "ap_position_mm.*"),
        *("tibia_position_mm.*", "ligament_rest_length_mm.*", "load_free_position_mm.*"),
        *("flexion_deg.*", "y.*", "objective_model.*", "pair.*", "extremes.*"),
        *("least_angle_deg.*", "largest_angle_deg*", "sampled_largest_angle_deg", "tried.*"),
    ),
    "what became of each run, which is not kept": (
        *("counts.*", "n_failed*", "n_refined", "n_unsettled", "n_lost", "n_test", "n_sampled"),
        *("repair.models_failed", "evidence.models_*"),
    ),
    "what comes from samples that are not kept": (
        *("*bounds_997*.percentile.*", "first_order.*", "total_order.*", "interval_95.*"),
        *("groups_first_order.*", "excess.*", "excess_share.*"),
    ),
    "what the surrogate's fit or search gave": (
        *("training.loo_rms*", "training.flexion_deg.*", "training.y.*", "loo_rms.*"),
        *("predicted_flexion_deg.*", "rms_error*", "pairs.objective_*", "search.run_values.*"),
        *("search.history.*", "evidence.second_best", "evidence.objective_at_rest"),
        "evidence.patterns.*",
    ),
}
"""Numbers that do not follow from the rest of a file, by why."""


def _name(path):
    return ".".join("*" if isinstance(key, int) else key for key in path)


def _listed(name):
    return any(fnmatchcase(name, p) for row in NOT_DERIVABLE.values() for p in row)


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
    passed = []
    for path in every_kind.numbers_of(document):
        changed = every_kind.altered(document, path, _value(document, path) * 1.37 + 3)
        why = _refused(changed)
        if why is None:
            passed.append(_name(path))
        assert "\n" not in (why or "")
    assert [name for name in passed if not _listed(name)] == []


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
