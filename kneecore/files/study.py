"""A study as one document: samples, the comparison with a worst case, and influence."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from kneecore.errors import KneecoreError
from kneecore.files import comparison as comparison_file
from kneecore.files import influence as influence_file
from kneecore.files import monte_carlo as sampling_file
from kneecore.presented import Format, rendered
from kneecore.search.result import SearchResult
from kneecore.study.comparison import Comparison
from kneecore.study.influence import InfluenceResult
from kneecore.study.monte_carlo import MonteCarloResult

__all__ = ["FORMAT", "INFLUENCE_FILE", "STUDY_FILE", "Study"]

SCHEMA = "kneecore.uncertainty/1"
STUDY_FILE = sampling_file.STUDY_FILE
INFLUENCE_FILE = influence_file.INFLUENCE_FILE


@dataclass
class Study:
    """What has been computed so far."""

    sampled: MonteCarloResult
    worst: SearchResult | None = None
    comparison: Comparison | None = None
    influence: InfluenceResult | None = None
    fault: KneecoreError | None = None
    """Why there is no influence although it was asked for."""

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON-ready values: the samples' keys, and two objects or null."""
        return to_dict(self)

    def report(self) -> str:
        """Return everything as text."""
        parts = (self.sampled, self.comparison, self.influence)
        return "\n\n".join(str(part) for part in parts if part is not None)


def to_dict(study: Study) -> dict[str, Any]:
    """Return a study as JSON-ready values."""
    compared = study.comparison
    return sampling_file.to_dict(study.sampled) | {
        "schema": SCHEMA,
        "comparison": None if compared is None else comparison_file.comparison_table(compared),
        "influence": None if study.influence is None else study.influence.to_dict(),
    }


def from_dict(document: dict[str, Any]) -> Study:
    """Return the study that `to_dict` has told; the worst case itself is not among it."""
    sampled = sampling_file.from_dict(document)
    compared, found = document.get("comparison"), document.get("influence")
    return Study(
        sampled=sampled,
        comparison=None
        if compared is None
        else comparison_file.read_comparison(compared, sampled.model),
        influence=None if found is None else influence_file.from_dict(found),
    )


def _others(study: Study, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(study.sampled, study.worst)
        if study.influence is not None:
            yield from rendered(study.influence)
    if study.influence is not None:
        yield INFLUENCE_FILE, influence_file.to_csv(study.influence).encode()


FORMAT = Format(
    schema=SCHEMA,
    file=STUDY_FILE,
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
