"""The tab "Search" of a model: the worst pair, its settings, and what was found."""

from dataclasses import replace
from typing import Any

from kneecore import SearchSettings
from kneecore.options import options_of
from kneeviz.anymodel import work
from kneeviz.anymodel.state import ModelState
from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press, on_value

_MOST_RUNS = 100_000


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
        self.left = gui.add_html("", visible=False)
        self.rising = gui.add_html("", visible=False)
        self.cancel = gui.add_button("Cancel the search", color="red", visible=False)
        self.found = gui.add_html("")
        self.overlay = gui.add_checkbox("Show both", True, visible=False)
        self.adopt = gui.add_button_group("Make mine", ("Model 1", "Model 2"), visible=False)
        self.table = gui.add_html("")
        self._add_settings(gui, state)
        on_press(self.start, post, "search")
        on_press(self.cancel, post, "search_cancel")
        on_press(self.adopt, post, "adopt")
        on_value(self.overlay, post, "overlay")

    def _add_settings(self, gui: Any, state: ModelState) -> None:
        usual, told = self._usual, {one.name: one.help for one in options_of(SearchSettings)}
        low = state.model.n_free + 1
        with gui.add_folder("Settings", expand_by_default=False):
            choices = tuple(state.model.objectives)
            self.counts = gui.add_dropdown(
                "Counts", choices, visible=len(choices) > 1, hint=told["objective"]
            )
            self.first = gui.add_number(
                "First runs", usual.n_training, min=low, max=_MOST_RUNS, step=1,
                visible=bool(usual.repair), hint=told["training_samples"],
            )  # fmt: skip
            self.more = gui.add_number(
                "More runs", usual.n_repair or 2, min=2, max=_MOST_RUNS, step=1,
                visible=bool(usual.repair), hint=told["repair_models"],
            )  # fmt: skip
            self.seed = gui.add_number(
                "Seed", usual.seed, min=0, max=2**31 - 1, step=1, hint=told["seed"]
            )

    @property
    def settings_by_name(self) -> dict[str, Any]:
        """The widgets of what a search is told, by name."""
        return {
            "search.objective": self.counts,
            "search.training_samples": self.first,
            "search.repair_models": self.more,
            "search.seed": self.seed,
        }

    @property
    def settings(self) -> SearchSettings:
        """What the visitor has set; the rest is as the model has it."""
        counts = {}
        if self._usual.repair:
            counts = {"training_samples": self.n_first, "repair_models": round(self.more.value)}
        return replace(
            self._usual, objective=self.counts.value, seed=round(self.seed.value), **counts
        )

    @property
    def n_first(self) -> int:
        """Runs before the first look."""
        return int(self.first.value)

    @property
    def n_runs(self) -> int:
        """The most runs that a search may take."""
        return self.n_first + int(self.more.value)

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the button, or the other way round."""
        self.start.disabled = running
        for handle in (self.progress, self.left, self.rising, self.cancel):
            handle.visible = running
        if running:
            self.progress.value = 0.0
            self.left.content = self.rising.content = ""
