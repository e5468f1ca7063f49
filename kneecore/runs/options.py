"""How a model's runs are done."""

import re
from dataclasses import dataclass
from typing import Any, Literal, get_args

from kneecore._arguments import choice, file_name, flag, number, shown, whole_number
from kneecore._threads import MOST_THREADS
from kneecore.errors import ParameterError

__all__ = ["OnFailure", "RunOptions", "is_executor"]

OnFailure = Literal["continue", "abort"]
_ADDRESS = re.compile(r"(?:tcp|tls)://(?:[\w.-]{1,200}|\[[0-9a-fA-F:.]{2,50}\]):[0-9]{1,5}", re.A)
LONGEST_TIMEOUT_S = 30 * 86_400.0


def is_executor(value: Any) -> bool:
    """Tell whether somebody can be asked to run a function: by `submit`, or by `map`."""
    return callable(getattr(value, "submit", None)) or callable(getattr(value, "map", None))


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a model's runs are done, kept and given up."""

    workers: Any = None
    """None: here, one after the other. A number: so many processes. ``tcp://host:port``: those of a
    dask.distributed scheduler. Anything else: an executor with `submit` or `map`."""
    keep: str | None = None
    """File of runs that are done: they are read again before any is done anew."""
    timeout_s: float | None = None
    """Seconds after which a run is ended and counts as failed."""
    on_failure: OnFailure = "continue"
    """Whether a failed run is a row without outputs, or ends the computation."""
    retries: int = 0
    """How often a run that raised, hung or crashed is tried again."""
    rerun_failures: bool = False
    """Whether runs that failed are not taken from `keep`."""

    def __post_init__(self) -> None:
        workers = self.workers
        if isinstance(workers, str):
            if not _ADDRESS.fullmatch(workers):
                raise self._wrong_workers()
        elif workers is not None and not is_executor(workers):
            allowed = (
                "a whole number from 1, the address of a scheduler, or an executor with `submit` "
                "or `map`"
            )
            whole_number("workers", workers, 1, MOST_THREADS, allowed)
        if self.keep is not None:
            object.__setattr__(self, "keep", file_name("keep", self.keep))
        if self.timeout_s is not None:
            seconds = number("timeout_s", self.timeout_s, unit="s", most=LONGEST_TIMEOUT_S)
            if seconds <= 0.0:
                raise ParameterError(f"`timeout_s` is {seconds:g} s; above 0 is allowed")
        choice("on_failure", self.on_failure, get_args(OnFailure))
        whole_number("retries", self.retries, 0, 100)
        flag("rerun_failures", self.rerun_failures)

    def _wrong_workers(self) -> ParameterError:
        return ParameterError(
            f"`workers` is {shown(self.workers)}; a number, an executor or the address of a "
            "scheduler such as 'tcp://host:8786' is allowed"
        )
