"""The rule for hot and wild runs: by made-up runs, and by pre-stressed knees that need it."""

import naive
import numpy as np
import pytest

from kneecore import Knee, ModelError, ParameterSpace, simulate, trajectory
from kneecore.knee.physics import dynamics
from kneecore.knee.physics.dynamics import SAME_ANGLE, Trial, accepted
from kneecore.knee.response import prepare


def corner_knee(index, bounds=1.0):
    """A knee on a corner of the bounds; the interesting ones were looked for once."""
    space = ParameterSpace(
        geometry_bound_mm=bounds, slope_bound_deg=bounds, material_bound_percent=10 * bounds
    )
    return space.from_unit(np.round(np.random.default_rng(7).random((index + 1, 28)))[index])


def made_up(turn=0.0, *, hot=False, settled=True, wild=False):
    """One run whose last plateau is as asked; the others are calm, settled and at 0."""
    poses = np.zeros((1, 6, 3))
    poses[0, 5, 2] = turn
    marks = np.ones((2, 1, 6), dtype=bool)
    marks[0, 0, 5], marks[1] = settled, False
    marks[1, 0, 5] = hot
    return Trial(poses, marks[0], np.array([wild]), marks[1])


SAME, OTHER = 0.99 * SAME_ANGLE, 1.01 * SAME_ANGLE


@pytest.mark.parametrize(
    ("now", "before", "expected"),
    [
        (made_up(), None, True),
        (made_up(settled=False), None, True),  # unsettled is no failure
        (made_up(hot=True), None, False),  # nothing to compare with yet
        (made_up(wild=True), None, False),
        (made_up(), made_up(wild=True), True),
        (made_up(OTHER), made_up(hot=True), True),  # calm: whatever the one before it says
        (made_up(SAME, hot=True), made_up(hot=True), True),
        (made_up(OTHER, hot=True), made_up(hot=True), False),
        (made_up(-OTHER, hot=True), made_up(hot=True), False),
        (made_up(SAME, hot=True, settled=False), made_up(hot=True), False),
        (made_up(SAME, hot=True), made_up(wild=True), False),
        (made_up(SAME, hot=True, wild=True), made_up(hot=True), False),
        (made_up(np.nan, hot=True, wild=True), made_up(hot=True), False),
    ],
)
def test_who_is_accepted(now, before, expected):
    assert accepted(now, before).tolist() == [expected]


def test_a_calm_plateau_need_not_be_settled_for_a_hot_run_to_be_accepted():
    now = made_up(hot=True)
    now.settled[0, 0] = False
    assert accepted(now, made_up(hot=True)).all()


# (corner, bounds): hot in one run or in both, wild once, three halvings, wild twice, hot to the end
@pytest.mark.parametrize(
    ("index", "bounds", "halvings"),
    [(7, 1, 1), (26, 1, 2), (85, 3, 3), (8, 3, -1), (42, 3, -1)],
)
def test_pre_stressed_knees_against_the_naive_twin(index, bounds, halvings):
    x = corner_knee(index, bounds)
    fast, slow = simulate(x, rest_length="fixed"), naive.simulate(x, rest_length="fixed")
    assert fast.status == slow["status"]
    assert fast.refinements == halvings
    np.testing.assert_array_equal(fast.settled, slow["settled"])
    if halvings > 0:
        assert slow["n_refinements"] == halvings
    np.testing.assert_allclose(fast.flexion, slow["flexion"], atol=1e-8)


def test_wild_twice_is_given_up(monkeypatch):
    tried = []

    def counted(rows, runs, refinements, threads=None):
        tried.append((refinements, len(runs)))
        return attempt(rows, runs, refinements, threads)

    attempt = dynamics.attempt
    monkeypatch.setattr(dynamics, "attempt", counted)
    rows = prepare(corner_knee(8, 3), None, "fixed")
    poses, settled, halvings = dynamics.respond_by_run(rows)
    assert tried == [(0, 2), (1, 2)]
    assert halvings.tolist() == [[-1, -1]]
    assert np.isnan(poses).all()
    assert not settled.any()


@pytest.mark.parametrize(("rest_length", "most", "seed"), [("fixed", 1, 7), ("recomputed", 0, 0)])
def test_a_screening_gives_up_knees_that_need_more_halvings_and_alters_no_other(
    rest_length, most, seed
):
    space = ParameterSpace(geometry_bound_mm=3, slope_bound_deg=3, material_bound_percent=30)
    knee = Knee(space, rest_length=rest_length)
    x = space.from_unit(np.round(np.random.default_rng(seed).random((96, 28))))
    halvings = knee.simulate_batch(x).refinements
    whole, screened = knee.evaluate(x), knee.screening.evaluate(x)
    many = halvings > most
    assert (np.count_nonzero(many), np.count_nonzero(halvings == most)) > (0, 0)
    np.testing.assert_array_equal(screened[~many], whole[~many])
    assert np.isnan(screened[many]).all()
    assert np.isfinite(whole[many]).all()
    assert knee.screening.identity != knee.identity == Knee(space, rest_length=rest_length).identity


@pytest.mark.parametrize(("index", "halvings"), [(7, [0, 1]), (130, [1, 0]), (26, [1, 2])])
def test_a_refined_trajectory_ends_bit_by_bit_where_the_response_is_read(index, halvings):
    x = corner_knee(index)
    assert dynamics.respond_by_run(prepare(x, None, "fixed"))[2].tolist() == [halvings]
    response, motion = simulate(x, rest_length="fixed"), trajectory(x, rest_length="fixed")
    ends = np.searchsorted(motion.time, np.array([7.0, 11, 14, 17, 20, 23]) - 1e-9)
    assert motion.flexion[:, ends].tobytes() == response.flexion.tobytes()


def test_a_dislocated_knee_has_no_trajectory():
    with pytest.raises(ModelError, match="fails"):
        trajectory(corner_knee(8, 3), rest_length="fixed")
