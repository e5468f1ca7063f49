"""The audit of the time step: half of it, on knees whose answer is known both ways."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kneecore import Knee, ParameterSpace, simulate
from kneecore.cli import simulate as command
from kneecore.files.response import read_response, response_table
from kneecore.knee.physics.dynamics import attempt, flexion_of, respond_by_run
from kneecore.knee.response import prepare
from kneecore.knee.step_check import half_step_change, with_half_step
from kneecore.report.step_check import step_lines

BASELINE = ParameterSpace().baseline
WIDE = ParameterSpace(geometry_bound_mm=2, slope_bound_deg=2, material_bound_percent=20)


def test_half_the_step_is_what_it_says():
    change = half_step_change(BASELINE)[0]
    half = attempt(prepare(BASELINE, None, "recomputed"), np.array([0, 1]), 1)
    whole = simulate(BASELINE).flexion
    assert change == pytest.approx(flexion_of(half.poses).ravel() - whole, abs=1e-15)
    assert np.degrees(np.abs(change)).max() < 0.05


def test_a_refined_run_is_audited_with_half_of_its_own_step():
    x = WIDE.from_unit(np.round(np.random.default_rng(0).random((400, 28))))
    rows = prepare(x, None, "fixed")
    _, _, halvings = respond_by_run(rows)
    change = Knee(WIDE, rest_length="fixed").half_step_change(x)
    failed = halvings.min(axis=1) < 0
    assert (np.isnan(change).any(axis=1) == failed).all()
    i = int(np.flatnonzero((halvings.max(axis=1) == 1) & ~failed)[0])
    run = 2 * i + int(halvings[i, 1] == 1)
    turns = [flexion_of(attempt(rows, np.array([run]), n).poses)[0] for n in (1, 2)]
    own = change[i].reshape(2, 6)[run % 2]
    assert own == pytest.approx(turns[1] - turns[0], abs=1e-14)


def made_up(moved_deg):
    knee = with_half_step(simulate(BASELINE), BASELINE)
    change = np.zeros(12)
    change[6] = np.radians(moved_deg)
    return replace(knee, half_step_change=change)


@pytest.mark.parametrize(
    ("moved", "words"),
    [
        (0.049, "moves no angle by more than 0.05 deg (model 1 at -0.1 N m: 0.049 deg)."),
        (-0.051, "moves an angle by more than 0.05 deg: model 1 at -0.1 N m, 0.051 deg."),
        (np.inf, "moves an angle by more than 0.05 deg: model 1 at -0.1 N m, out of all bounds."),
    ],
)
def test_the_report_says_so_when_an_angle_moves(moved, words):
    knees = {"baseline": simulate(BASELINE), "model_1": made_up(moved)}
    assert step_lines(knees) == ["Half the time step " + words]
    assert step_lines({"baseline": simulate(BASELINE)}) == []


def test_files_keep_the_audit():
    knee = made_up(0.3)
    back = read_response(json.loads(json.dumps(response_table(knee))))
    assert back.half_step_change == pytest.approx(knee.half_step_change, abs=1e-15)
    assert read_response(response_table(simulate(BASELINE))).half_step_change is None


def test_the_command_tells_and_refuses(capsys):
    assert command.main(["--check-step"]) == 0
    assert "Half the time step moves no angle" in capsys.readouterr().out
    assert command.main(["--check-step", "--json"]) == 0
    assert max(map(abs, json.loads(capsys.readouterr().out)["half_step_change_deg"])) < 0.05
    assert command.main(["--check-step", "--solver", "equilibrium"]) == 2
    assert "has no time step" in capsys.readouterr().err
