"""Our quantities beside the paper's claims, on knees and searches made up for the purpose."""

import dataclasses

import numpy as np
import pytest

import kneecore
from kneecore import ParameterSpace
from kneecore.paper.claims import packaged_paper
from kneecore.paper.experiments import PAPER_BUDGET
from kneecore.paper.geometry_changes import ATTACHMENTS, geometry_changes, ligament_lines
from kneecore.paper.measures import MEASURES
from kneecore.paper.measures.knees import ap_slopes
from kneecore.paper.verdict import judge

BY_ID = {claim.id: claim for claim in packaged_paper().claims}


PAIR = ("model_1", "model_2")


def with_responses(worst, responses, **changes):
    """A search that has found knees with other responses."""
    return dataclasses.replace(worst, responses={**worst.responses, **responses}, **changes)


def test_figure_2_sees_a_shift_along_and_across_the_plateau(report):
    worst = report.experiments.main
    baseline = worst.responses["baseline"]
    along = np.radians(-54.79 + 9.0)  # the baseline's plateau in the load-free pose
    for direction, expected in ((along, (1.0, 0.0)), (along + np.pi / 2.0, (0.0, 1.0))):
        x = np.array([worst.model.nominal] * 2)
        for axis, part in (("x", np.cos(direction)), ("y", np.sin(direction))):
            x[0, kneecore.NAMES.index(f"acl_femur_{axis}")] += 1e-3 * part
        x[1, kneecore.NAMES.index("lcl_stiffness")] *= 1.07
        moved, stiff = geometry_changes(with_responses(worst, dict.fromkeys(PAIR, baseline), x=x))
        k = ATTACHMENTS.index("acl_femur")
        assert (moved.along_mm[k], moved.across_mm[k]) == pytest.approx(expected, abs=1e-9)
        assert np.delete(moved.along_mm, k) == pytest.approx(np.zeros(7), abs=1e-9)
        assert np.flatnonzero(np.abs(moved.angle_deg) > 1e-9).tolist() == [0]
        assert stiff.stiffness_percent == pytest.approx([0.0, 0.0, 0.0, 7.0])


def test_a_ligament_turns_as_far_as_the_law_of_cosines_says(report):
    """Independent: the angle between the two lines by their lengths and that of the gap."""
    worst = report.experiments.main
    x = np.array([worst.model.nominal] * 2)
    x[0, kneecore.NAMES.index("mcl_femur_x")] += 2e-3
    same = worst.responses["baseline"]
    turned, _ = geometry_changes(with_responses(worst, dict.fromkeys(PAIR, same), x=x))
    before = same.rest_length[2]
    after = kneecore.simulate(x[0]).rest_length[2]
    cosine = (before**2 + after**2 - (2e-3) ** 2) / (2.0 * before * after)
    assert abs(turned.angle_deg[2]) == pytest.approx(np.degrees(np.arccos(cosine)), rel=1e-4)


def made(report, *, x=None, space=None, **responses):
    """Experiments whose main search found something else, or began somewhere else."""
    done = report.experiments
    main_search = with_responses(done.main, responses, **({} if x is None else {"x": x}))
    return dataclasses.replace(
        done,
        knee=done.knee if space is None else done.knee.with_space(space),
        cases={**done.cases, "both": main_search},
        repeats=(main_search, *done.repeats[1:]),
    )


def knee_with(response, angles_deg, **ligaments):
    """A response with these angles in extension, and tensions as functions of the angle."""
    flexion = np.radians(np.r_[angles_deg, np.linspace(60.0, 120.0, 6)])
    tension = np.zeros((12, 4))
    for name, of_angle in ligaments.items():
        tension[:, kneecore.LIGAMENTS.index(name)] = of_angle(np.degrees(flexion))
    return dataclasses.replace(response, flexion=flexion, tension=tension)


def taut(angle):
    return np.maximum(54.79 - angle, 0.0)


def test_forces_at_an_angle_are_read_off_the_curve(report):
    """Linear curves, so that what lies between two loads is known."""
    response = report.experiments.main.responses["baseline"]
    baseline = knee_with(response, [50, 40, 30, 20, 10, 0], pcl=taut, lcl=lambda a: 2.0 * taut(a))
    model_1 = knee_with(response, [45, 35, 20, 5, -5, -25], pcl=taut, acl=lambda a: 0.5 * taut(a))
    model_2 = knee_with(response, [50, 45, 40, 35, 25, 15], pcl=lambda a: 3.0 * taut(a), acl=taut)
    done = made(report, baseline=baseline, model_1=model_1, model_2=model_2)
    assert MEASURES["force_ratio_at_minus_10_deg"](done) == pytest.approx(64.79 / (2 * 54.79))
    assert MEASURES["early_pcl_ratio"](done) == pytest.approx(3.0)
    assert MEASURES["model_1_extension_deg"](done) == pytest.approx(-25.0)
    assert MEASURES["model_2_extension_deg"](done) == pytest.approx(15.0)
    stiff = made(report, model_1=knee_with(response, [50, 40, 30, 20, 10, -9], pcl=taut))
    assert np.isnan(MEASURES["force_ratio_at_minus_10_deg"](stiff))  # it never gets there


