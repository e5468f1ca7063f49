"""The tab "Search": the worst case live or on demand, its settings, and what was found."""

from typing import Any

from kneecore import Knee, SearchSettings
from kneecore.knee.response import Solver
from kneecore.search.settings import SearchSpace, enough_samples
from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press, on_value
from kneeviz.views.tabs.options import Look, OptionWidgets

NOT_HERE = {
    "search_space": "the two buttons choose it",
    "training_samples": "follows from the number of free parameters",
    "repair_gap_percent": "its default is what the page promises",
    "repair_models": "its default is what the page promises",
    "repair_batch": "knees are repaired one by one",
    "max_runs": "a run of a knee costs next to nothing",
    "n_runs": "the page shows one run",
    "weights": "twelve numbers: the loads are chosen in words",
    "options": "the genetic algorithm's constants, for the command line",
}
"""Options of the search without a widget, and why."""
LOADS = ("all", "extension", "flexion")
LOOKS = {
    "method": Look(label="Method", words={"ga": "Genetic", "exact": "Exact gradients"}),
    "thorough": Look(label="Thorough"),
    "bound": Look(label="Bound"),
    "repair": Look(label="Repair"),
    "pop_size": Look(label="Population", low=10, high=2000, step=10),
    "n_generations": Look(label="Generations", low=1, high=5000, step=10),
    "objective": Look(label="Loads", words={name: name for name in LOADS}),
    "seed": Look(label="Seed", low=0, high=2**31 - 1),
}
_GENETIC, _EXACT = ("pop_size", "n_generations"), ("thorough", "bound")
"""Options that one method alone has."""
SOLVERS: dict[str, Solver] = {"In motion": "dynamics", "At rest": "equilibrium"}
_LIVE_HINT = (
    "Follows every bound and slider: the two most different knees within the bounds around your "
    "knee, each at rest under its load (settled), in the true model, and where 99.7 % of 2,000 "
    "random ones lie. The buttons below search around the baseline, once."
)


class SearchTab:
    """The two searches: settings, progress, and what they found."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.intro = gui.add_html(
            box(
                "Which two knees within the bounds move most differently? Evolution looks for them."
            )
        )
        self.live = gui.add_checkbox("Live worst case", False, hint=_LIVE_HINT)
        self.live_note = gui.add_html("")
        self._add_runs(gui)
        self._add_found(gui)
        self._add_settings(gui)
        self._connect(post)

    def _add_runs(self, gui: Any) -> None:
        self.surrogate = gui.add_button(
            "Worst case (surrogate)",
            hint="Searches in a stand-in that learned from 50 knees: a fraction of a second. "
            "The true model then checks the two.",
        )
        self.model = gui.add_button(
            "Worst case (true model)",
            color="gray",
            hint="Every candidate is simulated: seconds to a minute; with exact gradients at once.",
        )
        # It stays, so that nothing else slides under the pointer that has pressed it.
        self.cancel = gui.add_button("Cancel the search", color="red", disabled=True)
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.rising = gui.add_html("", visible=False)

    def _add_found(self, gui: Any) -> None:
        self.found = gui.add_html("")
        self.overlay = gui.add_checkbox("Show both", True, visible=False)
        self.beside = gui.add_checkbox(
            "Side by side",
            False,
            visible=False,
            hint="Model 1 to the left of your knee and model 2 to its right, instead of over it.",
        )
        self.adopt = gui.add_button_group("Make mine", ("Model 1", "Model 2"), visible=False)
        self.table = gui.add_html("")

    def _add_settings(self, gui: Any) -> None:
        with gui.add_folder("Settings", expand_by_default=False):
            self.solver = gui.add_dropdown(
                "Response",
                tuple(SOLVERS),
                hint="In motion: after 23 s of simulated motion, as in the paper. At rest: the "
                "equilibrium under each load.",
            )
            self.options = OptionWidgets(gui, SearchSettings, without=NOT_HERE, looks=LOOKS)
        self.show_method()

    @property
    def settings_by_name(self) -> dict[str, Any]:
        """The widgets of what a search is told, by name."""
        named = {"solver": self.solver, **self.options.handles}
        return {f"search.{name}": handle for name, handle in named.items()}

    @property
    def chosen_solver(self) -> Solver:
        """The response of the true model that the visitor has chosen."""
        return SOLVERS[self.solver.value]

    def settings(self, knee: Knee, search_space: SearchSpace) -> SearchSettings:
        """Return what the visitor has set, for a search there."""
        values = self.options.values()
        exact = values["method"] == "exact"
        if exact:  # it has none of them, and refuses them
            values = {name: v for name, v in values.items() if name not in _GENETIC}
        for name in _EXACT:
            values[name] &= exact and search_space == "model"
        values["repair"] &= search_space == "surrogate"
        samples = enough_samples(knee.n_free)
        return SearchSettings(search_space=search_space, training_samples=samples, **values)

    def _connect(self, post: Post) -> None:
        for handle, key in (
            (self.surrogate, ("search", "surrogate")),
            (self.model, ("search", "model")),
            (self.cancel, "cancel"),
            (self.adopt, "adopt"),
        ):
            on_press(handle, post, key)
        on_value(self.live, post, "live")
        on_value(self.overlay, post, "overlay")
        on_value(self.beside, post, "beside")

    def offer_pair(self, there: bool) -> None:
        """Offer what can be done with a result's two knees, if there is one."""
        for handle in (self.overlay, self.beside, self.adopt):
            handle.visible = there

    def show_method(self) -> None:
        """Shut what the chosen method has none of."""
        genetic = self.options.value("method") == "ga"
        for names, shut in ((_GENETIC, not genetic), (_EXACT, genetic)):
            for name in names:
                self.options.handles[name].disabled = shut

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the buttons, or the other way round."""
        self.surrogate.disabled = self.model.disabled = running
        self.cancel.disabled = not running
        self.progress.visible = self.rising.visible = running
        if running:
            self.progress.value = 0.0
            self.rising.content = ""
