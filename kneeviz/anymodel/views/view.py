"""All handles of a model's page: picture in the middle, charts on the left, controls right."""

from dataclasses import dataclass
from typing import Any

from kneeviz.anymodel.curves import places
from kneeviz.anymodel.state import ModelState
from kneeviz.anymodel.views.charts import Charts
from kneeviz.anymodel.views.commands import COMMANDS
from kneeviz.anymodel.views.files import FilesTab
from kneeviz.anymodel.views.inputs import InputsTab
from kneeviz.anymodel.views.picture import PictureScene
from kneeviz.anymodel.views.profile import ProfileChart
from kneeviz.anymodel.views.search import SearchTab
from kneeviz.anymodel.views.study import InfluenceTab, StudyTab, column_labels
from kneeviz.jobs.messages import Post
from kneeviz.views import theme
from kneeviz.views.commands import add_commands
from kneeviz.views.html.pieces import box, escape, faint, status, unseen_title
from kneeviz.views.scene.landscape import LandscapeScene
from kneeviz.views.settings import SettingHandles
from kneeviz.views.tabs.change import add_change
from kneeviz.views.tabs.events import on_press, on_value

LEFT_WIDTH, RIGHT_WIDTH = 390, 340
WIDE = 810
"""px of the charts where there is no picture, in a window of 1280: viser leaves 120 between."""


@dataclass(kw_only=True)
class Running:
    """The status line, and what runs a slow model, above the tabs."""

    status: Any
    run: Any
    learn: Any
    cancel: Any
    progress: Any


class ModelView:
    """What a visitor sees. Its methods only assign to handles."""

    def __init__(self, target: Any, post: Post, state: ModelState) -> None:
        gui = target.gui
        self.dark = self.large = False
        self._gui = gui
        self._theme(gui)
        gui.set_panel_label(f"kneeviz: {state.model.name}"[:60])
        self.has_picture = state.model.has_picture
        self.scene = PictureScene(target.scene)
        self.landscape: LandscapeScene | None = None
        self.curves, self.single = places(state.model)
        gui.main_panel.dock_right()
        self._add_left(gui, post, state)
        self._add_right(gui, post, state)
        self.commands = add_commands(gui, post, COMMANDS)

    def _theme(self, gui: Any) -> None:
        gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            brand_color=theme.BRAND,
            dark_mode=self.dark,
        )

    @property
    def colours(self) -> theme.Palette:
        """The theme's colours."""
        return theme.palette(self.dark, large=self.large)

    def _add_left(self, gui: Any, post: Post, state: ModelState) -> None:
        gui.add_html(theme.VISER_TEXTS + unseen_title(escape(state.model.name)))
        self.left = gui.add_panel()
        with self.left.add_tab("Outputs"):
            self.class_size = gui.add_html("")
            self.legend = gui.add_html("")
            self.charts = Charts(gui, self.colours, self.curves, wide=not self.has_picture)
            if self.charts.choice is not None:
                on_value(self.charts.choice, post, "chart")
            self.profile: ProfileChart | None = None
            if not self.curves:
                labels = column_labels(state)
                self.profile = ProfileChart(gui, post, self.colours, state, labels)
            self.numbers = gui.add_html("")
            self.error = gui.add_html("")
        with self.left.add_tab("Compare"):
            self.comparison = gui.add_html("")
        with self.left.add_tab("Influence"):
            self.influence = InfluenceTab(gui, post, state)
        self.left.dock_left()
        self.set_wide(not self.has_picture)

    @property
    def all_charts(self) -> list[Any]:
        """The charts of the outputs."""
        return [*self.charts.charts, *([] if self.profile is None else [self.profile])]

    def set_wide(self, wide: bool) -> None:
        """Let the charts take the picture's place, or make room for it."""
        self._wide = wide
        self._set_widths()

    def _set_widths(self) -> None:
        wider = theme.CLASS_WIDER if self.large else 1.0
        left = WIDE if self._wide else round(LEFT_WIDTH * wider)
        self.left.set_width(left)
        self._gui.main_panel.set_width(round(RIGHT_WIDTH * wider))

    def _add_right(self, gui: Any, post: Post, state: ModelState) -> None:
        self.running = self._add_running(gui, post)
        self.change = add_change(gui, post, "inputs, settings and result")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Inputs"):
            self.inputs = InputsTab(gui, post, state)
        with tabs.add_tab("Search"):
            self.search = SearchTab(gui, post, state)
        with tabs.add_tab("Study"):
            self.study = StudyTab(gui, post, state)
        with tabs.add_tab("View"):
            self._add_look(gui, post, state)
        with tabs.add_tab("Files"):
            self.files = FilesTab(gui, post)
        handles = self.search.settings_by_name | self.study.settings_by_name
        self.settings = SettingHandles(handles, post)

    def _add_running(self, gui: Any, post: Post) -> Running:
        running = Running(
            status=gui.add_html(status("Running the model once …", kind="busy")),
            run=gui.add_button(
                "Run the model here", visible=False, hint="Once, for the inputs as you set them."
            ),
            learn=gui.add_button("Learn a surrogate", color="gray", visible=False),
            cancel=gui.add_button("Cancel", color="red", visible=False),
            progress=gui.add_progress_bar(0.0, visible=False),
        )
        on_press(running.run, post, "run_here")
        on_press(running.learn, post, "learn")
        on_press(running.cancel, post, "run_cancel")
        return running

    def _add_look(self, gui: Any, post: Post, state: ModelState) -> None:
        self.dark_box = gui.add_checkbox("Dark theme", False)
        self.large_box = gui.add_checkbox(
            "Class size", False, hint="Larger text, lines and dots, for the last row."
        )
        self.reset_view = gui.add_button("Reset the view", color="gray")
        model = state.model
        about = f"{escape(model.name)}: {model.n_free} inputs vary, {model.n_outputs} outputs."
        gui.add_html(box(faint(about)))
        on_value(self.dark_box, post, "dark")
        on_value(self.large_box, post, "large")
        on_press(self.reset_view, post, "reset_view")

    def repaint(self, dark: bool) -> None:
        """Change between the light and the dark theme."""
        self.dark = dark
        self._theme(self._gui)
        self._paint()

    def resize(self, large: bool) -> None:
        """Show everything large, for a class, or at a desk's size."""
        self.large = large
        self.class_size.content = theme.large_text() if large else ""
        self._set_widths()
        self._paint()

    def _paint(self) -> None:
        for chart in self.all_charts:
            chart.repaint(self.colours)
        if self.landscape is not None:
            self.landscape.paint(self.colours)

    def say(self, text: str, kind: str = "calm") -> None:
        """Write the status line; `text` must be escaped."""
        self.running.status.content = status(text, kind=kind)