@pytest.mark.parametrize(("below", "above"), [(2.0, 5.0), (7.0, 3.0), (4.0, -1.0), (-2.0, 6.0)])
def test_beyond_sampling_is_what_the_nearer_knee_lies_outside(report, below, above):
    done = report.experiments
    spread, load = done.sampling.y, int(np.argmax(kneecore.MOMENT))
    knees = {}
    for name, angle in (
        ("model_1", spread.mean[load] - 3.0 * spread.sd[load] - below),
        ("model_2", spread.mean[load] + 3.0 * spread.sd[load] + above),
    ):
        response = done.main.responses[name]
        flexion = response.flexion.copy()
        flexion[load] = np.radians(angle)
        knees[name] = dataclasses.replace(response, flexion=flexion)
    found = MEASURES["beyond_sampling_deg"](made(report, **knees))
    assert found == pytest.approx(min(below, above))


def test_ligaments_cross_as_geometry_says(report):
    """With two crossing lines, those that join the ends the other way round do not cross."""
    response = report.experiments.main.responses["baseline"]
    names = kneecore.NAMES
    acl, pcl = (
        [names.index(f"{ligament}_femur_{axis}") for axis in "xy"] for ligament in ("acl", "pcl")
    )
    swapped = np.array(ParameterSpace().baseline)
    swapped[acl + pcl] = swapped[pcl + acl]
    short = np.array(ParameterSpace().baseline)
    femur, tibia = ligament_lines(short, response.load_free_position)[0]
    short[acl] = tibia + 0.02 * (femur - tibia)  # it ends before it reaches the other
    for x in (swapped, short):
        done = made(report, space=ParameterSpace(baseline=x))
        assert MEASURES["cruciates_cross"](done) == 0.0


def test_searches_are_compared_by_their_true_values(report):
    done = report.experiments
    values = {"objective_surrogate": 120.0, "objective_model": 90.0}
    surrogate = tuple(dataclasses.replace(run, **values) for run in done.surrogate_runs)
    model = tuple(dataclasses.replace(run, objective_model=100.0) for run in done.model_runs)
    done = dataclasses.replace(done, surrogate_runs=surrogate, model_runs=model)
    assert MEASURES["surrogate_to_model_percent"](done) == pytest.approx([90.0, 90.0])


def test_the_slope_ratio_is_beyond_over_before(report):
    knee = report.experiments.main.responses["baseline"]
    angles = np.degrees(knee.flexion)
    moved = np.where(angles < 54.79, -0.1, -0.4) * (angles - 54.79) - 8.1
    made_up = dataclasses.replace(knee, ap_position=1e-3 * moved)
    assert ap_slopes(made_up) == pytest.approx((-0.1, -0.4))
    done = made(report, baseline=made_up)
    assert MEASURES["ap_slope_ratio"](done) == pytest.approx(4.0)


def test_the_experiments_are_the_papers(report):
    done = report.experiments
    assert {name: run.model.space.case for name, run in done.cases.items()} == {
        name: name for name in ("both", "geometry", "material")
    }
    assert [run.settings.seed for run in done.repeats] == [0, 1, 2]
    assert [run.settings.seed for run in done.geometry_repeats] == [0, 1, 2]
    assert {name: run.model.space.case for name, run in done.exact.items()} == {
        name: name for name in ("both", "geometry")
    }
    assert all(run.settings.method == "exact" for run in done.exact.values())
    assert all(run.settings.training_samples == 100 for run in done.larger_runs)
    for runs, where in ((done.surrogate_runs, "surrogate"), (done.model_runs, "model")):
        assert [run.settings.seed for run in runs] == [0, 1]
        assert all(run.settings.search_space == where for run in runs)
    full = PAPER_BUDGET
    assert (full.pop_size, full.n_generations) == (200, 800)
    assert (full.validation_size, full.n_validation, full.n_samples) == (100, 4, 10_000)


def test_measures_tell_what_the_experiments_hold(report):
    done = report.experiments
    worst = done.main
    assert MEASURES["baseline_flexion_deg"](done) == pytest.approx(118.986, abs=1e-3)
    assert MEASURES["baseline_cruciate_force_n"](done) == pytest.approx(286.9, abs=0.1)
    assert MEASURES["cruciates_cross"](done) == 1.0
    ordered = np.count_nonzero(np.less(*(worst.responses[name].flexion for name in PAIR)))
    assert MEASURES["loads_in_order"](done)[1] == ordered
    assert MEASURES["gap_percent"](done)[0] == worst.gap_percent
    share = done.cases["material"].objective_model / worst.objective_model
    assert MEASURES["material_share"](done) == share


def test_a_failed_worst_case_makes_no_claim_agree(report):
    done = report.experiments
    model_1 = done.main.responses["model_1"]
    nothing = {
        field.name: np.full_like(value, np.nan)
        for field in dataclasses.fields(model_1)
        if isinstance(value := getattr(model_1, field.name), np.ndarray)
        and value.dtype == np.float64
        and field.name not in ("moment", "load_free_position", "rest_length")
    }
    failed = dataclasses.replace(model_1, refinements=-1, **nothing)
    main_search = with_responses(done.main, {"model_1": failed}, objective_model=None)
    done = dataclasses.replace(done, cases={**done.cases, "both": main_search})
    for name in ("over_extends", "small_forces", "geometry_decides"):
        claim = BY_ID[name]
        assert judge(claim, MEASURES[claim.measure](done)).outcome == "cannot be compared"
