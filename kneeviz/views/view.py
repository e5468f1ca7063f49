"""All handles of one view, built in one go: scene, charts on the left, controls on the right."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore import ParameterSpace
from kneeviz.jobs.messages import Post
from kneeviz.state.knee import KneeState
from kneeviz.state.landscape import free_names
from kneeviz.state.shown import Band, Markers, Shown
from kneeviz.state.snapshot import Settings
from kneeviz.views import theme
from kneeviz.views.charts.angles import ApChart, ForceCharts
from kneeviz.views.charts.curves import CurveChart
from kneeviz.views.charts.pointer import Pointer
from kneeviz.views.commands import add_commands
from kneeviz.views.html.comparison import comparison
from kneeviz.views.html.labels import with_unit
from kneeviz.views.html.pieces import box, faint, unseen_title
from kneeviz.views.html.readout import legend
from kneeviz.views.scene.handles import HandleScene
from kneeviz.views.scene.knee import KneeScene
from kneeviz.views.scene.landscape import LandscapeScene
from kneeviz.views.settings import SettingHandles
from kneeviz.views.tabs.files import FilesTab
from kneeviz.views.tabs.knee import KneeTab
from kneeviz.views.tabs.learn import LearnTab
from kneeviz.views.tabs.look import LookTab
from kneeviz.views.tabs.methods import MethodsBox
from kneeviz.views.tabs.search import SearchTab
from kneeviz.views.tabs.study import InfluenceTab, StudyTab
from kneeviz.views.tabs.transport import add_transport

FloatArray = NDArray[np.float64]

TITLE = "A knee and its two worst cases"
LEFT_WIDTH, RIGHT_WIDTH = 390, 340


class View:
    """What a visitor sees. Its methods only assign to handles."""

    def __init__(self, target: Any, post: Post, state: KneeState) -> None:
        gui = target.gui
        self.dark = self.large = False
        self.faded: frozenset[str] = frozenset()
        """What is drawn in faded colours, since it belongs to a state that is over."""
        gui.configure_theme(
            show_logo=False, show_share_button=False, brand_color=theme.BRAND, dark_mode=False
        )
        gui.set_panel_label("kneeviz")
        self.scene = KneeScene(target.scene)
        self.handles = HandleScene(target.scene, post)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_WIDTH)
        self.landscape: LandscapeScene | None = None
        self._add_left(gui, post)
        self._add_right(gui, post, state)
        self.commands = add_commands(gui, post)

    def _add_left(self, gui: Any, post: Post) -> None:
        colours = theme.palette(self.dark)
        self.left = panel = gui.add_panel()
        with panel.add_tab("Curve"):
            self.curve_legend = gui.add_html("")
            self.curve = CurveChart(gui, colours, height=400)
            self.error = gui.add_html("")
            self.marks = gui.add_html("")
            self.found = gui.add_html("")
        with panel.add_tab("Forces"):
            self.force_legend = gui.add_html("")
            self.forces = ForceCharts(gui, colours, height=134)
        with panel.add_tab("AP"):
            self.ap_legend = gui.add_html("")
            self.ap = ApChart(gui, colours, height=400)
            self.pointer = Pointer(gui, post)
            gui.add_html(
                box(
                    faint(
                        "Where the condyle touches the plateau, along it, from its reference point."
                    )
                )
            )
        with panel.add_tab("Compare"):
            self.methods = MethodsBox(gui, post)
            self.comparison = gui.add_html("")
        with panel.add_tab("Influence"):
            self.influence = InfluenceTab(gui, post)
        panel.dock_left()
        panel.set_width(LEFT_WIDTH)

    def _add_right(self, gui: Any, post: Post, state: KneeState) -> None:
        gui.add_html(theme.ON_A_PHONE + theme.VISER_TEXTS + unseen_title(TITLE))
        self.class_size = gui.add_html("")
        self.transport = add_transport(gui, post)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Knee"):
            self.knee = KneeTab(gui, post, state)
        with tabs.add_tab("Search"):
            self.search = SearchTab(gui, post)
        with tabs.add_tab("Study"):
            free = tuple(with_unit(name) for name in free_names(state.space))
            self.study = StudyTab(gui, post, free)
        with tabs.add_tab("Learn"):
            self.learn = LearnTab(gui, post)
        with tabs.add_tab("View"):
            self.look = LookTab(gui, post)
        with tabs.add_tab("Files"):
            self.files = FilesTab(gui, post)
        handles = self.search.settings_by_name | self.study.settings_by_name
        self.settings = SettingHandles(handles, post)
        self.first_settings = self.settings.values

    def set_settings(self, settings: Settings) -> None:
        """Set all settings to values that `settings` has told."""
        self.settings.put(settings)
        self.search.show_method()

    @property
    def pointed(self) -> dict[str, Any]:
        """What a browser must know of the charts over which its pointer poses the knee."""
        angles = [chart.handle for chart in (*self.forces.charts, self.ap)]
        return self.pointer.told(self.curve.handle, angles)

    def repaint(self, gui: Any, dark: bool) -> None:
        """Change between the light and the dark theme."""
        self.dark = dark
        gui.configure_theme(
            show_logo=False, show_share_button=False, brand_color=theme.BRAND, dark_mode=dark
        )
        self._paint()

    def resize(self, gui: Any, large: bool) -> None:
        """Show everything large, for a class, or at a desk's size."""
        self.large = large
        self.class_size.content = theme.large_text() if large else ""
        for panel, width in ((self.left, LEFT_WIDTH), (gui.main_panel, RIGHT_WIDTH)):
            panel.set_width(round(width * (theme.CLASS_WIDER if large else 1.0)))
        self._paint()

    @property
    def colours(self) -> theme.Palette:
        """The theme's colours, faded where what they draw belongs to a state that is over."""
        return theme.faded(theme.palette(self.dark, large=self.large), self.faded)

    def fade(self, faded: frozenset[str]) -> None:
        """Draw some things in faded colours, and all others in their own."""
        if faded != self.faded:
            self.faded = faded
            self._paint()

    def _paint(self) -> None:
        colours = self.colours
        self.scene.paint(colours)
        self.handles.paint(colours)
        if self.landscape is not None:
            self.landscape.paint(colours)
        for chart in (self.curve, self.forces, self.ap):
            chart.repaint(colours)

    def show_legends(self, overlays: bool, band: Band | None, *, ghosts: bool) -> None:
        """Write the charts' keys."""
        colours = self.colours
        self.curve_legend.content = legend(
            colours,
            overlays=overlays,
            curve=True,
            band=None if band is None else band.text,
            ghosts=ghosts,
        )
        for handle in (self.force_legend, self.ap_legend):
            handle.content = legend(colours, overlays=overlays, curve=False)

    def show_other_charts(self, shown: Shown, markers: Markers) -> None:
        """Feed the charts behind the first tab, which may be fed less often."""
        self.forces.update(shown, markers)
        self.ap.show(shown, markers)

    def show_comparison(
        self, space: ParameterSpace, knees: tuple[FloatArray | None, ...], precision: int = 2
    ) -> None:
        """Write the parameters side by side: baseline, the visitor's knee, model 1 and 2."""
        colours = self.colours
        labels = ("baseline", "yours", "model 1", "model 2")
        hues = (colours.baseline, colours.current, colours.model_1, colours.model_2)
        entries = list(zip(labels, hues, knees, strict=True))
        self.comparison.content = comparison(space, entries, precision=precision)
