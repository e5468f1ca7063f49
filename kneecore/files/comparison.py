"""A worst case beside samples as JSON, and back."""

from collections.abc import Iterator
from typing import Any

from kneecore.files.model import array
from kneecore.files.monte_carlo import MARKS
from kneecore.files.origin import numbers_of, origin_table, read_origin
from kneecore.knee.model import Knee
from kneecore.model import Model
from kneecore.presented import Format, rendered
from kneecore.search.result import MODELS
from kneecore.study.comparison import Comparison

__all__ = ["FORMAT", "comparison_table", "read_comparison"]

SCHEMA = "kneecore.comparison/1"


def _keys(model: Model) -> tuple[str, str]:
    """Return the keys of the excess and of the share of outputs: a knee's have its units."""
    if isinstance(model, Knee):
        return "excess_deg", "share_of_loads_outside"
    return "excess", "share_of_outputs_outside"


def comparison_table(found: Comparison) -> dict[str, Any]:
    """Return a comparison as it stands in a study's JSON."""
    excess, outside = _keys(found.model)
    told = numbers_of(found.model)
    objectives = [name for name in found.model.objectives if name != "all"] or ["all"]
    return {
        excess: dict(zip(MODELS[1:], map(told, found.excess), strict=True)),
        "excess_share": dict(zip(MODELS[1:], map(told, found.excess_share), strict=True)),
        outside: {name: told(found.share_outside(name)) for name in objectives},
        MARKS: told(found.below),
    }


def read_comparison(table: dict[str, Any], model: Model) -> Comparison:
    """Return the comparison that `comparison_table` has told."""
    m, key = model.n_outputs, _keys(model)[0]
    excess, share = (
        array([table[k][name] for name in MODELS[1:]], (2, m), k) for k in (key, "excess_share")
    )
    below = table[MARKS]
    return Comparison(
        model=model,
        excess=excess,
        excess_share=share,
        below=None if below is None else array(below, (2, m), MARKS),
    )


def to_dict(found: Comparison) -> dict[str, Any]:
    """Return a comparison as a document of its own."""
    return {"schema": SCHEMA, **origin_table(found.model), **comparison_table(found)}


def from_dict(document: dict[str, Any]) -> Comparison:
    """Return the comparison that `to_dict` has told."""
    return read_comparison(document, read_origin(document))


def _others(found: Comparison, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(found)


FORMAT = Format(
    schema=SCHEMA,
    file="comparison.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
