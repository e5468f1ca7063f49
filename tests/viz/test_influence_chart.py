"""Bars and heat map: sorted, complete, and to scale."""

import re

import numpy as np
import pytest
from searches import searched

import kneecore
from kneecore import MOMENT, ParameterSpace
from kneeviz.views import theme
from kneeviz.views.html import influence
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.pieces import escape, number


@pytest.fixture(scope="module")
def found():
    return kneecore.influence(kneecore.Knee(), kneecore.InfluenceSettings(n_base=128, seed=2))


@pytest.fixture(scope="module")
def labels(found):
    return [escape(parameter_label(name)) for name in found.names]


def places(svg, labels):
    """Where each name stands in the drawing, from the top."""
    tops = {}
    for y, text in re.findall(r'<text x="112.0" y="([\d.]+)"[^>]*>([^<]+)</text>', svg):
        tops[text] = float(y)
    assert set(tops) == set(labels)
    return tops


@pytest.mark.parametrize("load", [0, 5, 11])
def test_bars_are_sorted_by_the_total_index(found, labels, load):
    tops = places(influence.bars(found, load, theme.LIGHT), labels)
    shown = sorted(labels, key=tops.__getitem__)
    order = np.argsort(-found.indices.total_order[load], kind="stable")
    assert shown == [labels[k] for k in order]


def test_a_bar_is_as_long_as_its_index(found, labels):
    svg = influence.bars(found, 5, theme.LIGHT)
    largest = int(np.argmax(found.indices.total_order[5]))
    group = svg[svg.index(f"<title>{labels[largest]}:") :]
    pale, solid = (float(w) for w in re.findall(r'<rect[^>]* width="([\d.]+)"', group)[:2])
    total, first = (i[5, largest] for i in (found.indices.total_order, found.indices.first_order))
    assert solid / pale == pytest.approx(min(first, total) / total, abs=0.01)
    ends = [float(x) for x in re.findall(r'd="M([\d.]+) [\d.]+H([\d.]+)', group)[0]]
    low, high = found.indices.total_order_interval[:, 5, largest]
    assert (ends[1] - ends[0]) / pale == pytest.approx((high - low) / total, rel=0.02)


def test_the_heat_map_has_every_load_and_parameter(found, labels):
    svg = influence.heat_map(found, 5, theme.DARK)
    places(svg, labels)
    for k, label in enumerate(labels):
        for load in range(12):
            told = f"{label} at {MOMENT[load]:+g} N·m: "
            told += f"{100.0 * found.indices.total_order[load, k]:.1f} %"
            assert f"<title>{told}</title>" in svg


def test_groups_and_interactions_make_a_whole(found):
    text = influence.groups(found, 5, theme.LIGHT)
    shares = [int(n) for n in re.findall(r"([\d]+) %</span>", text)]
    assert sum(shares[:-1]) + shares[-1] == pytest.approx(100, abs=4)
    first = max(found.groups, key=lambda name: found.groups[name][5])
    assert text.index(f"</span>{first} ") == min(
        text.index(f"</span>{n} ") for n in ("condyle", "plateau", "material")
    )


def test_the_worst_cases_slopes_are_sorted_and_signed():
    result = searched(pop_size=20, n_generations=10)
    slopes = kneecore.worst_case_slopes(result)
    svg = influence.slopes(slopes, 5, theme.LIGHT)
    names = [escape(parameter_label(n)) for n in slopes.names]
    tops = places(svg, names)
    order = np.argsort(-np.abs(slopes.slopes[:, 5]).sum(axis=0), kind="stable")
    assert sorted(names, key=tops.__getitem__) == [names[k] for k in order]
    value = number(float(slopes.slopes[0, 5, order[0]]), 2, "°")
    assert f"<title>{names[order[0]]}: model 1 {value}" in svg


def test_an_angle_that_does_not_vary_is_told():
    names = dict.fromkeys(kneecore.NAMES, 0.0) | {"mcl_tibia_y": 1e-6}
    found = kneecore.influence(
        kneecore.Knee(ParameterSpace(half_ranges=names)),
        kneecore.InfluenceSettings(n_base=16, intervals=False),
    )
    assert found.indices.constant[5]
    assert "does not vary" in influence.bars(found, 5, theme.LIGHT)
    assert "does not vary" in influence.heat_map(found, 5, theme.LIGHT)
