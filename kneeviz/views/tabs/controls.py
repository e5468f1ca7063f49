"""The widgets of the right panel. Their callbacks only post what was asked."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, NamedTuple

from kneecore import parameter_table
from kneecore.knee.space import CASES
from kneeviz.state.knee import PRESETS, KneeState, shown_bounds
from kneeviz.views.html import pieces as markup

Post = Callable[[Hashable, Any], None]

GROUPS = ("acl", "pcl", "mcl", "lcl", "condyle", "plateau", "material")
REST = "rest lengths"
"""The group of the four rest lengths: a parameter of each ligament, but seldom wanted."""
MODES = {
    "Through the loads": "sweep",
    "In time, extending": "extension",
    "In time, flexing": "flexion",
}
OWN_KNEE = "My own"
BASELINE = "Baseline"
RANDOM = "Random, within bounds"
METHODS = {"Genetic": "ga", "Exact gradients": "exact"}
SOLVERS = {"In motion": "dynamics", "At rest": "equilibrium"}
WORST = ("Worst case, model 1", "Worst case, model 2")


_REST_HINT = "Held at 0 until the bounds let rest lengths vary (Rest, mm)."


_LIVE_HINT = (
    "Follows every bound and slider: the two most different knees within the bounds around your "
    "knee, each at rest under its load (settled), in the true model, and where 99.7 % of 2,000 "
    "random ones lie. The buttons below search around the baseline, once."
)


class Asked(NamedTuple):
    """What a browser asked for."""

    handle: Any
    """The widget."""
    client_id: int
    value: Any
    """What the widget was set to: by now it may have been set to something else."""


def on_value(handle: Any, post: Post, key: Hashable) -> None:
    """Post an `Asked` under `key` whenever a browser changes the widget."""

    # A coroutine runs on viser's event loop, in the order of arrival, without a pool thread.
    async def changed(event: Any) -> None:
        if event.client is not None:
            post(key, Asked(handle, event.client.client_id, event.target.value))

    handle.on_update(changed)


def on_press(handle: Any, post: Post, key: Hashable) -> None:
    """Post an `Asked` under `key` whenever a browser presses the button."""

    async def pressed(event: Any) -> None:
        if event.client is not None:
            post(key, Asked(handle, event.client.client_id, event.target.value))

    handle.on_click(pressed)


@dataclass(kw_only=True)
class Transport:
    """Play, position and view: always in sight, above the tabs."""

    readout: Any
    status: Any
    play: Any
    position: Any
    view: Any


def add_transport(gui: Any, post: Post) -> Transport:
    """Build what stands above the tabs."""
    readout = gui.add_html("")
    play = gui.add_button_group("Motion", ("Play", "Pause"))
    position = gui.add_slider(
        "Position",
        min=0.0,
        max=100.0,
        step=0.1,
        initial_value=0.0,
        marks=((0.0, "straight"), (100.0, "bent")),
        hint="Through the loads: from +5 N·m (extension) to -5 N·m (flexion). In time: 0 to 23 s.",
    )
    view = gui.add_button_group("View", ("2D", "3D", "Reset"))
    status = gui.add_html(markup.status("Preparing the model …", kind="busy"))
    on_press(play, post, "play")
    on_value(position, post, "position")
    on_press(view, post, "view")
    return Transport(readout=readout, status=status, play=play, position=position, view=view)


class KneeTab:
    """Presets, the sliders in their groups, and the bounds."""

    def __init__(self, gui: Any, post: Post, state: KneeState) -> None:
        self.preset = gui.add_dropdown(
            "Knee",
            (OWN_KNEE, BASELINE, *PRESETS, RANDOM),
            initial_value=BASELINE,
            hint="Start from a telling knee. The worst cases join the list after a search.",
        )
        on_value(self.preset, post, "preset")
        self.reset_all = gui.add_button("Reset all to the baseline", color="gray")
        on_press(self.reset_all, post, "reset_all")
        self.sliders: list[Any] = []
        self.resets: dict[str, Any] = {}
        for group in (*GROUPS, REST):
            self._add_group(gui, post, state, group)
        self._add_bounds(gui, post, state)

    def _add_group(self, gui: Any, post: Post, state: KneeState, group: str) -> None:
        rows = [
            (i, row)
            for i, row in enumerate(parameter_table(rest_lengths=True))
            if group == (REST if row.kind == "rest length" else row.group)
        ]
        title = group.upper() if len(group) == 3 else group.capitalize()
        units = ", ".join(dict.fromkeys(r.unit for _, r in rows if r.unit != "-"))
        with gui.add_folder(
            f"{title} ({units.replace('^2', '²')})", expand_by_default=group == "acl"
        ):
            for index, row in rows:
                self.sliders.append(self._add_slider(gui, state, index, row))
                on_value(self.sliders[-1], post, ("param", index))
            self.resets[group] = gui.add_button(
                f"Reset {title if len(group) == 3 else group}", color="gray"
            )
            on_press(self.resets[group], post, ("reset_group", group))

    def _add_slider(self, gui: Any, state: KneeState, index: int, row: Any) -> Any:
        step = 0.001 if row.unit == "-" else 0.01
        low, high = state.slider_range(index)
        value = float(state.x[index]) / row.scale
        unit = "no unit" if row.unit == "-" else row.unit
        return gui.add_slider(
            markup.parameter_label(row.name),
            min=round(low, 6),
            max=round(high, 6),
            step=step,
            initial_value=min(max(value, round(low, 6)), round(high, 6)),
            hint=f"{row.meaning} ({unit}). "
            + (_REST_HINT if row.kind == "rest length" else f"Baseline: {row.source}."),
            disabled=not state.is_free(index),
        )

    def _add_bounds(self, gui: Any, post: Post, state: KneeState) -> None:
        geometry, slope, material, rest = shown_bounds(state.knee)
        with gui.add_folder("Bounds: how uncertain?", expand_by_default=False):
            self.case = gui.add_dropdown(
                "Varies", CASES, initial_value="both", hint="Which parameters are uncertain at all."
            )
            self.bounds = {
                "geometry_mm": gui.add_number(
                    "Geometry, mm",
                    initial_value=round(geometry, 4),
                    min=0.0,
                    max=10.0,
                    step=0.1,
                    hint="Half-range of every coordinate and of the radius.",
                ),
                "slope_deg": gui.add_number(
                    "Slope, deg",
                    initial_value=round(slope, 4),
                    min=0.0,
                    max=10.0,
                    step=0.1,
                    hint="Half-range of the plateau's slope. The paper lists none for it.",
                ),
                "material_percent": gui.add_number(
                    "Material, %",
                    initial_value=round(material, 4),
                    min=0.0,
                    max=50.0,
                    step=1.0,
                    hint="Half-range of stiffnesses, Young's modulus and Poisson's ratio.",
                ),
                "rest_length_mm": gui.add_number(
                    "Rest, mm",
                    initial_value=round(rest, 4),
                    min=0.0,
                    max=10.0,
                    step=0.1,
                    hint="Half-range of the four rest lengths. The paper leaves them out; above 0 "
                    "they are uncertain too.",
                ),
            }
            self.rest_length = gui.add_dropdown(
                "Rest lengths",
                ("recomputed", "fixed"),
                initial_value="recomputed",
                hint="recomputed: each knee is strain-free in its own load-free pose (54.79°). "
                "fixed: all knees have the baseline's rest lengths.",
            )
        on_value(self.case, post, ("bound", "case"))
        on_value(self.rest_length, post, ("bound", "rest_length"))
        for name, handle in self.bounds.items():
            on_value(handle, post, ("bound", name))


class SearchTab:
    """The two searches: settings, progress, and what they found."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.intro = gui.add_html(
            markup.box(
                "Which two knees within the bounds move most differently? Evolution looks for them."
            )
        )
        self.live = gui.add_checkbox("Live worst case", False, hint=_LIVE_HINT)
        self.live_note = gui.add_html("")
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
        self.found = gui.add_html("")
        self.overlay = gui.add_checkbox("Show both", True, visible=False)
        self.adopt = gui.add_button_group("Make mine", ("Model 1", "Model 2"), visible=False)
        self.table = gui.add_html("")
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


