"""The widgets of the study: its tab on the right, and the charts of influence on the left."""

from typing import Any, get_args

from kneecore.numerics.sampling_options import Sampling
from kneeviz.jobs.messages import Post
from kneeviz.state.study import BARS, HEAT_MAP, SLOPES
from kneeviz.views.html.labels import HEIGHTS, LOADS
from kneeviz.views.html.pieces import box, faint
from kneeviz.views.tabs.events import on_press, on_value
from kneeviz.views.tabs.running import show_running

SHOW, BACK = "Show the landscape", "Back to the knee"
_INTRO = (
    "What does the uncertainty do on the whole, and which parameters decide? All of it in the "
    "true model, within the bounds of the tab “Knee”."
)


class StudyTab:
    """Sampling, influence and the landscape: buttons, progress, and what they found."""

    def __init__(self, gui: Any, post: Post, free: tuple[str, ...]) -> None:
        self.intro = gui.add_html(box(faint(_INTRO)))
        self._add_landscape(gui, free)
        self._add_runs(gui)
        self._add_settings(gui)
        self._add_files(gui)
        self._connect(post)

    def _add_landscape(self, gui: Any, free: tuple[str, ...]) -> None:
        self.landscape = gui.add_button(
            SHOW,
            color="gray",
            hint="One angle over two parameters, in the true model and in the surrogate, in place "
            "of the knee.",
        )
        self.height = gui.add_dropdown(
            "Upright", tuple(HEIGHTS), initial_value=tuple(HEIGHTS)[1], visible=False
        )
        self.axes = [
            gui.add_dropdown("To the right", free, initial_value=free[0], visible=False),
            gui.add_dropdown("Into depth", free, initial_value=free[-1], visible=False),
        ]
        self.zoom = gui.add_checkbox(
            "Zoom",
            False,
            visible=False,
            hint="Fit the upright axis to the two sheets; knees beyond it are left out.",
        )
        self.key = gui.add_html("", visible=False)

    def _add_runs(self, gui: Any) -> None:
        self.runs = {
            "sampling": gui.add_button(
                "Sampling",
                hint="Simulates thousands of knees, drawn within the bounds, and draws the band "
                "that holds 99.7 % of them behind the curves.",
            ),
            "influence": gui.add_button(
                "Influence",
                color="gray",
                hint="Which parameters decide each angle: Sobol indices from some 30,000 knees. "
                "Charts in the tab “Influence” on the left.",
            ),
            "accuracy": gui.add_button(
                "Needed accuracy",
                color="gray",
                hint="Which measurement must be how good for every knee to extend far enough: one "
                "tolerance for all, and the cheapest. Some 40 exact searches.",
            ),
            "report": gui.add_button(
                "The paper, claim by claim",
                color="gray",
                hint="Redoes the searches and samples of Ciszkiewicz & Dumas 2024 within your "
                "bounds (rest lengths as there) and holds every claim against them: a report to "
                "download.",
            ),
        }
        self.progress = gui.add_progress_bar(0.0)
        self.cancel = gui.add_button("Cancel the study", color="red", disabled=True)
        self.judged = gui.add_html("")
        self.accuracy = gui.add_html("")
        self.sampled = gui.add_html("")
        self.band = gui.add_checkbox("Band", True, visible=False, hint="Behind the curves.")

    def _add_settings(self, gui: Any) -> None:
        with gui.add_folder("Study settings", expand_by_default=False):
            self.n_samples = gui.add_number(
                "Samples", 10_000, min=100, max=1_000_000, step=100, hint="Knees to simulate."
            )
            self.sampling = gui.add_dropdown(
                "Drawn", get_args(Sampling), hint="How the knees are spread within the bounds."
            )
            self.n_base = gui.add_dropdown(
                "Base rows",
                ("256", "512", "1024", "2048", "4096"),
                initial_value="1024",
                hint="Of the indices; each costs as many models as there are free parameters, and "
                "two more. More rows, narrower intervals.",
            )
            self.within = gui.add_number(
                "Extends to (°)",
                5.0,
                min=-30.0,
                max=90.0,
                step=0.5,
                hint="Of the needed accuracy: the flexion that may be left at +5 N·m.",
            )
            self.quick = gui.add_checkbox(
                "Quick paper",
                True,
                hint="Smaller searches and fewer samples: a preview in seconds instead of minutes.",
            )
            self.seed = gui.add_number(
                "Study seed", 0, min=0, max=2**31 - 1, step=1, hint="The same seed, the same bytes."
            )

    def _add_files(self, gui: Any) -> None:
        with gui.add_folder("Study files", expand_by_default=False):
            self.files = {
                "uncertainty.json": gui.add_button("Study (uncertainty.json)", disabled=True),
                "influence.json": gui.add_button("Influence (influence.json)", disabled=True),
                "influence.csv": gui.add_button("Influence (influence.csv)", disabled=True),
                "accuracy_allocation.json": gui.add_button(
                    "Accuracy (accuracy_allocation.json)", disabled=True
                ),
                "paper.html": gui.add_button("The paper (paper.html)", disabled=True),
                "paper.zip": gui.add_button("The paper, all files (.zip)", disabled=True),
            }

    def _connect(self, post: Post) -> None:
        for kind, handle in self.runs.items():
            on_press(handle, post, ("study", kind))
        for name, handle in self.files.items():
            on_press(handle, post, ("study_file", name))
        on_press(self.cancel, post, "study_cancel")
        on_value(self.band, post, "study_band")
        on_press(self.landscape, post, "landscape")
        for key, handle in (
            (("landscape_axis", 0), self.axes[0]),
            (("landscape_axis", 1), self.axes[1]),
            (("landscape_look", "height"), self.height),
            (("landscape_look", "zoom"), self.zoom),
        ):
            on_value(handle, post, key)

    @property
    def settings_by_name(self) -> dict[str, Any]:
        """The widgets of what a study is told, by name."""
        names = ("n_samples", "sampling", "n_base", "within", "quick", "seed")
        return {f"study.{name}": getattr(self, name) for name in names}

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the buttons, or the other way round."""
        show_running(self, running)

    def show_landscape(self, shown: bool) -> None:
        """Show what belongs to the landscape, or hide it."""
        self.landscape.label = BACK if shown else SHOW
        self.intro.visible = not shown  # its key needs the room
        for handle in (self.height, *self.axes, self.zoom, self.key):
            handle.visible = shown


class InfluenceTab:
    """The charts of influence, and what they show."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.load = gui.add_dropdown("Load", tuple(LOADS))
        self.chart = gui.add_button_group("Chart", (BARS, HEAT_MAP, SLOPES))
        self.content = gui.add_html("")
        on_value(self.load, post, "influence_load")
        on_press(self.chart, post, "influence_chart")
