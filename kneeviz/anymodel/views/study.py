"""The tabs "Study" and "Influence" of a model: band, influence, landscape."""

from typing import Any, get_args

from kneecore.numerics.sampling_options import Sampling
from kneeviz.anymodel.state import ModelState
from kneeviz.anymodel.views.distributions import Distributions
from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box, faint
from kneeviz.views.tabs.events import on_press, on_value
from kneeviz.views.tabs.running import show_running

MODEL, SURROGATE = "The model", "Its surrogate"
SHOW, BACK = "Landscape", "Back from the landscape"
_SAMPLES = 10_000
_MOST_COLUMNS = 500
_INTRO = "What does the uncertainty do on the whole, and which inputs decide?"


def column_labels(state: ModelState) -> tuple[str, ...]:
    """Return the model's numbers, the first of very many, each by a name of its own."""
    titles = [column.title for column in state.model.columns[:_MOST_COLUMNS]]
    return tuple(t if titles.count(t) == 1 else f"{t} [{k + 1}]" for k, t in enumerate(titles))


class StudyTab:
    """Sampling, influence and landscape: buttons, progress, and what they found."""

    def __init__(self, gui: Any, post: Post, state: ModelState) -> None:
        self.intro = gui.add_html(box(faint(_INTRO)))
        self.of = gui.add_dropdown(
            "Of", (MODEL, SURROGATE), hint="What is run; a surrogate costs nothing, and errs."
        )
        self.runs = {
            "sampling": gui.add_button(
                "Band", hint="Draws models within the bounds; 99.7 % of them lie in the band."
            ),
            "influence": gui.add_button(
                "Influence",
                color="gray",
                hint="Which inputs decide each output: Sobol\u2019 indices. Charts in the tab "
                "\u201cInfluence\u201d on the left.",
            ),
            "landscape": gui.add_button(
                SHOW, color="gray", hint="One output over two inputs, the others as you set them."
            ),
        }
        self.cost = gui.add_html("")
        self.progress = gui.add_progress_bar(0.0, visible=False)
        self.left = gui.add_html("", visible=False)
        self.cancel = gui.add_button("Cancel the study", color="red", visible=False)
        self._add_landscape(gui, state)
        self.band = gui.add_checkbox(
            "Show the band", True, visible=False, hint="Behind the curves."
        )
        self.sampled = gui.add_html("")
        self._add_settings(gui)
        self.drawn = Distributions(gui, state.model)
        self._connect(post)

    def _add_landscape(self, gui: Any, state: ModelState) -> None:
        names = tuple(one.name for one in state.dials if one.even)
        self.height = gui.add_dropdown("Upright", column_labels(state), visible=False)
        self.axes = [
            gui.add_dropdown(label, names or ("",), visible=False)
            for label in ("To the right", "Into depth")
        ]
        self.axes[1].value = self.axes[1].options[-1]
        self.key = gui.add_html("", visible=False)
        self.runs["landscape"].visible = len(names) > 1

    def _add_settings(self, gui: Any) -> None:
        with gui.add_folder("Study settings", expand_by_default=False):
            self.n_samples = gui.add_number(
                "Samples", _SAMPLES, min=100, max=1_000_000, step=100, hint="Runs of the band."
            )
            self.sampling = gui.add_dropdown(
                "Drawn", get_args(Sampling), hint="How they are spread within the bounds."
            )
            self.n_base = gui.add_dropdown(
                "Base rows",
                ("64", "128", "256", "512", "1024", "2048", "4096"),
                initial_value="512",
                hint="Of the indices; each costs as many runs as inputs vary, and two more.",
            )
            self.grid = gui.add_number(
                "Grid", 21, min=5, max=65, step=1, hint="Of the landscape: points along an input."
            )
            self.seed = gui.add_number(
                "Study seed", 0, min=0, max=2**31 - 1, step=1, hint="The same seed, the same bytes."
            )

    def _connect(self, post: Post) -> None:
        for kind, handle in self.runs.items():
            on_press(handle, post, ("study", kind))
        on_press(self.cancel, post, "study_cancel")
        on_value(self.band, post, "band")
        on_value(self.height, post, "column")
        for k, handle in enumerate(self.axes):
            on_value(handle, post, ("axis", k))

    @property
    def settings_by_name(self) -> dict[str, Any]:
        """The widgets of what studies are told, by name."""
        return {
            "study.of": self.of,
            "study.samples": self.n_samples,
            "study.sampling": self.sampling,
            "study.base_rows": self.n_base,
            "study.grid": self.grid,
            "study.seed": self.seed,
            **self.drawn.by_name,
        }

    @property
    def in_surrogate(self) -> bool:
        """Whether it is the surrogate that is studied."""
        return bool(self.of.value == SURROGATE)

    def n_runs(self, n_free: int) -> dict[str, int]:
        """Return the runs that each study takes, by its name on the page."""
        return {
            "Band": int(self.n_samples.value),
            "Influence": int(self.n_base.value) * (n_free + 2),
            "Landscape": int(self.grid.value) ** 2,
        }

    def suit_slow(self) -> None:
        """Begin with what a slow model allows."""
        self.of.value = SURROGATE

    def set_running(self, running: bool) -> None:
        """Show the progress and shut the buttons, or the other way round."""
        show_running(self, running)
        self.left.visible, self.left.content = running, ""

    def show_landscape(self, shown: bool) -> None:
        """Show what belongs to the landscape, or hide it."""
        self.runs["landscape"].label = BACK if shown else SHOW
        self.intro.visible = not shown
        for handle in (self.height, *self.axes, self.key):
            handle.visible = shown


class InfluenceTab:
    """The chart of influence."""

    def __init__(self, gui: Any, post: Post, state: ModelState) -> None:
        self.column = gui.add_dropdown("Output", column_labels(state))
        self.content = gui.add_html("")
        on_value(self.column, post, "column")
