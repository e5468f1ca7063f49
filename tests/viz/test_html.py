import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from searches import searched

from kneecore import NAMES, Knee, ParameterSpace, simulate
from kneeviz.geometry.mechanism import Pose
from kneeviz.views import theme
from kneeviz.views.html import labels, pieces, readout
from kneeviz.views.html.comparison import comparison
from kneeviz.views.html.marks import marks_line, signs
from kneeviz.views.html.result import bound_names, differences, evidence_line, objective_line

EVIL = '<img src=x onerror="alert(1)">'


def text_of(html):
    return re.sub(r"<[^>]*>", " ", html)


@pytest.fixture(scope="module")
def result():
    return searched(pop_size=60, n_generations=200, seed=1)


def test_numbers():
    assert pieces.number(-3.724, 1, "°") == "\u22123.7°"
    assert pieces.number(-0.04, 1, "N") == "0.0 N"
    assert pieces.number(float("nan"), 1) == "\u2013"


@pytest.mark.parametrize(
    ("angle", "words"), [(-3.0, "over-extended"), (0.2, "straight"), (30.0, "flexed")]
)
def test_angle_words(angle, words):
    assert readout.angle_words(angle) == words


def test_foreign_text_is_escaped_everywhere():
    assert "<img" not in pieces.escape(EVIL)
    assert "<img" not in pieces.command_line(EVIL)
    assert "<img" not in pieces.status(pieces.escape(EVIL))


def test_readout_shows_angle_moment_and_tensions():
    pose = Pose(
        flexion=np.deg2rad(24.88), moment=0.8, tibia_position=np.zeros(2),
        tension=np.array([38.5, 14.3, 0.0, 79.7]), contact_force=115.0,
    )  # fmt: skip
    text = text_of(readout.readout(pose, theme.LIGHT))
    for words in ("24.9°", "flexed", "+0.80 N·m", "extending", "38 N", "14 N", "0 N", "80 N"):
        assert words in text
    timed = readout.readout(Pose(**{**vars(pose), "time": 3.25}), theme.LIGHT)
    assert "3.2 s" in text_of(timed)


def test_a_surrogates_objective_comes_with_the_true_models(result):
    text = text_of(objective_line(result))
    assert pieces.number(result.objective_surrogate, 0, "°") in text
    assert pieces.number(result.objective_model, 0, "°") in text
    assert "gap" in text


@pytest.mark.parametrize(("gap", "warned"), [(9.9, False), (10.1, True), (75.0, True)])
def test_a_wide_gap_is_warned_about_in_words(gap, warned):
    found = SimpleNamespace(
        objective_surrogate=400.0, objective_model=300.0, gap_percent=gap, model=Knee()
    )
    told = text_of(objective_line(found))
    assert "angles between the two summed over the loads" in told
    assert ("not to be trusted" in told) == warned


def test_an_objective_that_the_model_denies_is_not_hidden():
    failed = SimpleNamespace(
        objective_surrogate=400.0, objective_model=None, gap_percent=None, model=Knee()
    )
    assert "not known" in objective_line(failed)


def test_evidence_says_best_known_and_the_sampled_bound_with_its_condition():
    few = {"method": "exact", "objective": "extension"}
    plain = searched(ParameterSpace(case="material"), **few)
    told = text_of(evidence_line(plain))
    assert "Best known value, by climbs with gradients from 6 patterns of signs" in told
    assert "then flips of inputs in the model itself. Nothing is proven." in told
    assert "climbs end in the worst pair at rest" in told
    assert "slopes" not in told
    bounded = searched(ParameterSpace(case="material"), bound=True, **few)
    told = text_of(evidence_line(bounded))
    assert "6 of 6 slopes at rest keep their sign" in told
    assert "2 vertices of the others: at most" in told
    assert "sampled bound, if slopes stay within 5 % of their sampled range" in told
    assert evidence_line(searched(pop_size=20, n_generations=2)) == ""


