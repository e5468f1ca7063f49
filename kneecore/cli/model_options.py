"""The options that choose what is computed with: the knees, or a model of one's own."""

import dataclasses
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import tyro

from kneecore.cli.knee_options import Count, File, KneeOptions, Number

if TYPE_CHECKING:
    from kneecore.model import Model

Address = Annotated[str | None, tyro.conf.arg(metavar="tcp://HOST:PORT")]
Seconds = Annotated[float | None, tyro.conf.arg(metavar="S")]


@dataclass(frozen=True, kw_only=True)
class ModelOptions(KneeOptions):
    """What is computed with, and who does the runs."""

    model: File = None
    """A model of your own (TOML) in the knee's place: inputs, outputs, and a function or a program.
    It names code that is run."""
    quantile: Number = None
    """Search between the bounds that hold so much of each input's distribution, in its middle, such
    as 0.95; what is drawn for sampling and influence stays the same. Unset: the stated bounds."""
    workers: Count = None
    """Processes that do the runs. Unset: the file's, or this process."""
    scheduler: Address = None
    """Let the workers of a dask.distributed scheduler do the runs."""
    keep: File = None
    """Keep each run of a model of your own in this file, and take those from it that it holds."""
    timeout_s: Seconds = None
    """Seconds after which a run is ended and counts as failed."""

    def subject(self) -> "Model":
        """Return the model; raises what `Knee`, its space and `Model.from_file` raise."""
        from kneecore._threads import thread_count
        from kneecore.errors import ParameterError
        from kneecore.model import Model

        if self.scheduler is not None and self.workers is not None:
            raise ParameterError(
                f"`scheduler` is {self.scheduler!r}; it has workers of its own, and takes no "
                "`workers`"
            )
        self._refuse_the_knees()
        model = self.knee() if self.model is None else Model.from_file(self.model)
        if self.quantile is not None:
            model = model.with_quantile(self.quantile)
        if self.scheduler is not None:
            # Its own lines, on what it reconnects to, would go between ours.
            os.environ.setdefault("DASK_LOGGING__DISTRIBUTED", "critical")
        given = {
            "workers": self.workers if self.scheduler is None else self.scheduler,
            "keep": self.keep,
            "timeout_s": self.timeout_s,
        }
        if self.threads is not None:
            model.threads = thread_count(self.threads)
        given = {name: value for name, value in given.items() if value is not None}
        return model.with_runs(**given) if given else model

    def _refuse_the_knees(self) -> None:
        """Raise if there are options of the knees, and a model in their place."""
        from kneecore.errors import ParameterError

        if self.model is None:
            return
        for field in dataclasses.fields(KneeOptions):
            value = getattr(self, field.name)
            if field.name != "threads" and value != field.default:
                raise ParameterError(
                    f"`{field.name}` is {value!r}; it is the knee's, and with `model` there is none"
                )
