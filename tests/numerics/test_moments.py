"""Statistics of a stream against NumPy's of all samples at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kneecore.numerics.moments import Stream


def streamed(samples, size, expected=None):
    stream = Stream(expected or len(samples))
    for first in range(0, len(samples), size):
        stream.add(samples[first : first + size])
    return stream


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 3000), st.integers(1, 700), st.integers(0, 1000))
def test_a_stream_agrees_with_numpy(n, size, seed):
    samples = np.random.default_rng(seed).normal(5.0, 2.0, (n, 2, 3))
    stream = streamed(samples, size, expected=n + seed)
    np.testing.assert_allclose(stream.mean, samples.mean(axis=0), rtol=1e-12)
    # Two samples may lie so close together that their spread is a difference of roundings.
    np.testing.assert_allclose(stream.sd, samples.std(axis=0, ddof=1), rtol=1e-10, atol=1e-13)
    expected = np.percentile(samples, [0.15, 99.85], axis=0)
    # A percentile may fall close to 0 between samples of size 5: their rounding is absolute.
    np.testing.assert_allclose(
        np.array(stream.percentile_bounds()), expected, rtol=1e-12, atol=1e-13
    )
    lower, upper = stream.sigma_bounds()
    np.testing.assert_allclose(upper - lower, 6.0 * stream.sd)


def test_only_the_tails_are_kept():
    stream = streamed(np.random.default_rng(0).normal(size=(20_000, 2)), 1000)
    assert len(stream._low) == len(stream._high) == 32


def test_a_large_offset_costs_no_digits():
    samples = 1e9 + np.random.default_rng(0).normal(size=(5000, 1))
    np.testing.assert_allclose(streamed(samples, 500).sd, samples.std(axis=0, ddof=1), rtol=1e-6)


def test_empty_batches_change_nothing():
    samples = np.arange(12.0).reshape(6, 2)
    stream = streamed(samples, 3)
    before = stream.mean.copy()
    stream.add(samples[:0])
    assert stream.n == 6
    assert stream.mean == pytest.approx(before)
