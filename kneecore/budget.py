"""What a run will ask of the machine: refused in one line if the machine cannot give it."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from kneecore.errors import ParameterError

__all__ = ["Budget", "check_budget", "container_memory", "installed_memory", "surrogate_memory"]

LONGEST = 10 * 365 * 86_400.0
"""Seconds, ten years: nobody waits for a run that takes longer."""
_GIB = 2.0**30
_NONE = float("inf")


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
    """Return the bytes of memory that this process may have; infinite where nothing tells.

    That is the machine's memory, or less where a container or a service has less.
    """
    try:
        machine = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # Windows has no sysconf
        machine = float("inf")
    return min(machine, container_memory())


def container_memory(root: Path = Path("/")) -> float:
    """Return the least limit of the control groups that this process is in, bytes; or infinity.

    Of both versions of Linux's control groups; `root` stands for the root of the file system.
    """
    try:
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return float("inf")
    return min((_limit(file) for line in lines for file in _limit_files(root, line)), default=_NONE)


def _limit_files(root: Path, line: str) -> Iterator[Path]:
    """Yield the files with the limits of a group and of those around it.

    A container may see its own group as the outermost one, whatever its line says.
    """
    _, controllers, group = (line.split(":", 2) + ["", ""])[:3]
    if controllers == "":
        base, name = root / "sys/fs/cgroup", "memory.max"
    elif "memory" in controllers.split(","):
        base, name = root / "sys/fs/cgroup/memory", "memory.limit_in_bytes"
    else:
        return
    parts = [part for part in group.split("/") if part not in ("", "..")]
    for k in range(len(parts) + 1):
        yield base.joinpath(*parts[:k], name)


def _limit(file: Path) -> float:
    try:
        return float(int(file.read_text(encoding="ascii")))
    except (OSError, ValueError):  # there is none, or it is "max"
        return _NONE


def surrogate_memory(n_samples: int, n_dimensions: int) -> float:
    """Return the bytes of a surrogate's fit.

    Those are the linear system, its factors and its inverse, and all samples' differences.
    """
    return 8.0 * (3 * (n_samples + n_dimensions + 1) ** 2 + n_samples**2 * n_dimensions)


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
