"""The tab "Search": the worst case live or on demand, its settings, and what was found."""

from typing import Any

from kneecore.knee.response import Solver
from kneecore.search.settings import Method
from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press, on_value

METHODS: dict[str, Method] = {"Genetic": "ga", "Exact gradients": "exact"}
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
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.rising = gui.add_html("", visible=False)
        self.cancel = gui.add_button("Cancel the search", color="red", visible=False)

    def _add_found(self, gui: Any) -> None:
        self.found = gui.add_html("")
        self.overlay = gui.add_checkbox("Show both", True, visible=False)
        self.adopt = gui.add_button_group("Make mine", ("Model 1", "Model 2"), visible=False)
        self.table = gui.add_html("")

    def _add_settings(self, gui: Any) -> None:
        with gui.add_folder("Settings", expand_by_default=False):
            self.method = gui.add_dropdown(
                "Method",
                tuple(METHODS),
                hint="Genetic: the paper's algorithm. Exact gradients: climbs from many starts, "
                "with the evidence of how many end in the same pair.",
            )
            self.solver = gui.add_dropdown(
                "Response",
                tuple(SOLVERS),
                hint="In motion: after 23 s of simulated motion, as in the paper. At rest: the "
                "equilibrium under each load.",
            )
            self.repair = gui.add_checkbox(
                "Repair",
                False,
                hint="In the surrogate: add the pair that was found, and up to 40 knees, to its "
                "training until surrogate and true model agree there to 1 %.",
            )
            self.pop_size = gui.add_number(
                "Population", 200, min=10, max=2000, step=10, hint="Pairs of knees alive at once."
            )
            self.n_generations = gui.add_number(
                "Generations", 800, min=1, max=5000, step=10, hint="How long evolution goes on."
            )
            self.seed = gui.add_number(
                "Seed", 0, min=0, max=2**31 - 1, step=1, hint="The same seed, the same result."
            )
            self.objective = gui.add_dropdown(
                "Loads", ("all", "extension", "flexion"), hint="Which of the 12 loads count."
            )

    def _connect(self, post: Post) -> None:
        for handle, key in (
            (self.surrogate, ("search", "surrogate")),
            (self.model, ("search", "model")),
            (self.cancel, "cancel"),
            (self.adopt, "adopt"),
        ):
            on_press(handle, post, key)
        on_value(self.live, post, "live")
        for handle in (self.seed, self.objective):
            on_value(handle, post, "live_settings")
        on_value(self.method, post, "method")
        on_value(self.overlay, post, "overlay")

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the buttons, or the other way round."""
        self.surrogate.disabled = self.model.disabled = running
        self.progress.visible = self.rising.visible = self.cancel.visible = running
        if running:
            self.progress.value = 0.0
            self.rising.content = ""
