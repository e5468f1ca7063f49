"""How far a surrogate can be trusted as JSON, and back."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from kneecore.files.model import array
from kneecore.files.origin import (
    numbers_of,
    origin_table,
    read_counts,
    read_origin,
    read_seconds,
    read_versions,
    rounded,
)
from kneecore.files.settings import read_settings, write_settings
from kneecore.knee.model import Knee
from kneecore.knee.response import MOMENT
from kneecore.presented import Format, rendered
from kneecore.study.settings import SurrogateQualitySettings
from kneecore.study.surrogate_quality import Judgement, SurrogateQuality

__all__ = ["FORMAT", "from_dict", "to_dict"]

SCHEMA = "kneecore.surrogate_quality/1"


def to_dict(quality: SurrogateQuality) -> dict[str, Any]:
    """Return the quality as JSON-ready values, those of outputs in their units."""
    judged, told = quality.judgement, numbers_of(quality.model)
    document: dict[str, Any] = {
        "schema": SCHEMA,
        **({"moment_nm": MOMENT.tolist()} if isinstance(quality.model, Knee) else {}),
        "loo_rms": told(quality.loo_rms),
        "rms_error": told(judged.rms),
        "rms_error_all": told(judged.rms_all),
        "rank_correlation": told(judged.rank),
        "rank_correlation_pairs": told(judged.rank_f),
        "variance_explained": told(judged.explained),
        "pairs": {
            "objective_surrogate": told(judged.f_surrogate),
            "objective_model": told(judged.f_model),
        },
        "n_failed": quality.n_failed,
        "n_test": quality.n_test,
        "counts": dict(quality.counts),
        **origin_table(quality.model),
        "versions": dict(quality.versions),
        "seconds": rounded(quality.seconds),
    }
    write_settings(quality.settings, document, without=frozenset())
    return document


def _number(value: Any) -> float:
    return np.nan if value is None else float(value)


def from_dict(document: dict[str, Any]) -> SurrogateQuality:
    """Return the quality that `to_dict` has told."""
    model = read_origin(document)
    m, pairs = model.n_outputs, document["pairs"]
    f_surrogate = array(pairs["objective_surrogate"], (-1,), "pairs.objective_surrogate")
    return SurrogateQuality(
        model=model,
        settings=read_settings(SurrogateQualitySettings, document),
        loo_rms=array(document["loo_rms"], (m,), "loo_rms"),
        judgement=Judgement(
            f_surrogate=f_surrogate,
            f_model=array(pairs["objective_model"], f_surrogate.shape, "pairs.objective_model"),
            rank_f=_number(document["rank_correlation_pairs"]),
            rank=array(document["rank_correlation"], (m,), "rank_correlation"),
            rms=array(document["rms_error"], (m,), "rms_error"),
            explained=array(document["variance_explained"], (m,), "variance_explained"),
            rms_all=_number(document["rms_error_all"]),
        ),
        n_failed=int(document["n_failed"]),
        n_test=int(document["n_test"]),
        counts=read_counts(document),
        seconds=read_seconds(document),
        versions=read_versions(document),
    )


def _others(quality: SurrogateQuality, figures: bool) -> Iterator[tuple[str, bytes]]:
    if figures:
        yield from rendered(quality)


FORMAT = Format(
    schema=SCHEMA,
    file="surrogate_quality.json",
    to_dict=to_dict,
    from_dict=from_dict,
    others=_others,
)
