"""The measures of worst-case pairs, on pairs made up so that the answer is known both ways."""

import dataclasses

import numpy as np
import pytest

import kneecore
from kneecore import MOMENT
from kneecore.paper.claims import packaged_paper
from kneecore.paper.finding import Finding
from kneecore.paper.measures import MEASURES
from kneecore.paper.turned_round import turned_round_percent
from kneecore.paper.verdict import judge

BY_ID = {claim.id: claim for claim in packaged_paper().claims}
SLOPE = np.radians(-54.79 + 9.0)
ALONG = np.array([np.cos(SLOPE), np.sin(SLOPE)])
ACROSS = np.array([-ALONG[1], ALONG[0]])


def experiments(report, search=None, geometry=None, **changes):
    """Experiments in which every pair is `search`, and every one of the geometry `geometry`."""
    done = report.experiments
    if search is not None:
        changes |= {
            "cases": {**done.cases, "both": search},
            "repeats": (search,) * len(done.repeats),
            "exact": {**done.exact, "both": search},
        }
    if geometry is not None:
        changes["exact"] = {**changes.get("exact", done.exact), "geometry": geometry}
        changes["geometry_repeats"] = (geometry,) * len(done.geometry_repeats)
    return dataclasses.replace(done, **changes)


def pair(report, one=(), two=()):
    """A pair of knees that are the baseline but for these (name, change) in SI, simulated."""
    worst = report.experiments.main
    x = np.array([worst.model.nominal] * 2)
    for row, changes in zip(x, (one, two), strict=True):
        for name, change in changes:
            row[kneecore.NAMES.index(name)] += change
    baseline, *knees = (kneecore.simulate(k) for k in (worst.model.nominal, *x))
    responses = dict(zip(("baseline", "model_1", "model_2"), (baseline, *knees), strict=True))
    y = np.degrees([knee.flexion for knee in knees])
    f = float(np.abs(y[0] - y[1]).sum())
    return dataclasses.replace(worst, x=x, y=y, responses=responses, objective_model=f)


def curves(report, one=None, two=None, baseline=None):
    """A pair with made-up responses; arguments are changes to the baseline's response."""
    worst = report.experiments.main
    usual = dataclasses.replace(worst.responses["baseline"], **(baseline or {}))
    made = {"baseline": usual}
    for name, change in (("model_1", one), ("model_2", two)):
        made[name] = dataclasses.replace(usual, **(change or {}))
    y = np.degrees([made["model_1"].flexion, made["model_2"].flexion])
    return dataclasses.replace(worst, responses=made, y=y)


def shift(point, direction, mm=1.0):
    """Changes that move a point of the femur."""
    return [
        (f"{point}_{axis}", 1e-3 * mm * part) for axis, part in zip("xy", direction, strict=True)
    ]


def verdict(report_or_done, claim, **made):
    """The claim's verdict on experiments."""
    return judge(BY_ID[claim], MEASURES[BY_ID[claim].measure](report_or_done, **made))


def outcomes(report, claim, holds, does_not):
    """The outcomes of a claim on a search that fulfils it and one that does not."""
    return [verdict(experiments(report, search), claim).outcome for search in (holds, does_not)]


BOTH_WAYS = ["agrees", "differs"]


# Figure 2


@pytest.mark.parametrize(
    ("claim", "ligament", "direction"),
    [("mcl_against_circle", "mcl", ALONG), ("acl_against_circle", "acl", ACROSS)],
)
def test_a_ligament_against_the_circle(report, claim, ligament, direction):
    def moved(side):
        # The tibia's place hangs on the circle: the attachment there is moved back by as much.
        return [*shift("condyle", direction, 0.4), *shift(f"{ligament}_femur", direction, side)]

    def back(changes):
        return [(name, -change) for name, change in changes]

    against, along = (pair(report, moved(side), back(moved(side))) for side in (-2.0, 2.0))
    assert outcomes(report, claim, against, along) == BOTH_WAYS
    half = pair(report, moved(-2.0), moved(2.0))
    assert verdict(experiments(report, half), claim).values.tolist() == [1.0] * 4


