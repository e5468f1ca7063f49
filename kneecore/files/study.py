"""A study as one document: samples, the comparison with a worst case, and influence."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kneecore.errors import KneecoreError
    from kneecore.search.result import SearchResult
    from kneecore.study.comparison import Comparison
    from kneecore.study.influence import InfluenceResult
    from kneecore.study.monte_carlo import MonteCarloResult

STUDY_FILE = "uncertainty.json"
INFLUENCE_FILE = "influence.csv"


@dataclass
class Study:
    """What has been computed so far."""

    sampled: "MonteCarloResult"
    worst: "SearchResult | None" = None
    comparison: "Comparison | None" = None
    influence: "InfluenceResult | None" = None
    fault: "KneecoreError | None" = None
    """Why there is no influence although it was asked for."""

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON-ready values: the samples' keys, and two objects or null."""
        document = self.sampled.to_dict()
        document["comparison"] = None if self.comparison is None else self.comparison.to_dict()
        document["influence"] = None if self.influence is None else self.influence.to_dict()
        return document

    def report(self) -> str:
        """Return everything as text."""
        from kneecore.report.study import comparison_report

        parts = [str(self.sampled)]
        if self.comparison is not None:
            parts.append(comparison_report(self.comparison))
        if self.influence is not None:
            parts.append(str(self.influence))
        return "\n\n".join(parts)
