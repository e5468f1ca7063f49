"""The sliders as a picture of the visitor's knee."""

import viser

from kneeviz import viser_internals
from kneeviz.state.bounds import SCALE
from kneeviz.state.knee import KneeState
from kneeviz.views.tabs.knee import KneeTab


def shown_value(tab: KneeTab, state: KneeState, index: int) -> float:
    """Return what a slider shows for the present knee: its value to the slider's digits."""
    handle = tab.sliders[index]
    value = round(float(state.x[index] / SCALE[index]), int(handle.precision))
    return float(min(max(value, handle.min), handle.max))


def mirror(tab: KneeTab, state: KneeState, gui: viser.GuiApi) -> None:
    """Let all sliders show the present knee, also in a browser that missed something."""
    for index, handle in enumerate(tab.sliders):
        low, high = (round(edge, 6) for edge in state.slider_range(index))
        if (handle.min, handle.max) != (low, high):
            handle.min, handle.max = low, high
        handle.disabled = not state.is_free(index)
        value = shown_value(tab, state, index)
        if handle.value != value:
            handle.value = value
        else:
            viser_internals.force_value(gui, handle)
