"""A line before a large run: how many models, how long, how much memory."""

from typing import TYPE_CHECKING

from kneecore.cli.run import say

if TYPE_CHECKING:
    from kneecore.budget import Budget
    from kneecore.model import Model

__all__ = ["tell_budget"]

WORTH_TELLING = 10.0
"""Seconds from which on a run is announced."""
_SECONDS_A_KNEE = {"dynamics": 8e-5, "equilibrium": 4e-6}
"""On one core, at the packaged baseline's bounds: the README's table of speed."""


def _duration(seconds: float) -> str:
    for unit, size, most in (("s", 1.0, 120.0), ("min", 60.0, 120.0), ("h", 3600.0, 72.0)):
        if seconds < most * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds / 86_400.0:,.0f} days"


def tell_budget(command: str, model: "Model", *budgets: "Budget | None", quiet: bool) -> None:
    """Say on stderr what a run will take, if that is more than some seconds.

    Raises
    ------
    ParameterError
        If the machine cannot do it.
    """
    from kneecore._threads import thread_count
    from kneecore.budget import check_budget

    known = [budget for budget in budgets if budget is not None]
    for budget in known:
        check_budget(budget)
    models = sum(budget.models for budget in known)
    solver = model.computed.get("solver")
    if solver is None:  # how long a run of another model takes, nobody knows yet
        return
    seconds = models * _SECONDS_A_KNEE[solver] / thread_count(model.threads)
    seconds += sum(sum(budget.seconds.values()) for budget in known)
    if quiet or seconds < WORTH_TELLING:
        return
    memory = max(sum(budget.memory.values()) for budget in known) / 2.0**20
    say(
        command,
        f"{models:,} models to run: about {_duration(seconds)}, "
        f"{max(memory, 1.0):,.0f} MiB for them (Ctrl-C stops)",
    )
