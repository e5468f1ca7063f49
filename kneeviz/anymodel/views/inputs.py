"""The tab "Inputs": a slider for each input that varies."""

from typing import Any

from kneeviz.anymodel.dials import Dial, folders
from kneeviz.anymodel.state import ModelState
from kneeviz.anymodel.views.words import drawn, held
from kneeviz.jobs.messages import Post
from kneeviz.views.tabs.events import on_press, on_value


class InputsTab:
    """Sliders, in folders where there are many, and the way home."""

    def __init__(self, gui: Any, post: Post, state: ModelState) -> None:
        self.home = gui.add_button("All home", color="gray", hint="Every input at its nominal.")
        on_press(self.home, post, "home")
        self.sliders: dict[int, Any] = {}
        """By the input's place in the model."""
        for k, (title, group) in enumerate(folders(state.dials)):
            if title:
                with gui.add_folder(title, expand_by_default=k == 0):
                    self._add(gui, post, group)
            else:
                self._add(gui, post, group)
        fixed = [i for i in state.model.inputs if i.upper <= i.lower]
        self.held = gui.add_html(held(fixed), visible=bool(fixed))
        told = drawn(state.model)
        self.drawn = gui.add_html(told, visible=bool(told))

    def _add(self, gui: Any, post: Post, group: Any) -> None:
        for one in group:
            handle = gui.add_slider(
                one.label,
                min=one.low,
                max=one.high,
                step=one.step,
                initial_value=one.home,
                hint=hint(one),
            )
            self.sliders[one.index] = handle
            on_value(handle, post, ("input", one.index))


def hint(one: Dial) -> str:
    """Return an input's bounds and home in words."""
    sampled = "" if one.drawn == "uniform" else f" Samples are {one.drawn}."
    return (
        f"{one.name}: {one.text(one.lower)} to {one.text(one.upper)}, at home "
        f"{one.text(one.nominal)}.{sampled}"
    )
