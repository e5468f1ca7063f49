"""The search tab is made from the settings' fields: none is forgotten, none is said twice."""

from dataclasses import dataclass, replace
from typing import Literal

import pytest
import viser

from kneecore import Knee, SearchSettings
from kneecore.options import option, options_of
from kneeviz.views.tabs.options import OptionWidgets
from kneeviz.views.tabs.search import LOOKS, NOT_HERE, SearchTab

ON_THE_PAGE = [one for one in options_of(SearchSettings) if one.name not in NOT_HERE]
OTHER = {
    "method": "Exact gradients", "thorough": True, "bound": True, "repair": True, "pop_size": 120,
    "n_generations": 31, "objective": "flexion", "seed": 7,
}  # fmt: skip
"""What a visitor may set instead of what is usual."""


@pytest.fixture(scope="module")
def gui():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.gui
    server.stop()


@pytest.fixture
def tab(gui):
    return SearchTab(gui, lambda *_: None)


def test_every_option_has_a_widget_or_a_reason(page):
    names = {one.name for one in options_of(SearchSettings)}
    shown = set(page.view.search.options.handles)
    assert shown | set(NOT_HERE) == names
    assert not shown & set(NOT_HERE)
    assert set(LOOKS) <= shown
    assert all(len(reason) > 10 for reason in NOT_HERE.values())


def test_a_widget_says_what_the_option_says(page):
    handles = page.view.search.options.handles
    for one in options_of(SearchSettings):
        if one.name in handles:
            assert handles[one.name].hint == one.help


def test_what_is_not_touched_is_the_settings_default(page):
    knee = Knee(threads=1)
    settings = page.view.search.settings(knee, "surrogate")
    assert settings.of(knee) == SearchSettings(search_space="surrogate").of(knee)


@pytest.mark.parametrize("one", ON_THE_PAGE, ids=lambda one: one.name)
def test_a_widget_is_of_its_option_s_kind_and_at_its_default(tab, one):
    handle = tab.options.handles[one.name]
    usual = SearchSettings().of(Knee())
    assert tab.options.value(one.name) == getattr(usual, one.name)
    kind = viser.GuiNumberHandle
    if one.choices or one.name == "objective":
        kind = viser.GuiDropdownHandle
    elif isinstance(one.default, bool) or one.open_flag:
        kind = viser.GuiCheckboxHandle
    assert isinstance(handle, kind)
    if one.choices:
        assert len(handle.options) == len(one.choices)


@pytest.mark.parametrize("one", ON_THE_PAGE, ids=lambda one: one.name)
def test_what_is_set_on_the_page_reaches_the_search(tab, one):
    if one.name in ("thorough", "bound"):  # the exact search's alone
        tab.options.handles["method"].value = OTHER["method"]
    where = "surrogate" if one.name == "repair" else "model"
    before = tab.settings(Knee(), where)
    tab.options.handles[one.name].value = OTHER[one.name]
    wanted = {"method": "exact"}.get(one.name, OTHER[one.name])
    assert getattr(before, one.name) != wanted
    assert tab.settings(Knee(), where) == replace(before, **{one.name: wanted})


def test_what_a_search_has_none_of_is_left_out_and_shut(tab):
    handles = tab.options.handles
    assert [n for n, h in handles.items() if h.disabled] == [
        "thorough",
        "bound",
    ]  # untouched: genetic
    for name, value in OTHER.items():
        handles[name].value = value
    tab.show_method()
    assert [n for n, h in handles.items() if h.disabled] == ["pop_size", "n_generations"]
    exact = SearchSettings(method="exact", search_space="model", objective="flexion", seed=7)
    knee = Knee()
    wanted = replace(exact, thorough=True, bound=True).of(knee)
    assert tab.settings(knee, "model").of(knee) == wanted
    repaired = replace(exact, search_space="surrogate", repair=True).of(knee)
    assert tab.settings(knee, "surrogate").of(knee) == repaired
    handles["method"].value = "Genetic"
    tab.show_method()
    assert [n for n, h in handles.items() if h.disabled] == ["thorough", "bound"]
    genetic = tab.settings(Knee(), "model")
    assert (genetic.pop_size, genetic.n_generations) == (120, 31)
    assert (genetic.thorough, genetic.bound) == (False, False)


@dataclass(frozen=True, kw_only=True)
class More(SearchSettings):
    patience: int = option(7)
    """How long to wait."""
    mood: Literal["calm", "bold"] = option("calm", key="temper")
    """How far steps go."""


def test_an_option_that_is_added_is_on_the_page(gui):
    widgets = OptionWidgets(gui, More, without=NOT_HERE, looks=LOOKS)
    patience, mood = widgets.handles["patience"], widgets.handles["mood"]
    assert (patience.label, mood.label) == ("Patience", "Temper")
    assert (patience.hint, mood.hint) == ("How long to wait.", "How far steps go.")
    assert mood.options == ("calm", "bold")
    assert widgets.value("patience") == 7
    patience.value, mood.value = 9, "bold"
    assert widgets.values()["patience"] == 9
    assert widgets.value("mood") == "bold"
