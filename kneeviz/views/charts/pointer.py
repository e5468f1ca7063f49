"""What a pointer over a chart sets: widgets that nobody sees (`kneeviz/charts.js` sets them)."""

from collections.abc import Iterable
from typing import Any

from kneeviz import viser_internals
from kneeviz.jobs.messages import Post
from kneeviz.views.charts.series import MOMENT_LIMIT
from kneeviz.views.tabs.events import on_press, on_value

_WIDEST_ANGLE = 360.0
"""deg"""


class Pointer:
    """Where on a chart a pointer is, that it has left, and that its place is to stay."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.moment = gui.add_number(
            "Pointed moment (N·m)", 0.0, min=-MOMENT_LIMIT, max=MOMENT_LIMIT, visible=False
        )
        self.angle = gui.add_number(
            "Pointed angle (°)", 0.0, min=-_WIDEST_ANGLE, max=_WIDEST_ANGLE, visible=False
        )
        self.left = gui.add_button("Pointer left", visible=False)
        self.keep = gui.add_button("Keep the pose", visible=False)
        on_value(self.moment, post, ("point", "moment"))
        on_value(self.angle, post, ("point", "angle"))
        on_press(self.left, post, "point_left")
        on_press(self.keep, post, "point_keep")

    def told(self, over_moments: Any, over_angles: Iterable[Any]) -> dict[str, Any]:
        """Return what a browser must know: which charts set which widget."""
        called = viser_internals.widget_id
        poses = {called(over_moments): called(self.moment)}
        poses |= {called(chart): called(self.angle) for chart in over_angles}
        return {"poses": poses, "left": called(self.left), "keep": called(self.keep)}
