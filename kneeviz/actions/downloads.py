"""What goes out as files: objects to bytes, no widgets."""

import io
import json
import zipfile
from dataclasses import replace
from typing import Any

import kneecore
from kneecore import MonteCarloResult, SearchResult
from kneecore.files.influence import to_csv
from kneecore.files.study import Study
from kneecore.presented import Presented
from kneeviz.state import results
from kneeviz.state.study import StudyState


def everything(result: Presented) -> bytes:
    """Return all files of a result, figures and (where needed) its knee included, as a ZIP."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in result.files():
            archive.writestr(name, content)
    return packed.getvalue()


def result_files(result: SearchResult, name: str) -> bytes:
    """Return the content of a download of a result: `result.json`, `curves.csv` or `result.zip`."""
    if name == "result.zip":
        return everything(result)
    return dict(result.files(figures=False))[name]


def study_file(study: StudyState, result: SearchResult | None, name: str) -> bytes | None:
    """Return the content of a download as the command line writes it, or None."""
    if name == "uncertainty.json":
        return None if study.sampled is None else _uncertainty(study, study.sampled, result)
    if name.startswith("paper"):
        if study.paper is None:
            return None
        return study.paper.page if name == "paper.html" else study.paper.everything
    if name == "accuracy_allocation.json":
        return None if study.accuracy is None else _json(study.accuracy.to_dict())
    if study.influence is None:
        return None
    if name == "influence.csv":
        return to_csv(study.influence).encode()
    return _json(study.influence.to_dict())


def _uncertainty(
    study: StudyState, sampled: MonteCarloResult, result: SearchResult | None
) -> bytes:
    """Return samples, and what belongs to the same bounds: influence and the worst case's place."""
    written = Study(sampled=sampled)
    if study.influence is not None and results.same_bounds(study.influence, sampled):
        written.influence = study.influence
    if result is not None and _comparable(result, sampled):
        if study.held_against is not result:  # its place among the samples was not counted
            sampled = replace(sampled, below=None)
        written.worst = result
        written.comparison = kneecore.compare_with_sampling(result, sampled)
    return _json(written.to_dict())


def _comparable(result: SearchResult, sampled: MonteCarloResult) -> bool:
    same_solver = results.solver(result) == results.solver(sampled)
    return same_solver and results.same_bounds(result, sampled)


def _json(content: Any) -> bytes:
    return (json.dumps(content, allow_nan=False) + "\n").encode()
