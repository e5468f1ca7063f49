"""Influence, slices and sweeps count what became of their runs, with every mark."""

import json

import numpy as np
import pytest

import kneecore
from kneecore import (
    BoundSweepSettings,
    FileFormatError,
    InfluenceSettings,
    Knee,
    ParameterSpace,
    TrainingSweepSettings,
)
from kneecore.files.digest import with_digest
from kneecore.files.load import read_document
from kneecore.presented import format_with_schema
from kneecore.report.marks import counted, counted_by_row

WIDE = ParameterSpace(geometry_bound_mm=3, slope_bound_deg=3, material_bound_percent=30)
STUDIES = {
    "influence": lambda knee: kneecore.influence(knee, InfluenceSettings(n_base=4)),
    "landscape": lambda knee: kneecore.landscape(knee, ("condyle_x", "condyle_y"), n_points=5),
    "training": lambda knee: kneecore.training_sweep(
        knee, TrainingSweepSettings(sizes=(40,), n_seeds=2, method="exact")
    ),
}
MARKS = ("unsettled", "not_at_rest", "implausible")


class Watched(Knee):
    """Wide knees in motion that keep what was run."""

    def __init__(self, **options):
        super().__init__(WIDE, **options)
        self.seen = []

    def _examine(self, x, *, observe):
        self.seen.append(x)
        return super()._examine(x, observe=observe)


def reread(result, **changes):
    document = json.loads(result.to_json()) | changes
    return read_document(with_digest(document), format_with_schema(document["schema"]))


@pytest.mark.parametrize("name", STUDIES)
def test_all_runs_are_counted_told_and_kept(name):
    knee = Watched()
    found = STUDIES[name](knee)
    batch = knee.simulate_batch(np.concatenate(knee.seen))
    assert found.counts["failed"] == batch.n_failed
    assert found.counts["refined"] == np.count_nonzero(batch.refinements > 0)
    marks = [found.counts[mark] for mark in MARKS]
    assert marks == [batch.n_unsettled, batch.n_not_at_rest, batch.n_implausible]
    assert marks[0] > 0
    assert counted(found.counts)[1] in " ".join(str(found).split())
    assert reread(found).counts == found.counts
    with pytest.raises(FileFormatError, match=r"counts\.unsettled"):
        reread(found, counts=found.counts | {"unsettled": 10**6})


@pytest.mark.parametrize("name", STUDIES)
def test_files_of_before_have_no_counts(name):
    found = STUDIES[name](Knee(solver="equilibrium"))
    document = json.loads(found.to_json())
    del document["counts"], document["digest"]
    old = read_document(document, format_with_schema(document["schema"]))
    assert old.counts == {}
    assert "implausible" not in str(old)


def test_a_bound_sweep_tells_which_of_its_knees_are_none():
    sweep = kneecore.bound_sweep(Knee(solver="equilibrium"), BoundSweepSettings(sizes=(0.5, 2.5)))
    assert (sweep.marks["implausible"] > 0).tolist() == [False, True]
    assert sweep.extremes[1, 0] < -60.0
    words = counted_by_row(sweep.marks, "these knees")
    assert "0, 2 implausible" in words
    assert words.strip() in " ".join(str(sweep).split())
    assert reread(sweep).to_json() == sweep.to_json()
    marks = json.loads(sweep.to_json())["marks"]
    with pytest.raises(FileFormatError, match=r"marks\.implausible"):
        reread(sweep, marks=marks | {"implausible": [0, 5]})


def test_an_influence_study_with_failed_knees_comes_back():
    knee = Knee(WIDE, solver="equilibrium")
    found = kneecore.influence(knee, InfluenceSettings(n_base=64, intervals=False))
    assert found.indices.n_failed_rows > 0
    assert found.counts["failed"] >= found.indices.n_failed_rows
    again = reread(found)
    assert again.to_json() == found.to_json()
    for change in ({"n_failed_rows": 0}, {"n_evaluations": found.indices.n_evaluations + 1}):
        with pytest.raises(FileFormatError, match=next(iter(change))):
            reread(found, **change)
