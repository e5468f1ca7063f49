"""The worked examples: pages show the files, studies print what pages say, and it is right."""

import importlib
import itertools
import re
import shutil
import sys

import numpy as np
import pytest
from examples import (
    EXAMPLES,
    NAMES,
    blocks,
    differences,
    is_printed,
    number_after,
    page,
    pictures,
    said,
)
from matplotlib.image import imread

DOCS = EXAMPLES.parent
NEEDS_NOTHING = ("band_pass", "four_bar", "program")


@pytest.fixture
def imported(monkeypatch):
    """Return a function that imports a module of an example."""

    def load(name, module):
        monkeypatch.syspath_prepend(EXAMPLES / name)
        monkeypatch.delitem(sys.modules, module, raising=False)
        found = importlib.import_module(module)
        monkeypatch.setitem(sys.modules, module, found)
        return found

    return load


@pytest.fixture
def studied(tmp_path, run_study):
    """Return a function that runs an example in a copy: what it prints, and where it was."""

    def study(name):
        folder = tmp_path / name
        shutil.copytree(EXAMPLES / name, folder)
        for picture in folder.glob("*.png"):
            picture.unlink()
        return run_study(folder), folder

    return study


@pytest.mark.parametrize("name", NAMES)
def test_a_page_shows_what_is_in_the_files(name):
    for language, file, text in blocks(name):
        if not is_printed(language, file):
            assert text in (EXAMPLES / file).read_text(encoding="utf-8"), file
    for link in re.findall(r"\]\((?!http)([^)#]+)", page(name)):
        assert (EXAMPLES / link).exists(), link


def test_the_index_names_every_example():
    text = (DOCS / "examples.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"\]\(examples/(\w+)\.md\)", text)) == sorted(NAMES)


@pytest.mark.parametrize("name", NEEDS_NOTHING)
def test_a_study_prints_and_draws_what_its_page_says(name, studied):
    printed, folder = studied(name)
    assert differences(said(name), printed) == []
    for picture in pictures(name):
        shown, drawn = (imread(root / picture).shape for root in (EXAMPLES, folder.parent))
        np.testing.assert_allclose(shown, drawn, atol=2)


def test_a_difference_is_told():
    assert differences("f 12.34 mm", "f 12.35 mm") == []
    assert differences("f 12.34 mm", "f 12.54 mm") == ["12.34 is printed as 12.54"]
    assert differences("f 12.34 mm", "f 12.34 m")[0].startswith("other words")


def largest_f(y, weights=1.0):
    """Return the largest sum of differences of any two rows."""
    return max((weights * np.abs(y - row)).sum(axis=1).max() for row in y)


def grid_around(nominal, half, levels):
    return nominal + half * np.array(list(itertools.product(levels, repeat=len(nominal))))


# The band-pass.


def nodal_gain(x, frequency):
    """The same ladder by its nodes' voltages: source - L1 C1 - node - L3 C3 - load."""
    l1, c1, l2, c2, l3, c3 = x
    s = 2j * np.pi * frequency
    first, last = 1.0 / (50.0 + s * l1 + 1.0 / (s * c1)), 1.0 / (s * l3 + 1.0 / (s * c3))
    middle = s * c2 + 1.0 / (s * l2)
    node = np.array([[first + middle + last, -last], [-last, last + 1.0 / 50.0]])
    return 20.0 * np.log10(abs(2.0 * np.linalg.solve(node, [first, 0.0])[1]))


def test_the_filters_gain_by_nodes_and_in_closed_form(imported):
    filter_ = imported("band_pass", "band_pass")
    model = filter_.model()
    x = model.nominal * (1.0 + 0.05 * np.random.default_rng(0).uniform(-1.0, 1.0, (3, 6)))
    for point, gain in zip(x, filter_.gain_db(x), strict=True):
        slow = [nodal_gain(point, f) for f in filter_.FREQUENCY]
        np.testing.assert_allclose(gain, slow, rtol=0, atol=1e-9)
    turned = filter_.FREQUENCY / filter_.MIDDLE
    bent = (turned - 1.0 / turned) * filter_.MIDDLE / filter_.WIDTH
    butterworth = -10.0 * np.log10(1.0 + bent**6)
    np.testing.assert_allclose(filter_.gain_db(model.nominal[None])[0], butterworth, atol=1e-9)


def test_the_worst_filters_are_those_of_all_pairs_of_corners(imported):
    filter_ = imported("band_pass", "band_pass")
    nominal = filter_.model().nominal
    y = filter_.gain_db(grid_around(nominal, 0.05 * nominal, (-1, 1)))
    assert number_after("All frequencies: f", said("band_pass")) == pytest.approx(
        largest_f(y), abs=0.05
    )
    passed = (filter_.FREQUENCY > 8.5e3) & (filter_.FREQUENCY < 11.8e3)
    best = largest_f(y, passed)
    assert f"{best:.2f} dB of the best pair of corners" in page("band_pass")
    told = number_after("85 runs: f", said("band_pass"))
    assert 0.97 * best < told < best


# The linkage.


def test_the_linkage_keeps_its_lengths(imported):
    linkage = imported("four_bar", "four_bar")
    x = np.array([40.1, 99.9, 100.1, 79.9, 200.1, 0.1])
    a, b, point = linkage.pins(x, linkage.CRANK)
    for distance, length in (
        (np.hypot(*a.T), x[0]),
        (np.hypot(*(b - a).T), x[1]),
        (np.hypot(*(b - [x[3], 0.0]).T), x[2]),
        (np.hypot(*(point - a).T), np.hypot(x[4], x[5])),
    ):
        np.testing.assert_allclose(distance, length, rtol=1e-12)
    assert np.isnan(linkage.height(np.array([40.0, 10.0, 10.0, 80.0, 200.0, 0.0]))).all()


def test_the_worst_linkages_are_those_of_all_pairs_of_a_grid(imported):
    height = imported("four_bar", "four_bar").height
    nominal = np.array([40.0, 100.0, 100.0, 80.0, 200.0, 0.0])
    y = np.array([height(x) for x in grid_around(nominal, 0.1, (-1, 0, 1))])
    assert number_after("f", said("four_bar")) == pytest.approx(largest_f(y), abs=6e-4)


# The shaft.


def deflection(place, modulus, load, diameters):
    """By Castigliano: moments times lever, over the bending stiffness, segment by segment."""
    ends, total, at = np.cumsum([200.0, 150.0, 100.0]), 0.0, 0.0
    for end, diameter in zip(ends, diameters, strict=True):
        s = np.linspace(at, end, 2001)
        inner = load * (ends[-1] - s) * np.maximum(place - s, 0.0)
        total += np.trapezoid(inner, s) / (modulus * np.pi * diameter**4 / 64.0)
        at = end
    return total


def test_the_worst_shafts_are_those_of_all_pairs_of_corners(imported):
    shaft = imported("program", "shaft")
    nominal = np.array([206e3, 1000.0, 40.0, 32.0, 25.0])
    half = np.array([0.03 * 206e3, 50.0, 0.2, 0.2, 0.2])
    corners = grid_around(nominal, half, (-1, 1))
    y = np.array([[deflection(p, e, f, d) for p in (200.0, 350.0, 450.0)]
                  for e, f, *d in corners])  # fmt: skip
    assert number_after("f", said("program")) == pytest.approx(largest_f(y), abs=6e-4)
    e, f, *d = corners[5]
    moved = shaft.deflections(e, f, list(zip(d, (200.0, 150.0, 100.0), strict=True)))
    np.testing.assert_allclose([v for _, v in moved], y[5], rtol=1e-6)
