"""Points of the unit cube."""

import numpy as np
import pytest

from kneecore.errors import ParameterError
from kneecore.numerics.sampling import batches, n_drawn, uniform


def drawn(n, d, seed=0, sampling="uniform", size=64):
    return np.vstack(list(batches(n, d, seed, sampling=sampling, size=size)))


@pytest.mark.parametrize("sampling", ["uniform", "latin-hypercube", "sobol"])
def test_batch_size_changes_no_bit_and_seeds_do(sampling):
    whole = drawn(200, 5, sampling=sampling, size=1000)
    assert whole.shape == (n_drawn(200, sampling), 5)
    assert whole.min() >= 0.0
    assert whole.max() < 1.0
    for size in (1, 16, 37):
        assert drawn(200, 5, sampling=sampling, size=size).tobytes() == whole.tobytes()
    assert not np.isin(drawn(200, 5, seed=1, sampling=sampling), whole).any()


def test_uniform_points_are_those_of_the_search():
    np.testing.assert_array_equal(drawn(50, 28, seed=3), uniform(50, 28, 3))


def test_a_latin_hypercube_has_one_point_a_slice():
    points = drawn(100, 4, sampling="latin-hypercube")
    for k in range(4):
        np.testing.assert_array_equal(np.sort((100 * points[:, k]).astype(int)), np.arange(100))


def test_sobol_rounds_up_to_a_power_of_two_and_is_even():
    assert [n_drawn(n, "sobol") for n in (1, 2, 3, 1000, 1024)] == [1, 2, 4, 1024, 1024]
    points = drawn(1000, 3, sampling="sobol")
    counts, _ = np.histogram(points[:, 0], bins=16, range=(0.0, 1.0))
    np.testing.assert_array_equal(counts, 64)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"n_samples": 0}, "`n_samples` is 0"),
        ({"sampling": "grid"}, "`sampling` is 'grid'; uniform, latin-hypercube, sobol are allowed"),
        ({"seed": -1}, "`seed` is -1"),
    ],
)
def test_what_is_not_allowed_is_named(arguments, said):
    options = {"n_samples": 10, "n_dimensions": 2, "seed": 0, "size": 5} | arguments
    with pytest.raises(ParameterError, match=said):
        list(batches(**options))
