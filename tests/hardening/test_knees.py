"""The row of the knees, in its short form, and that it sees what it looks for."""

from dataclasses import replace

import numpy as np
import pytest
from hardening.rows import Scale
from hardening.rows_knees import differing, drawn, faults, knees

from kneecore import simulate_batch


def test_knees_at_one_three_and_ten_times_the_bounds_are_sound():
    outcome = knees(Scale(seconds=1.0, share=0.01))
    assert outcome.sound, outcome.happened
    assert outcome.injected.startswith("999 knees")
    assert " 0 failed" not in outcome.happened
    assert " 0 implausible" not in outcome.happened


@pytest.fixture(scope="module")
def batch():
    return simulate_batch(drawn(10.0, 200, 3))


@pytest.mark.parametrize(
    ("field", "value", "fault"),
    [
        ("flexion", np.nan, "unmarked NaN"),
        ("tension", np.inf, "unmarked NaN"),
        ("implausible", True, "implausible, unmarked"),
        ("flexion", np.radians(171.0), "implausible, unmarked"),
    ],
)
def test_a_knee_that_is_not_marked_is_seen(batch, field, value, fault):
    x = drawn(10.0, 200, 3)
    good = int(np.flatnonzero((batch.refinements >= 0) & ~batch.implausible.any(axis=1))[0])
    spoilt = np.array(getattr(batch, field))
    spoilt[good, 4] = value
    assert not any(faults(batch, x).values())
    assert faults(replace(batch, **{field: spoilt}), x)[fault] == 1


def test_a_failed_knee_that_counts_as_one_at_rest_is_seen(batch):
    x = drawn(10.0, 200, 3)
    failed = np.flatnonzero(batch.failed)
    rests = np.array(batch.at_rest)
    rests[failed[0], 0] = True
    assert faults(replace(batch, at_rest=rests), x)["failed, at rest"] == 1


def test_one_bit_is_seen(batch):
    flexion = np.array(batch.flexion)
    good = int(np.flatnonzero(batch.refinements >= 0)[0])
    flexion[good, 0] = np.nextafter(flexion[good, 0], 10.0)
    assert differing(batch, replace(batch, flexion=flexion)) == 1
    assert differing(batch, batch) == 0
