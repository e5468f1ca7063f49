"""Influence, slices and sweeps count what became of their runs, with every mark."""

import json

import numpy as np
import pytest

import kneecore
from kneecore import (
    BoundSweepSettings,
    FileFormatError,
    InfluenceSettings,
    Input,
    Knee,
    Model,
    ModelError,
    Output,
    ParameterSpace,
    SurrogateQualitySettings,
    TrainingSweepSettings,
)
from kneecore.files.digest import with_digest
from kneecore.files.load import read_document
from kneecore.presented import format_with_schema
from kneecore.report.influence import answer
from kneecore.report.marks import counted, counted_by_row

WIDE = ParameterSpace(geometry_bound_mm=3, slope_bound_deg=3, material_bound_percent=30)
STUDIES = {
    "influence": lambda knee: kneecore.influence(knee, InfluenceSettings(n_base=4)),
    "landscape": lambda knee: kneecore.landscape(knee, ("condyle_x", "condyle_y"), n_points=5),
    "quality": lambda knee: kneecore.surrogate_quality(
        knee, SurrogateQualitySettings(training_samples=40, n_test=20)
    ),
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


def gappy(x):
    """Give one output everywhere, one below 0.9, one never."""
    often = np.where(x[:, 0] < 0.9, x[:, 0], np.nan)
    return np.column_stack([x.sum(axis=1), often, np.full(len(x), np.nan)])


def gappy_model():
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in (1, 2)]
    outputs = [Output(name) for name in ("always", "often", "never")]
    return Model(gappy, inputs, outputs, batched=True)


def test_one_failed_output_costs_influence_that_output_and_is_told():
    found = kneecore.influence(gappy_model(), InfluenceSettings(n_base=64, intervals=False))
    assert found.counts == {"failed": 0, "partial": 64 * 4}
    assert found.indices.n_evaluations == 64 * 4  # no row is replaced
    assert found.indices.n_used[[0, 2]].tolist() == [64, 0]
    assert answer(found, 2) == "never failed too often to tell what decides it."
    n = found.indices.n_used[1]
    told = " ".join(str(found).split())
    assert f"Base rows of outputs that failed in some runs: never 0, often {n}." in told
    assert "256 with some of their outputs only" in told
    again = reread(found)
    assert again.to_json() == found.to_json()
    for wrong in ([64, 65, 0], [64, 64, 64], [1, int(n), 0]):
        with pytest.raises(FileFormatError, match="n_used"):
            reread(found, n_used=wrong)


def test_one_failed_output_costs_a_slice_that_output():
    found = kneecore.landscape(gappy_model(), ("x_1", "x_2"), n_points=5)
    assert (found.n_failed, found.counts) == (0, {"failed": 0, "partial": 25})
    assert np.isfinite(found.y[..., 0]).all()
    assert np.isfinite(found.y[..., 1]).sum() == 20
    assert reread(found).counts == found.counts


def test_outputs_that_all_fail_too_often_are_an_error():
    inputs = [Input(f"x_{k}", lower=0.0, upper=1.0) for k in range(8)]
    model = Model(
        lambda x: np.where(x > 0.3, np.nan, x), inputs, [Output("y", axis=range(8))], batched=True
    )
    with pytest.raises(ModelError, match="each output failed in more than three quarters"):
        kneecore.influence(model, InfluenceSettings(n_base=64, intervals=False))