def test_differences_are_the_results(result):
    text = text_of(differences(result, theme.LIGHT))
    one, two = (
        np.degrees(r.flexion[5]) for r in (result.responses["model_1"], result.responses["model_2"])
    )
    assert pieces.number(one, 1, "°") in text
    assert pieces.number(two, 1, "°") in text
    assert pieces.number(result.responses["model_2"].tension[5, 1], 0, "N") in text
    counts = (result.model.space.at_bounds(result.x[0]) != 0).sum()
    assert f"{counts} of 28" in text


def test_opposite_bounds_are_named(result):
    text = bound_names(result)
    sides = np.stack([result.model.space.at_bounds(x) for x in result.x]).astype(int)
    opposite = [NAMES[i] for i in np.flatnonzero(sides[0] * sides[1] < 0)]
    assert f"({len(opposite)})" in text
    assert labels.parameter_label(opposite[0]) in text


def test_comparison_has_every_parameter_and_places_dots_in_the_bounds():
    space = ParameterSpace()
    html = comparison(
        space,
        [("baseline", "#111111", space.baseline), ("yours", "#222222", space.upper),
         ("model 1", "#333333", None)],
    )  # fmt: skip
    for name in NAMES:
        assert labels.parameter_label(name) in html
    assert html.count("left:100.0%") == 28
    assert "model 1" not in html
    assert "11.20" in html  # acl_tibia_x at its upper bound, mm


def test_training_knees_join_the_key_of_the_curve_only():
    assert "training" in readout.legend(theme.LIGHT, overlays=False, curve=True)
    assert "training" not in readout.legend(theme.LIGHT, overlays=False, curve=False)
    assert "model 2" in readout.legend(theme.LIGHT, overlays=True, curve=False)
    assert "99.7" not in readout.legend(theme.LIGHT, overlays=True, curve=True)
    banded = readout.legend(theme.LIGHT, overlays=False, curve=True, band="2,000 samples")
    assert "99.7 % band" in banded
    assert "2,000 samples" in banded


def test_error_line_tells_both_errors():
    text = text_of(readout.error_line((0.34, 0.71), 0.82))
    for words in ("0.3°", "0.7°", "0.8°"):
        assert words in text
    assert "not ready" in readout.error_line(None, None)


def test_a_sparkline_rises_with_its_values():
    line = pieces.sparkline([1.0, 2.0, 5.0], "#000")
    heights = [float(y) for y in re.findall(r",([\d.]+)", line)]
    assert heights == sorted(heights, reverse=True)
    assert pieces.sparkline([1.0], "#000") == ""


def at(*loads):
    marked = np.zeros(12, dtype=bool)
    marked[list(loads)] = True
    return marked


def test_marks_stand_behind_angles_and_below_the_chart_with_their_meaning():
    knee = simulate(ParameterSpace().baseline)
    marked = replace(knee, settled=~at(0), at_rest=~at(0, 6), implausible=at(5))
    line = marks_line(marked)
    assert re.sub(r" +", " ", text_of(line)).strip() == (
        "Your knee: * not settled at +0.1 N·m; ~ not yet at rest at +0.1, \u22120.1 N·m; "
        "! implausible at +5 N·m."
    )
    assert [text_of(signs(marked, k)).split() for k in (0, 1, 5, 6)] == [
        ["*", "~"],
        [],
        ["!"],
        ["~"],
    ]
    for told in (line, signs(marked, 0)):
        assert told.count("title=") == told.count("cursor:help") > 0
        assert "not within 0.1 deg of the same knee&#x27;s equilibrium" in told


def test_nothing_is_marked_of_a_knee_without_marks():
    knee = simulate(ParameterSpace().baseline)
    still = replace(knee, settled=~at(), at_rest=~at(), implausible=at())
    failed = replace(knee, refinements=-1, flexion=np.full(12, np.nan))
    assert [marks_line(one) for one in (None, still, failed)] == ["", "", ""]
    assert signs(failed, 0) == ""
