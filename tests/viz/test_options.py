"""The search tab is made from the settings' fields: none is forgotten, none is said twice."""

from dataclasses import dataclass

import viser

from kneecore import Knee, SearchSettings
from kneecore.options import option, options_of
from kneeviz.views.tabs.options import OptionWidgets
from kneeviz.views.tabs.search import LOOKS, NOT_HERE


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
    assert settings == SearchSettings(search_space="surrogate")


def test_an_option_that_is_added_is_on_the_page():
    @dataclass(frozen=True, kw_only=True)
    class More(SearchSettings):
        patience: int = option(7)
        """How long to wait."""

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        widgets = OptionWidgets(server.gui, More, without=NOT_HERE, looks=LOOKS)
        assert widgets.handles["patience"].label == "Patience"
        assert widgets.value("patience") == 7
        widgets.handles["patience"].value = 9
        assert widgets.values()["patience"] == 9
    finally:
        server.stop()
