"""The methods' convergence plot: its drawing, and the button over a WebSocket."""

import re
from dataclasses import replace

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, widget

import kneecore
from kneecore import Knee, compare_methods
from kneeviz.views import theme
from kneeviz.views.html import methods


@pytest.fixture(scope="module")
def found():
    return compare_methods(Knee(solver="equilibrium", threads=1))


def by_name(traces):
    return {trace.method: trace for trace in traces}


def dots(svg):
    return {
        hue: (float(x), float(y))
        for x, y, hue in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="4" fill="(.*?)"', svg)
    }


def test_the_higher_f_is_drawn_higher_and_more_models_to_the_right(found):
    ends = dots(methods.plot(found, theme.LIGHT))
    hues = {"ga": theme.LIGHT.genetic, "exact": theme.LIGHT.exact}
    ga, exact = (ends[hues[name]] for name in ("ga", "exact"))
    assert exact[1] < ga[1]  # y points down
    assert exact[0] < ga[0]
    assert ends[theme.LIGHT.surrogate][0] < exact[0]


def test_the_axes_hold_every_point_and_name_their_units(found):
    svg = methods.plot(found, theme.LIGHT)
    for x, y in dots(svg).values():
        assert 40 <= x <= 354
        assert 8 <= y <= 166
    assert "True models run (log scale)" in svg
    assert "Best f (°)" in svg
    assert ">10,000<" in svg


def test_every_better_pair_tells_its_numbers_to_a_pointer(found):
    svg = methods.plot(found, theme.LIGHT)
    assert svg.count("<title>") == sum(len(trace.objective) for trace in found)
    last = by_name(found)["exact"]
    words = f"f {last.objective[-1]:.1f}° after {round(float(last.n_models[-1])):,} models"
    assert f"<title>exact gradients: {words}</title>" in svg


def test_the_table_never_has_the_surrogates_f_without_the_truth(found):
    table = methods.table(found, theme.LIGHT)
    surrogate = by_name(found)["ga_surrogate"]
    assert f"{surrogate.promised:.1f}" not in table
    assert f"{surrogate.objective[-1]:.1f}" in table
    told = methods.promises(found)
    assert f"{surrogate.promised:.1f}" in told
    assert f"{surrogate.objective[-1]:.1f}" in told


def test_a_method_without_an_answer_has_a_dash_and_no_line(found):
    nothing = replace(by_name(found)["ga_surrogate"], n_models=(), objective=())
    broken = [nothing, *(t for t in found if t.method != "ga_surrogate")]
    assert theme.LIGHT.surrogate not in dots(methods.plot(broken, theme.LIGHT))
    assert "\u2013" in methods.table(broken, theme.LIGHT)
    assert "Genetic, surrogate" not in methods.promises(broken)
    assert methods.plot([nothing], theme.LIGHT) == ""


def test_a_single_f_has_an_axis_too(found):
    svg = methods.plot([by_name(found)["ga_surrogate"]], theme.LIGHT)
    (x, y), *_ = dots(svg).values()
    assert np.isfinite([x, y]).all()


def test_the_button_compares_and_greys_with_the_bounds(page, visitor, found):
    eventually(lambda: page.exact_ready)
    tab, content = page.view.methods, widget(page.view.methods.content)
    visitor.set(widget(page.view.search.solver), "At rest")
    eventually(lambda: page.view.search.solver.value == "At rest")
    press(visitor, tab.run)
    visitor.wait(lambda c: "exact gradients" in (c.props[content].get("content") or ""))
    assert (
        by_name(page.methods.found.methods)["exact"].objective == by_name(found)["exact"].objective
    )
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 0.9)
    visitor.wait(lambda c: "Bounds changed" in c.props[content]["content"])
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 1.0)
    visitor.wait(lambda c: "Bounds changed" not in c.props[content]["content"])
    visitor.set(widget(page.view.search.solver), "In motion")
    eventually(lambda: page.view.search.solver.value == "In motion")


def test_a_comparison_is_cancelled(page, visitor, monkeypatch):
    def endless(*_, callback, **__):
        from kneecore.progress import Progress

        while not callback(Progress(stage="search", done=1, total=4)):
            pass

    monkeypatch.setattr(kneecore, "compare_methods", endless)
    eventually(lambda: page.exact_ready)
    before = page.methods.found
    tab = page.view.methods
    press(visitor, tab.run)
    visitor.wait(lambda c: c.props[widget(tab.cancel)]["visible"])
    eventually(lambda: tab.progress.value == pytest.approx(25.0))
    press(visitor, tab.cancel)
    eventually(lambda: page.methods.job is None)
    status = widget(page.view.transport.status)
    visitor.wait(lambda c: "cancelled" in c.props[status]["content"])
    assert page.methods.found is before
