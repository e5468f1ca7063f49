"""The tab "Search" of a model: the worst pair, its settings, and what was found."""

from dataclasses import replace
from typing import Any

from kneecore import SearchSettings
from kneeviz.anymodel import work
from kneeviz.anymodel.state import ModelState
from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press, on_value
from kneeviz.views.tabs.options import Look, OptionWidgets

OFFERED = ("objective", "training_samples", "repair_models", "seed")
"""Options of the search that the page offers for a model; the rest are as the model has them."""


class SearchTab:
    """The search: a button, its progress, and what it found."""

    def __init__(self, gui: Any, post: Post, state: ModelState) -> None:
        self._usual = work.usual(state.model)
        gui.add_html(box("Which two models within the bounds differ most in their outputs?"))
        self.start = gui.add_button(
            "Worst case",
            hint="Runs the model where a surrogate of it promises most or errs most, until nothing "
            "better is in sight or the runs are used up.",
        )
        self.cost = gui.add_html("")
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.rising = gui.add_html("", visible=False)
        self.cancel = gui.add_button("Cancel the search", color="red", visible=False)
        self.found = gui.add_html("")
        self.overlay = gui.add_checkbox("Show both", True, visible=False)
        self.adopt = gui.add_button_group("Make mine", ("Model 1", "Model 2"), visible=False)
        self.table = gui.add_html("")
        with gui.add_folder("Settings", expand_by_default=False):
            self.options = self._add_options(gui, state)
        on_press(self.start, post, "search")
        on_press(self.cancel, post, "search_cancel")
        on_press(self.adopt, post, "adopt")
        on_value(self.overlay, post, "overlay")
        for name in ("training_samples", "repair_models"):
            if name in self.options.handles:
                on_value(self.options.handles[name], post, "costs")

    def _add_options(self, gui: Any, state: ModelState) -> OptionWidgets:
        repaired = self._usual.repair
        offered = OFFERED if repaired else tuple(n for n in OFFERED if n[:6] != "repair")
        hidden = [f for f in vars(self._usual) if f not in offered]
        looks = {
            "objective": Look(label="Counts", words={n: n for n in state.model.objectives}),
            "training_samples": Look(label="First runs", low=state.model.n_free + 1, high=100_000),
            "repair_models": Look(label="More runs", low=2, high=100_000),
            "seed": Look(label="Seed", low=0, high=2**31 - 1),
        }
        widgets = OptionWidgets(gui, SearchSettings, without=hidden, looks=looks)
        for name in ("training_samples", "repair_models"):
            if name in widgets.handles:
                widgets.handles[name].value = getattr(self._usual, name)
        return widgets

    @property
    def settings(self) -> SearchSettings:
        """What the visitor has set."""
        return replace(self._usual, **self.options.values())

    @property
    def n_runs(self) -> int:
        """The most runs that a search may take."""
        settings = self.settings
        return settings.training_samples + settings.repair_models * settings.repair

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the button, or the other way round."""
        self.start.disabled = running
        self.progress.visible = self.rising.visible = self.cancel.visible = running
        if running:
            self.progress.value = 0.0
            self.rising.content = ""