def test_turns_of_the_ligaments(report):
    collaterals = [("mcl_femur_x", 5e-3), ("lcl_femur_x", 3e-3)]
    cruciates = [("acl_femur_x", 3e-3), ("pcl_femur_x", 3e-3)]
    seen = pair(report, collaterals, collaterals)
    other = pair(report, cruciates, collaterals)
    for claim in ("cruciates_hardly_turn", "collaterals_turn_more"):
        assert outcomes(report, claim, seen, other) == BOTH_WAYS
    one_still = pair(report, collaterals, [("mcl_femur_x", 5e-3), ("acl_femur_x", 1e-3)])
    assert verdict(experiments(report, one_still), "collaterals_turn_more").outcome == "differs"


def test_the_plateau_turns_symmetrically(report):
    deg = np.radians(1.0)
    symmetric = pair(report, [("plateau_slope", deg)], [("plateau_slope", -deg)])
    same = pair(report, [("plateau_slope", deg)], [("plateau_slope", deg)])
    partly = pair(report, [("plateau_slope", deg)], [("plateau_slope", -0.5 * deg)])
    assert outcomes(report, "plateau_symmetric", symmetric, same) == BOTH_WAYS
    assert verdict(experiments(report, partly), "plateau_symmetric").values == pytest.approx(
        [200.0 / 3.0] * 4
    )


@pytest.mark.parametrize(
    ("claim", "column", "good", "bad"),
    [
        ("acl_softer", 0, (-1, -1), (-1, 1)),
        ("pcl_softer", 1, (-1, -1), (1, 1)),
        ("mcl_stiffer", 2, (1, 1), (1, -1)),
        ("lcl_differs", 3, (1, -1), (1, 1)),
    ],
)
def test_stiffness_signs_and_what_is_indifferent(report, claim, column, good, bad):
    """The change of f that a turn makes decides between differing and being indifferent."""
    name = f"{kneecore.LIGAMENTS[column]}_stiffness"

    def signed(signs):
        return pair(report, *([(name, 1e6 * sign)] for sign in signs))

    done = report.experiments
    for percent, told in ((2.0, "differs"), (-0.1, "indifferent"), (np.nan, "differs")):
        turned = np.zeros_like(done.turned_percent)
        turned[:, :, column] = percent
        right = experiments(report, signed(good), turned_percent=turned)
        wrong = experiments(report, signed(bad), turned_percent=turned)
        assert verdict(right, claim).outcome == "agrees"
        assert verdict(wrong, claim).outcome == told
    assert (
        "+2.00 %"
        in verdict(
            experiments(report, signed(bad), turned_percent=np.full_like(turned, 2.0)), claim
        ).why
    )


def test_only_what_speaks_against_a_sign_has_to_be_indifferent(report):
    """The knee whose side is as the paper says may move f by any amount."""
    done = report.experiments
    search = pair(report, [("acl_stiffness", -1e6)], [("acl_stiffness", 1e6)])
    turned = np.zeros_like(done.turned_percent)
    turned[:, 0, 0] = 9.0
    assert verdict(experiments(report, search, turned_percent=turned), "acl_softer").outcome == (
        "indifferent"
    )


def test_turning_a_stiffness_round_is_one_more_simulation(report):
    """Independent: the mirrored knee simulated by itself."""
    knee = report.experiments.knee
    search = pair(report, [("mcl_stiffness", 1e6), ("condyle_x", 1e-3)], [("lcl_femur_y", 1e-3)])
    found = turned_round_percent(knee, (search, search))
    assert found.shape == (2, 2, 4)
    x = search.x[0].copy()
    x[kneecore.NAMES.index("mcl_stiffness")] -= 2e6
    f = np.abs(np.degrees(kneecore.simulate(x).flexion) - search.y[1]).sum()
    assert found[1, 0, 2] == pytest.approx(100.0 * (f / search.objective_model - 1.0), abs=1e-9)
    assert found[0, 1] == pytest.approx(np.zeros(4), abs=1e-9)  # it was not off the baseline


def test_the_geometrys_case_differs_in_the_lcl_alone(report):
    both = pair(report)
    lcl = pair(report, [("lcl_femur_x", 1e-3)])
    for changes, met in (
        ([("lcl_femur_x", 1e-3)], 2.0),
        ([], 1.0),
        ([("lcl_femur_x", 1e-3), ("acl_tibia_x", 1e-3)], 1.0),
        ([("condyle_radius", 1e-3)], 1.0),  # the tibia makes room, and the LCL's end with it
        ([("acl_femur_x", 1e-3)], 0.0),
        ([("plateau_slope", np.radians(2.0))], 0.0),
        ([("lcl_femur_x", 0.3e-3)], 1.0),
    ):
        done = experiments(report, both, geometry=pair(report, changes))
        assert verdict(done, "geometry_only_lcl").values.tolist() == [met] * 4
    assert verdict(experiments(report, both, geometry=lcl), "geometry_only_lcl").outcome == "agrees"
    assert verdict(experiments(report, both, geometry=both), "geometry_only_lcl").outcome == (
        "differs"
    )


