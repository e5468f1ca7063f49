"""Evidence where models fail: it is written, reads back, and says what it can."""

import json
from math import inf

import pytest

import kneecore
from kneecore.files.evidence import evidence_table, read_evidence
from kneecore.report.evidence import evidence_lines
from kneecore.search.result import Evidence


def _evidence(n_failed):
    return Evidence(
        n_climbs=10,
        share_reached=0.5,
        second_best=None,
        patterns=(((1, 1), 2.0), ((1, -1), -inf)),
        n_evaluations=100,
        n_failed=n_failed,
    )


def test_a_pattern_without_a_model_reads_back():
    text = json.dumps(evidence_table(_evidence(5), 10), allow_nan=False)
    assert vars(read_evidence(json.loads(text))) == vars(_evidence(5))


@pytest.mark.parametrize(("n_failed", "told"), [(0, False), (1, False), (5, True)])
def test_wide_bounds_are_told(n_failed, told):
    model = kneecore.Knee(kneecore.ParameterSpace(), solver="equilibrium")
    text = " ".join(evidence_lines(model, _evidence(n_failed)))
    assert "No proof" in text
    assert ("best known value" in text) is told
