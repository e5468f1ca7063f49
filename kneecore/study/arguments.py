"""What every study is asked with, checked; and how it tells of its steps."""

from typing import Any, TypeVar

from kneecore._arguments import callback_or_none, shown
from kneecore.budget import check_budget
from kneecore.errors import ParameterError
from kneecore.progress import Callback, Cancelled, Progress
from kneecore.search.arguments import check_model
from kneecore.study.budget import study_budget

__all__ = ["Steps", "checked_settings"]

_Settings = TypeVar("_Settings")


def checked_settings(
    model: Any, kind: type[_Settings], settings: Any, callback: Any = None
) -> _Settings:
    """Return the settings of a study, the default ones for None, after a look at all arguments.

    Raises
    ------
    ParameterError
        If the model is no `Model`, the settings are of another kind, the callback is none, or the
        machine cannot do what is asked for.
    """
    check_model(model)
    callback_or_none(callback)
    if settings is None:
        settings = kind()
    if not isinstance(settings, kind):
        raise ParameterError(
            f"`settings` is {shown(settings)}; kneecore.{kind.__name__} are allowed"
        )
    budget = study_budget(settings, model)
    if budget is not None:
        check_budget(budget)
    return settings


class Steps:
    """Reports how many of a study's steps are done, also from within a step."""

    def __init__(self, callback: Callback | None, stage: str, total: int) -> None:
        self._callback, self._stage, self._total = callback, stage, total
        self.done = 0

    def __call__(self, _best: float = 0.0, _n_models: int = 0) -> bool:
        """Report, and tell whether the callback asks to stop."""
        if self._callback is None:
            return False
        report = Progress(stage=self._stage, done=self.done, total=self._total)
        return bool(self._callback(report))

    def within(self, _report: Progress) -> bool:
        """Report in the place of a search's own report."""
        return self()

    def begin(self) -> None:
        """Report; raise `Cancelled` if the callback asks to stop."""
        if self():
            raise Cancelled
