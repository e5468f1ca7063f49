"""The tab "Knee": presets, the sliders in their groups, and the bounds."""

from typing import Any

from kneecore import Parameter, parameter_table
from kneecore.knee.space import CASES
from kneeviz.jobs.messages import Post
from kneeviz.state.bounds import shown_bounds
from kneeviz.state.knee import KneeState
from kneeviz.state.presets import BASELINE, OWN_KNEE, PRESETS, RANDOM
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.tabs.events import on_press, on_value

GROUPS = ("acl", "pcl", "mcl", "lcl", "condyle", "plateau", "material")
REST = "rest lengths"
"""The group of the four rest lengths: a parameter of each ligament, but seldom wanted."""
_REST_HINT = "Held at 0 until the bounds let rest lengths vary (Rest, mm)."
_BOUNDS = {
    "geometry_mm": (
        "Geometry, mm",
        10.0,
        0.1,
        "Half-range of every coordinate and of the radius.",
    ),
    "slope_deg": (
        "Slope, °",
        10.0,
        0.1,
        "Half-range of the plateau's slope. The paper lists none for it.",
    ),
    "material_percent": (
        "Material, %",
        50.0,
        1.0,
        "Half-range of stiffnesses, Young's modulus and Poisson's ratio.",
    ),
    "rest_length_mm": (
        "Rest, mm",
        10.0,
        0.1,
        "Half-range of the four rest lengths. The paper leaves them out; above 0 they are "
        "uncertain too.",
    ),
}
"""Each bound's label, largest value, step and hint."""


def group_of(row: Parameter) -> str:
    """Return the group of sliders that a parameter belongs to."""
    return REST if row.kind == "rest length" else row.group


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
            if group == group_of(row)
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

    def _add_slider(self, gui: Any, state: KneeState, index: int, row: Parameter) -> Any:
        step = 0.001 if row.unit == "-" else 0.01
        low, high = state.slider_range(index)
        value = float(state.x[index]) / row.scale
        unit = "no unit" if row.unit == "-" else row.unit
        return gui.add_slider(
            parameter_label(row.name),
            min=round(low, 6),
            max=round(high, 6),
            step=step,
            initial_value=min(max(value, round(low, 6)), round(high, 6)),
            hint=f"{row.meaning} ({unit}). "
            + (_REST_HINT if row.kind == "rest length" else f"Baseline: {row.source}."),
            disabled=not state.is_free(index),
        )

    def _add_bounds(self, gui: Any, post: Post, state: KneeState) -> None:
        with gui.add_folder("Bounds: how uncertain?", expand_by_default=False):
            self.case = gui.add_dropdown(
                "Varies", CASES, initial_value="both", hint="Which parameters are uncertain at all."
            )
            self.bounds = {
                name: gui.add_number(
                    label, initial_value=round(half, 4), min=0.0, max=top, step=step, hint=hint
                )
                for (name, (label, top, step, hint)), half in zip(
                    _BOUNDS.items(), shown_bounds(state.knee), strict=True
                )
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
