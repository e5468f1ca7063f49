"""What changes over a moment: where it begins, how it ends, and that it then rests."""

import numpy as np
import pytest

from kneeviz.page.animation import Animation

START, TARGET = np.array([0.0, 2.0]), np.array([1.0, 0.0])


@pytest.fixture
def animation():
    return Animation()


def test_nothing_runs_at_first(animation):
    assert not animation.running
    assert animation.morph(TARGET, 1.0) is None
    assert animation.fade(1.0) is None
    assert animation.glide(1.0) is None


def test_a_morph_eases_from_one_knee_to_the_other(animation):
    animation.start_morph(START, 10.0)
    assert animation.morphing
    x, final = animation.morph(TARGET, 10.0)
    np.testing.assert_array_equal(x, START)
    assert not final
    x, final = animation.morph(TARGET, 10.175)
    np.testing.assert_allclose(x, 0.5 * (START + TARGET))
    assert not final
    x, final = animation.morph(TARGET, 20.0)
    np.testing.assert_array_equal(x, TARGET)
    assert final
    assert not animation.running


def test_a_morph_follows_a_target_that_moves_and_can_be_stopped(animation):
    animation.start_morph(START, 0.0)
    x, _ = animation.morph(2.0 * TARGET, 0.175)
    np.testing.assert_allclose(x, 0.5 * START + TARGET)
    animation.stop_morph()
    assert animation.morph(TARGET, 0.2) is None
    assert not animation.running


def test_a_fade_goes_evenly_from_nothing_to_all(animation):
    animation.start_fade(5.0)
    assert animation.fading
    assert [animation.fade(t) for t in (5.0, 5.3, 5.7)] == pytest.approx([0.0, 0.5, 1.0])
    assert not animation.running


def test_a_glide_ends_where_it_was_sent_or_where_it_is_stopped(animation):
    animation.start_glide(0.2, 0.8, 0.0)
    assert animation.running
    places = [animation.glide(t) for t in (0.0, 0.3, 0.6, 1.2)]
    assert places == pytest.approx([0.2, 0.2 + 0.6 * 0.15625, 0.5, 0.8])
    assert not animation.running
    animation.start_glide(0.8, 0.0, 2.0)
    animation.stop_glide()
    assert animation.glide(2.1) is None
