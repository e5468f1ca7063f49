"""How samples of each input are drawn: a kind, and how far the bounds are from the middle."""

from typing import Any

from kneecore import Model
from kneecore.distributions import KINDS, USUAL_DEVIATIONS, WITH_DEVIATIONS, Kind

_MOST = 40
"""Inputs that have widgets; others are drawn as the model has it."""


class Distributions:
    """A dropdown for each input, and a number where bounds are standard deviations away."""

    def __init__(self, gui: Any, model: Model) -> None:
        free = [i for i, free in zip(model.inputs, model.free, strict=True) if free]
        self._inputs = [i for i in free if not i.is_discrete][:_MOST]
        self._kinds: dict[str, Any] = {}
        self._deviations: dict[str, Any] = {}
        if not self._inputs:
            return
        with gui.add_folder("Distributions", expand_by_default=False):
            for one in self._inputs:
                self._kinds[one.name] = gui.add_dropdown(
                    one.name,
                    tuple(k for k in KINDS if k != "log-normal" or one.lower > 0.0),
                    initial_value=one.distribution,
                    hint="How band and influence draw it; a search takes the bounds.",
                )
                self._deviations[one.name] = gui.add_number(
                    "bounds at (sd)",
                    one.deviations or USUAL_DEVIATIONS,
                    min=0.1,
                    max=10.0,
                    step=0.1,
                    hint="Standard deviations from the middle to the bounds.",
                )
        self.show()

    @property
    def by_name(self) -> dict[str, Any]:
        """The widgets by their settings' names."""
        kinds = {f"study.distribution.{name}": h for name, h in self._kinds.items()}
        return kinds | {f"study.deviations.{name}": h for name, h in self._deviations.items()}

    @property
    def chosen(self) -> dict[str, tuple[Kind, float | None]]:
        """What is not as the model has it: kind and deviations, by input."""
        found = {}
        for one in self._inputs:
            kind: Kind = self._kinds[one.name].value
            far = float(self._deviations[one.name].value) if kind in WITH_DEVIATIONS else None
            if (kind, far) != (one.distribution, one.deviations):
                found[one.name] = (kind, far)
        return found

    def show(self) -> None:
        """Show the numbers that mean something."""
        for name, handle in self._deviations.items():
            visible = self._kinds[name].value in WITH_DEVIATIONS
            if handle.visible != visible:
                handle.visible = visible
