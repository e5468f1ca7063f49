"""The machine that times are measured on, in one line."""

import platform
from pathlib import Path

from kneecore._threads import available_cores

__all__ = ["machine_name"]


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except (OSError, ValueError):  # not Linux
        pass
    return platform.processor() or platform.machine() or "unknown processor"


def machine_name(threads: int) -> str:
    """Return the processor, its cores, and how many threads were used."""
    cores = available_cores()
    return f"{_processor()}, {cores} core{'s'[: cores != 1]}, {threads} thread{'s'[: threads != 1]}"
