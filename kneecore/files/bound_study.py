"""A sweep over bounds together with the accuracy that is needed, as one document."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from kneecore.files import bound_sweep, needed_accuracy
from kneecore.presented import Format, rendered
from kneecore.study.bound_sweep import BoundSweep
from kneecore.study.needed_accuracy import NeededAccuracy

__all__ = ["FORMAT", "BoundStudy"]


SCHEMA = "kneecore.bound_study/1"


@dataclass
class BoundStudy:
    """What has been computed so far."""

    sweep: BoundSweep
    need: NeededAccuracy | None = None

    def __str__(self) -> str:
        return "\n\n".join(str(part) for part in (self.sweep, self.need) if part is not None)

    def to_dict(self) -> dict[str, Any]:
        """Return the sweep as JSON-ready values, with the answer beside it."""
        document = bound_sweep.to_dict(self.sweep) | {"schema": SCHEMA}
        if self.need is not None:
            document["needed_accuracy"] = needed_accuracy.to_dict(self.need)
        return document


def from_dict(document: dict[str, Any]) -> BoundStudy:
    """Return the study that `BoundStudy.to_dict` has told."""
    need = document.get("needed_accuracy")
    return BoundStudy(
        sweep=bound_sweep.from_dict(document),
        need=None if need is None else needed_accuracy.from_dict(need),
    )


def _others(study: BoundStudy, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(study.sweep, study.need)


FORMAT = Format(
    schema=SCHEMA,
    file=bound_sweep.FORMAT.file,
    to_dict=BoundStudy.to_dict,
    from_dict=from_dict,
    others=_others,
)
