"""The methods' convergence plot: its drawing, and the button over the wire."""

import re

import numpy as np
import pytest
from viz.conftest import eventually
from viz.test_over_the_wire import press, widget

from kneecore import ParameterSpace
from kneecore.search.compare import MethodTrace, compare_methods
from kneeviz.actions import methods as do_methods
from kneeviz.views import theme
from kneeviz.views.html import methods as methods_chart


@pytest.fixture(scope="module")
def found():
    return compare_methods(ParameterSpace(), solver="equilibrium", threads=1)


def dots(svg):
    return {
        hue: (float(x), float(y))
        for x, y, hue in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="4" fill="(.*?)"', svg)
    }


def test_the_higher_f_is_drawn_higher_and_more_models_to_the_right(found):
    ends = dots(methods_chart.plot(found, theme.LIGHT))
    hues = {"ga": theme.LIGHT.genetic, "exact": theme.LIGHT.exact}
    ga, exact = (ends[hues[name]] for name in ("ga", "exact"))
    assert exact[1] < ga[1]  # y points down
    assert exact[0] < ga[0]
    assert ends[theme.LIGHT.surrogate][0] < exact[0]


def test_the_axes_hold_every_point_and_name_their_units(found):
    svg = methods_chart.plot(found, theme.LIGHT)
    for x, y in dots(svg).values():
        assert 40 <= x <= 354
        assert 8 <= y <= 166
    assert "True models run (log scale)" in svg
    assert "Best f (deg)" in svg
    assert ">10,000<" in svg


def test_the_table_never_has_the_surrogates_f_without_the_truth(found):
    table = methods_chart.table(found, theme.LIGHT)
    surrogate = found["ga_surrogate"].result
    assert f"{surrogate.objective_surrogate:.1f}" not in table
    assert f"{surrogate.objective_model:.1f}" in table
    told = methods_chart.promises(found)
    assert f"{surrogate.objective_surrogate:.1f}" in told
    assert f"{surrogate.objective_model:.1f}" in told


def test_a_method_without_an_answer_has_a_dash_and_no_line(found):
    nothing = MethodTrace(
        n_models=np.empty(0), objective=np.empty(0), result=found["ga_surrogate"].result
    )
    broken = {**found, "ga_surrogate": nothing}
    assert theme.LIGHT.surrogate not in dots(methods_chart.plot(broken, theme.LIGHT))
    assert "\u2013" in methods_chart.table(broken, theme.LIGHT)
    assert "Genetic, surrogate" not in methods_chart.promises(broken)
    assert methods_chart.plot({"ga_surrogate": nothing}, theme.LIGHT) == ""


def test_a_single_f_has_an_axis_too(found):
    svg = methods_chart.plot({"ga_surrogate": found["ga_surrogate"]}, theme.LIGHT)
    (x, y), *_ = dots(svg).values()
    assert np.isfinite([x, y]).all()


def test_the_button_compares_and_greys_with_the_bounds(session, visitor, found):
    eventually(lambda: session.exact_ready)
    tab, content = session.view.methods, widget(session.view.methods.content)
    visitor.set(widget(session.view.search.solver), "At rest")
    eventually(lambda: session.view.search.solver.value == "At rest")
    press(visitor, tab.run)
    visitor.wait(lambda c: "exact gradients" in (c.props[content].get("content") or ""))
    assert session.methods.found["exact"].objective[-1] == found["exact"].objective[-1]
    visitor.set(widget(session.view.knee.bounds["geometry_mm"]), 0.9)
    visitor.wait(lambda c: "Bounds changed" in c.props[content]["content"])
    visitor.set(widget(session.view.knee.bounds["geometry_mm"]), 1.0)
    visitor.wait(lambda c: "Bounds changed" not in c.props[content]["content"])
    visitor.set(widget(session.view.search.solver), "In motion")
    eventually(lambda: session.view.search.solver.value == "In motion")


def test_a_comparison_is_cancelled(session, visitor, monkeypatch):
    def endless(*_, callback, **__):
        from kneecore.progress import Progress

        while not callback(Progress(stage="search", done=1, total=4)):
            pass

    monkeypatch.setattr(do_methods, "compare_methods", endless)
    eventually(lambda: session.exact_ready)
    before = session.methods.found
    tab = session.view.methods
    press(visitor, tab.run)
    visitor.wait(lambda c: c.props[widget(tab.cancel)]["visible"])
    eventually(lambda: tab.progress.value == pytest.approx(25.0))
    press(visitor, tab.cancel)
    eventually(lambda: session.methods.job is None)
    status = widget(session.view.transport.status)
    visitor.wait(lambda c: "cancelled" in c.props[status]["content"])
    assert session.methods.found is before
