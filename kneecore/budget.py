"""What a run will ask of the machine: refused in one line if the machine cannot give it."""

import os
from collections.abc import Mapping
from typing import NamedTuple

from kneecore.errors import ParameterError

__all__ = ["Budget", "check_budget", "installed_memory", "surrogate_memory"]

LONGEST = 10 * 365 * 86_400.0
"""Seconds, ten years: nobody waits for a run that takes longer."""
_GIB = 2.0**30


class Budget(NamedTuple):
    """What a run asks for."""

    models: int
    """Runs of the model."""
    seconds: Mapping[str, float]
    """Least time that it takes, by the option that asks for it."""
    memory: Mapping[str, float]
    """Bytes at once, by the option that asks for them."""
    values: Mapping[str, object]
    """What these options are."""


def installed_memory() -> float:
    """Return the machine's memory in bytes; infinite where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # Windows has no sysconf
        return float("inf")


def surrogate_memory(n_samples: int, n_dimensions: int) -> float:
    """Return the bytes of a surrogate's fit: the linear system, its factors and its inverse."""
    return 3 * 8.0 * (n_samples + n_dimensions + 1) ** 2


def check_budget(budget: Budget) -> None:
    """Raise a `ParameterError` if a run needs more memory than there is, or years.

    The message names the option that asks for most.
    """
    has, needs = installed_memory(), sum(budget.memory.values())
    if needs > has:
        name = max(budget.memory, key=lambda one: budget.memory[one])
        raise ParameterError(
            f"`{name}` is {budget.values[name]}; that needs about {needs / _GIB:,.0f} GiB of "
            f"memory, and what fits into {has / _GIB:,.1f} GiB is allowed"
        )
    if sum(budget.seconds.values()) > LONGEST:
        name = max(budget.seconds, key=lambda one: budget.seconds[one])
        years = sum(budget.seconds.values()) / (365 * 86_400.0)
        raise ParameterError(
            f"`{name}` is {budget.values[name]}; that takes about {years:,.0f} years or longer, "
            "and at most 10 are allowed"
        )
