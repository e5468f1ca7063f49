"""The accuracy that is needed as JSON, and back."""

from collections.abc import Iterator, Mapping
from typing import Any

from kneecore.files.bound_sweep import knee_bounds
from kneecore.files.model import array, number_or_none
from kneecore.files.origin import column_of, numbers_of, origin_table, read_origin, read_versions
from kneecore.knee.model import Knee
from kneecore.presented import Format, rendered
from kneecore.report.needed_accuracy import WORDS
from kneecore.study.best_search import searches_in_model
from kneecore.study.needed_accuracy import NeededAccuracy
from kneecore.study.settings import NeededAccuracySettings

__all__ = ["FORMAT", "from_dict", "to_dict"]

SCHEMA = "kneecore.needed_accuracy/1"
_NAMES = (
    "within",
    "size",
    "largest_value",
    "beyond",
    "beyond_value",
    "sampled_value",
    "largest",
    "tolerance",
)
_KNEE_KEYS: Mapping[str, str] = {
    "within": "within_deg",
    "size": "bound_mm",
    "largest_value": "largest_angle_deg",
    "beyond": "beyond_mm",
    "beyond_value": "beyond_deg",
    "sampled_value": "sampled_largest_angle_deg",
    "largest": "largest_mm",
    "tolerance": "tolerance_mm",
}
"""What a knee's numbers are called: with their units."""


def _keys(*, knee: bool) -> Mapping[str, str]:
    return _KNEE_KEYS if knee else {name: name for name in _NAMES}


def to_dict(need: NeededAccuracy) -> dict[str, Any]:
    """Return the answer as JSON-ready values."""
    model, settings = need.model, need.settings
    key, told = _keys(knee=isinstance(model, Knee)), numbers_of(model)
    own = (
        knee_bounds(model)
        if isinstance(model, Knee)
        else {"column": need.column, "in_model": need.in_model}
    )
    return {
        "schema": SCHEMA,
        "answer": WORDS.summary(need),
        key["within"]: settings.within,
        key["size"]: need.size,
        "reaches_largest": need.reaches_largest,
        key["largest_value"]: told(need.largest_value),
        key["beyond"]: need.beyond,
        key["beyond_value"]: told(need.beyond_value),
        key["sampled_value"]: told(need.sampled_value),
        "n_sampled": need.n_sampled,
        "n_searches": need.n_searches,
        "tried": told(need.tried),
        "seconds": round(need.seconds, 6),
        key["largest"]: settings.largest,
        key["tolerance"]: settings.tolerance,
        "seed": settings.seed,
        **own,
        **origin_table(model),
        "versions": dict(need.versions),
    }


def from_dict(document: dict[str, Any]) -> NeededAccuracy:
    """Return the answer that `to_dict` has told."""
    model = read_origin(document)
    knee = isinstance(model, Knee)
    key = _keys(knee=knee)
    settings = NeededAccuracySettings(
        within=document[key["within"]],
        largest=document[key["largest"]],
        tolerance=document[key["tolerance"]],
        seed=document["seed"],
    )
    return NeededAccuracy(
        model=model,
        settings=settings,
        column=column_of(document, model),
        size=number_or_none(document, key["size"]),
        reaches_largest=bool(document["reaches_largest"]),
        largest_value=float(document[key["largest_value"]]),
        beyond=number_or_none(document, key["beyond"]),
        beyond_value=number_or_none(document, key["beyond_value"]),
        sampled_value=number_or_none(document, key["sampled_value"]),
        n_sampled=int(document["n_sampled"]),
        tried=array(document["tried"], (-1, 2), "tried"),
        in_model=searches_in_model(model) if knee else bool(document["in_model"]),
        seconds=float(document["seconds"]),
        versions=read_versions(document),
    )


def _others(need: NeededAccuracy, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(need)


FORMAT = Format(
    schema=SCHEMA,
    file="needed_accuracy.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
