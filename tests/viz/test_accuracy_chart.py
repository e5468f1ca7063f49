"""The bars of the needed accuracy: each measurement once, to scale, the tightest first."""

import re

import numpy as np
import pytest

import kneecore
from kneecore import AccuracyAllocationSettings, Knee
from kneeviz.views import theme
from kneeviz.views.html import accuracy
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.pieces import escape


def allocated(**settings):
    return kneecore.accuracy_allocation(
        Knee(solver="equilibrium"), AccuracyAllocationSettings(tolerance=0.1, **settings)
    )


@pytest.fixture(scope="module")
def found():
    return allocated()


def test_the_tightest_comes_first(found):
    names = re.findall(r"<title>([^:]+):", accuracy.bars(found, theme.LIGHT))
    order = np.argsort(found.factors, kind="stable")
    assert names == [escape(parameter_label(found.names[k])) for k in order]
    assert names[0] == "Condyle centre"


def test_bars_are_as_long_as_the_shares(found):
    svg = accuracy.bars(found, theme.LIGHT)
    for group in re.findall(r"<g>.*?</g>", svg):
        name = re.search(r"<title>([^:]+):", group)[1]
        k = [escape(parameter_label(n)) for n in found.names].index(name)
        stated, cheapest, equal = (float(w) for w in re.findall(r'width="([\d.]+)"', group))
        assert cheapest / stated == pytest.approx(found.factors[k], abs=1e-3)
        assert equal / stated == pytest.approx(found.equal_factors[k], abs=1e-3)
        assert ("as stated" in group) == found.as_stated[k]
        unit = {"mm": " mm", "deg": "°", "%": " %"}[found.units[k]]
        assert re.search(rf">±\u202f[\d.]+{unit}</text>", group)


def test_words_stand_above_and_below(found):
    told = accuracy.tolerances(found, theme.DARK)
    assert "the tightest Condyle centre to within" in told
    assert "2,000 random knees" in told


def test_where_nothing_is_enough_there_are_words_only():
    never = allocated(within=-10.0)
    told = accuracy.tolerances(never, theme.LIGHT)
    assert "even if all is known exactly" in told
    assert "<svg" not in told