class ViewTab:
    """How things look and move."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.mode = gui.add_dropdown(
            "Motion",
            tuple(MODES),
            hint="Through the loads: the knee at rest under each moment. In time: the simulated "
            "motion itself, with its damping.",
        )
        self.speed = gui.add_slider("Speed", min=0.25, max=4.0, step=0.25, initial_value=1.0)
        self.loop = gui.add_checkbox("Loop", True)
        self.forces = gui.add_checkbox(
            "Newtons", False, hint="Write each ligament's tension beside its name."
        )
        self.dark = gui.add_checkbox("Dark theme", False)
        self.note = gui.add_html(
            markup.box(
                markup.faint(
                    "Slack ligaments are thin and grey; taut ones take colour and width with their "
                    "tension. The arrow is the contact force on the tibia. The circle and the line "
                    "are what the model computes with; the bones around them, and all depth in the "
                    "3D view, are illustrative."
                )
            )
        )
        for handle, key in (
            (self.mode, "mode"),
            (self.speed, "speed"),
            (self.loop, "loop"),
            (self.forces, "forces"),
            (self.dark, "dark"),
        ):
            on_value(handle, post, key)


class FilesTab:
    """Downloads and the one upload that takes either file."""

    def __init__(self, gui: Any, post: Post) -> None:
        gui.add_html(markup.box("<b>The last search</b>"))
        self.result = {
            "result.json": gui.add_button("Result (result.json)", disabled=True),
            "curves.csv": gui.add_button("Curves (curves.csv)", disabled=True),
            "result.zip": gui.add_button("All of it, with figures (.zip)", disabled=True),
        }
        gui.add_html(markup.box("<b>Your knee</b>: baseline, bounds and current values"))
        self.knee = gui.add_button("Knee (knee.toml)")
        gui.add_html(markup.box("<b>Load</b> a knee (.toml) or a result (.json)"))
        self.upload = gui.add_upload_button("Load a file …", mime_type=".toml,.json", color="gray")
        self.command = gui.add_html("")
        for name, handle in (*self.result.items(), ("knee.toml", self.knee)):
            on_press(handle, post, ("download", name))
        self._on_upload(post)

    def _on_upload(self, post: Post) -> None:
        async def arrived(event: Any) -> None:
            file = event.target.value
            post("upload", (file.name, file.content, event.client_id))

        self.upload.on_upload(arrived)