# Curves


def test_loads_in_order_are_counted(report):
    flexion = report.experiments.main.responses["baseline"].flexion
    good = curves(report, {"flexion": flexion - 0.1}, {"flexion": flexion + 0.1})
    crossed = curves(report, {"flexion": flexion - 0.1 * np.sign(MOMENT)})
    assert outcomes(report, "order_kept", good, crossed) == BOTH_WAYS
    assert verdict(experiments(report, crossed), "order_kept").values.tolist() == [6.0] * 4


def test_forces_change_roles_in_flexion(report):
    tension = report.experiments.main.responses["baseline"].tension
    tight, slack = {"tension": 2.0 * tension}, {"tension": 0.5 * tension}
    good, bad = curves(report, tight, slack), curves(report, slack, tight)
    assert outcomes(report, "flexion_forces_reversed", good, bad) == BOTH_WAYS
    half = curves(report, tight, tight)
    assert (
        verdict(experiments(report, half), "flexion_forces_reversed").values.tolist() == [1.0] * 4
    )
    # Only in flexion: what happens in extension does not count.
    side = np.where(MOMENT > 0.0, 0.5, 2.0)[:, None]
    good = curves(report, {"tension": side * tension}, {"tension": tension / side})
    assert verdict(experiments(report, good), "flexion_forces_reversed").outcome == "agrees"


def test_both_worst_cases_keep_the_change_of_slope(report):
    angles = np.degrees(report.experiments.main.responses["baseline"].flexion) - 54.79

    def bent(before, beyond):
        return {"ap_position": 1e-3 * np.where(angles < 0.0, before, beyond) * angles}

    good = curves(report, bent(-0.1, -0.4), bent(-0.3, -0.5))
    bad = curves(report, bent(-0.1, -0.4), bent(-0.5, -0.3))
    assert outcomes(report, "ap_slope_worst", good, bad) == BOTH_WAYS
    forward = curves(report, bent(-0.1, -0.4), bent(0.1, 0.4))
    assert verdict(experiments(report, forward), "ap_slope_worst").outcome == "differs"


def test_ranges_and_positions_change(report):
    usual = report.experiments.main.responses["baseline"]
    width = np.ptp(usual.ap_position)
    wider = {
        "flexion": usual.flexion + 0.1 * np.ptp(usual.flexion) * np.sign(-MOMENT),
        "ap_position": usual.ap_position + 0.1 * width * np.sign(MOMENT),
    }
    good, bad = curves(report, wider, wider), curves(report, wider)
    assert outcomes(report, "ranges_change", good, bad) == BOTH_WAYS
    assert verdict(experiments(report, good), "ranges_change").values == pytest.approx([10.0] * 4)
    near, far = (
        curves(report, None, {"ap_position": usual.ap_position + share * width})
        for share in (0.1, 0.3)
    )
    assert outcomes(report, "ap_no_major_difference", near, far) == BOTH_WAYS
    assert verdict(experiments(report, far), "ap_no_major_difference").values == pytest.approx(
        [30.0] * 4
    )


def at_bounds(report, extension, flexion):
    """A pair at so many half-widths of the sampled bounds from the mean."""
    spread = report.experiments.sampling.y
    reach = 3.0 * spread.sd * np.where(MOMENT > 0, extension, flexion)
    return curves(
        report,
        {"flexion": np.radians(spread.mean - reach)},
        {"flexion": np.radians(spread.mean + reach)},
    )


def test_worst_cases_as_bounds(report):
    good, bad = at_bounds(report, 1.8, 1.1), at_bounds(report, 1.2, 1.6)
    assert outcomes(report, "flexion_matches_sampling", good, bad) == BOTH_WAYS
    assert outcomes(report, "extension_exceeds_sampling", good, bad) == BOTH_WAYS
    assert verdict(experiments(report, good), "flexion_matches_sampling").values == pytest.approx(
        [10.0] * 4
    )
    narrow = at_bounds(report, 1.8, 0.5)
    assert verdict(experiments(report, narrow), "flexion_matches_sampling").outcome == "differs"


