"""The charts' data, without a server behind them."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import kneecore
from kneeviz.geometry.sweep import sweep_of
from kneeviz.state.origin import Origin
from kneeviz.state.shown import Band, Markers, Shown
from kneeviz.views import theme
from kneeviz.views.charts.curves import CurveChart
from kneeviz.views.html import readout

X = kneecore.packaged_knee().baseline
NO_POSES = Markers(poses=(None, None, None))


@pytest.fixture(scope="module")
def response():
    return kneecore.simulate(X)


@pytest.fixture
def chart():
    gui = SimpleNamespace(add_uplot=lambda **properties: SimpleNamespace(**properties))
    return CurveChart(gui, theme.LIGHT, height=400)


def shown(response, band):
    sweep = sweep_of(X, response)
    return Shown(
        sweeps=(sweep, sweep, None, None),
        flexion=response.flexion,
        predicted=None,
        training=None,
        strain_free=True,
        band=band,
    )


def band_around(response, width):
    angles = np.degrees(response.flexion)
    return Band(
        lower_deg=angles - width, upper_deg=angles + width, text="2,000 samples", origin=Origin()
    )


def filled_series(chart, colour):
    """The (upper, lower) series between which the chart fills with a colour."""
    found = [b["series"] for b in chart.handle.bands if b["fill"] == colour]
    assert len(found) == 1
    return found[0]


def test_the_band_is_filled_between_its_edges_at_every_load(chart, response):
    chart.update(shown(response, band_around(response, 5.0)), NO_POSES)
    axis = chart.handle.data[0]
    upper, lower = (chart.handle.data[i] for i in filled_series(chart, theme.LIGHT.band))
    loads = np.searchsorted(axis, kneecore.MOMENT)
    np.testing.assert_array_equal(axis[loads], kneecore.MOMENT)
    angles = np.degrees(response.flexion)
    np.testing.assert_allclose(upper[loads], angles + 5.0, atol=1e-9)
    np.testing.assert_allclose(lower[loads], angles - 5.0, atol=1e-9)
    unloaded = np.searchsorted(axis, 0.0)
    assert upper[unloaded] == lower[unloaded] == pytest.approx(54.79)


def test_without_a_band_nothing_is_drawn_and_the_chart_keeps_its_series(chart, response):
    chart.update(shown(response, band_around(response, 5.0)), NO_POSES)
    n_series = len(chart.handle.data)
    chart.update(shown(response, None), NO_POSES)
    assert len(chart.handle.data) == n_series == len(chart.handle.series)
    for i in filled_series(chart, theme.LIGHT.band):
        assert np.isnan(chart.handle.data[i]).all()


def test_the_chart_widens_for_a_wide_band(chart, response):
    chart.update(shown(response, band_around(response, 60.0)), NO_POSES)
    low, high = chart.handle.scales["y"]["range"]
    assert low <= np.degrees(response.flexion).min() - 60.0
    assert high >= np.degrees(response.flexion).max() + 60.0
    # The shade over over-extension reaches the new edge.
    edge, _ = sorted(filled_series(chart, theme.LIGHT.beyond))
    assert (chart.handle.data[edge] == low).all()


def test_a_legends_entries_are_keys_of_the_curves_and_what_is_told_has_a_unit(chart, response):
    chart.update(shown(response, None), NO_POSES)
    legend = readout.legend(theme.LIGHT, overlays=True, curve=True, band="2,000", ghosts=True)
    entries = set(re.findall(r'data-curve="(\w+)"', legend))
    keys = {series.get("key") for series in chart.handle.series} - {None}
    assert entries - {"training"} == keys  # there is no surrogate here
    told = [series for series in chart.handle.series if "unit" in series]
    assert {series["key"] for series in told[1:]} == keys
    assert all(series["label"] for series in told)
    assert (told[0]["label"], told[0]["unit"]) == ("External moment", "N·m")


def test_earlier_knees_have_curves_of_their_own(chart, response):
    sweep = sweep_of(X, response)
    chart.update(replace(shown(response, None), ghosts=(sweep,)), NO_POSES)
    lines = [
        line
        for line, series in zip(chart.handle.data, chart.handle.series, strict=True)
        if series.get("key") == "ghosts"
    ]
    assert [bool(np.isfinite(line).any()) for line in lines] == [True, False, False]


def test_the_theme_paints_the_band(chart):
    chart.repaint(theme.DARK)
    filled_series(chart, theme.DARK.band)