# Samples, surrogates, motion


def test_single_knees_at_both_ends_are_counted(report):
    spread = report.experiments.sampling.y
    lax = spread.mean + 1.5 * spread.sd * np.sign(-MOMENT)
    shifted = spread.mean - 1.5 * spread.sd
    none = np.array([spread.mean, shifted, np.full(12, np.nan)])
    found = [
        verdict(experiments(report, drawn=drawn), "no_knee_at_both_ends")
        for drawn in (none, np.vstack([none, lax]))
    ]
    assert [v.outcome for v in found] == BOTH_WAYS
    assert found[1].values.tolist() == [1.0]


def test_rank_and_times_and_sensitivity(report):
    done = report.experiments
    ranks = [
        verdict(experiments(report, rank_f=np.array(values)), "rank_kept").outcome
        for values in ([0.95, 0.97], [0.95, 0.5])
    ]
    assert ranks == BOTH_WAYS
    times = [
        verdict(
            experiments(
                report,
                larger_runs=tuple(
                    dataclasses.replace(run, seconds={"search": share * run.seconds["search"]})
                    for run in done.surrogate_runs
                ),
            ),
            "more_training_slower",
        ).outcome
        for share in (2.0, 0.5)
    ]
    assert times == BOTH_WAYS


def with_total(report, total):
    """Influence with these total indices for every load."""
    found = report.experiments.influence
    rows = np.tile(total, (12, 1))
    indices = dataclasses.replace(found.indices, total_order=rows)
    return dataclasses.replace(found, indices=indices)


def test_geometry_against_material(report):
    geometry = np.arange(28) < 22
    found = [
        verdict(
            experiments(report, influence=with_total(report, np.where(geometry, a, b))),
            "geometry_over_material",
        )
        for a, b in ((0.04, 0.01), (0.01, 0.1))
    ]
    assert [v.outcome for v in found] == BOTH_WAYS
    assert found[0].values == pytest.approx([22 * 0.04 / (6 * 0.01)])


def test_whether_the_change_tells_the_influence(report):
    space = report.experiments.knee.space
    total = with_total(report, np.linspace(0.0, 1.0, 28))
    width = space.upper - space.lower

    def apart(share):
        return dataclasses.replace(
            report.experiments.main, x=np.array([space.lower, space.lower + share * width])
        )

    alike, ranked = apart(np.ones(28)), apart(np.linspace(0.1, 1.0, 28))
    found = [
        verdict(experiments(report, search, influence=total), "cannot_name")
        for search in (alike, ranked)
    ]
    assert [v.outcome for v in found] == BOTH_WAYS
    assert found[1].values == pytest.approx([1.0] * 4)


def test_overshoot_is_what_a_load_swings_too_far(report):
    """Made-up motions: straight to the end, and a fifth of the turn too far on the way."""
    motion = report.experiments.motion
    found = []
    for peak in (1.0, 1.2):
        flexion = np.zeros_like(motion.flexion)
        for row, moments in zip(flexion, motion.moment, strict=True):
            starts = np.flatnonzero(np.diff(moments)) + 1
            for k, frames in enumerate(np.split(np.arange(len(row)), starts)[1:]):
                row[frames] = k + 1.0
                row[frames[len(frames) // 2]] = k + peak
        made = dataclasses.replace(motion, flexion=flexion)
        found.append(verdict(experiments(report, motion=made), "little_oscillation"))
    assert [v.outcome for v in found] == BOTH_WAYS
    assert found[1].values == pytest.approx([20.0])


# The rule


@pytest.mark.parametrize(
    ("values", "outcome"),
    [
        ([2, 2, 2, 0], "agrees"),
        ([2, 2, 0], "differs"),  # half of the seeds are no majority
        ([1, 2, 2, 2], "differs"),  # the exact optimum counts
        ([np.nan, 2, 2], "cannot be compared"),
        ([2, np.nan, 2], "agrees"),
    ],
)
def test_a_pair_claim_needs_the_exact_optimum_and_most_seeds(values, outcome):
    claim = BY_ID["mcl_against_circle"]
    assert judge(claim, values).outcome == outcome
    indifferent = judge(claim, Finding(values=np.array(values), indifferent=True))
    assert indifferent.outcome == ("indifferent" if outcome == "differs" else outcome)
