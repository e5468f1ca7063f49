"""The paper redone: claims, measures, verdicts, and the report as a reader gets it."""

import base64
import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from page import Page

import kneecore
from kneecore import (
    Cancelled,
    Knee,
    ParameterError,
    ParameterSpace,
    redo_paper,
)
from kneecore.knee.response import LARGEST_EXTENSION
from kneecore.paper.claims import packaged_paper
from kneecore.paper.measures import MEASURES
from kneecore.paper.verdict import OUTCOMES, judge
from kneecore.report.blocks import Heading, Paragraph, Table, to_html, to_markdown
from kneecore.report.influence import answer
from kneecore.report.paper import TIMES, report_blocks

CLAIMS = packaged_paper().claims
BY_ID = {claim.id: claim for claim in CLAIMS}


@pytest.fixture(scope="module")
def other_knee():
    """A knee of another make: a looser PCL, further forward, on a flatter plateau."""
    x = np.array(ParameterSpace().baseline)
    for name, factor in (("pcl_stiffness", 0.4), ("pcl_femur_x", 0.5), ("plateau_slope", 0.5)):
        x[kneecore.NAMES.index(name)] *= factor
    return ParameterSpace(baseline=x, title="Another <knee> | *own*")


@pytest.fixture(scope="module")
def other(other_knee):
    return redo_paper(Knee(other_knee), quick=True)


# The list of claims


def test_every_claim_can_be_judged_and_every_measure_is_used():
    assert len(BY_ID) == len(CLAIMS)
    assert {claim.measure for claim in CLAIMS} == set(MEASURES)
    assert set(TIMES) <= set(BY_ID)
    for claim in CLAIMS:
        assert claim.fit in ("fitted", "related", "not fitted")
        assert claim.section
        assert claim.statement
        assert claim.paper
        assert (claim.limit is None) == (claim.rule == "none")
        assert (claim.tolerance is None) == (claim.rule != "within")
        assert claim.note or claim.rule in ("among", "within")
        assert (claim.rule == "none") == claim.id.startswith("time_")


@pytest.mark.parametrize("claim", CLAIMS, ids=BY_ID)
def test_what_is_judged_is_what_the_table_shows_of_the_paper(claim):
    """A claim with a number of the paper's is held against just that number."""
    if claim.rule in ("among", "within"):
        numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", claim.paper)]
        assert not numbers or claim.limit in numbers


# Verdicts


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=6))
def test_a_verdict_follows_its_rule_for_any_values(values):
    low, high = min(values), max(values)
    expected = {
        "gap": low <= 4.0 <= high,
        "flexion": low >= 117.0 and high <= 121.0,
        "geometry_decides": low > 0.9,
        "material_small": high < 0.2,
    }
    for name, agrees in expected.items():
        assert judge(BY_ID[name], values).outcome == ("agrees" if agrees else "differs")


@pytest.mark.parametrize("claim", [c for c in CLAIMS if c.rule != "none"], ids=lambda c: c.id)
def test_each_judged_claim_can_agree_and_can_differ(claim):
    values = np.concatenate([claim.limit + np.array([-1e3, 0.0, 1e3]), [claim.limit]])
    assert {judge(claim, [value] * 3).outcome for value in values} == {"agrees", "differs"}


def test_what_failed_is_left_out_and_told():
    claim = BY_ID["gap"]
    some = judge(claim, [np.nan, 3.0, 5.0])
    assert some.outcome == "agrees"
    assert "1 of 3 searches ended in a failed model" in some.why
    assert "2 seeds" in some.ours
    none = judge(claim, [np.nan, np.inf])
    assert none.outcome == "cannot be compared"
    assert none.ours == "no value"
    assert none.why == "No model gave an answer."


@pytest.mark.parametrize("claim", [c for c in CLAIMS if c.rule == "none"], ids=lambda c: c.id)
def test_what_the_paper_does_not_tell_is_not_judged(claim):
    assert judge(claim, 1.0).outcome == "cannot be compared"


# The report


def test_a_quick_run_says_that_it_is_one(report):
    assert report.quick
    assert "preview" in report.markdown()
    assert "Quick" in str(report)
    assert repr(report) == f"PaperReport({report.summary()!r})"
    assert all(verdict.outcome in OUTCOMES for verdict in report.verdicts)
    times = [v for v in report.verdicts if v.claim.id.startswith("time_")]
    assert times
    assert all(v.ours == "no value" for v in times)  # of searches smaller than the claim names
    assert [verdict.claim for verdict in report.verdicts] == list(CLAIMS)


def test_what_was_not_fitted_is_counted_apart(report):
    free = [v for v in report.verdicts if v.claim.fit == "not fitted" and v.claim.rule != "none"]
    assert list(report.not_fitted) == free
    held = sum(v.outcome == "agrees" for v in free)
    assert 0 < held < len(free)
    for text in (report.markdown(), str(report), report.summary()):
        assert f"Of the {len(free)} that the packaged baseline" in text
        assert f"{held} agree" in " ".join(text.split())
    places = {v.claim.place for v in free}
    assert {"3.1, Fig. 2", "4.1"} <= places
    assert "3.1, Fig. 2" in report.markdown()


def test_the_reconstruction_and_both_machines_are_named(report):
    for text in (report.markdown(), report.html()):
        assert "reconstruction" in text.split("Verdicts")[0]
        assert "6800H" in text
        assert report.machine in text


def test_another_knee_gets_other_verdicts(report, other):
    """Nothing is written to agree: a knee that behaves otherwise is told so."""
    outcomes = [[v.outcome for v in one.verdicts] for one in (report, other)]
    assert outcomes[0] != outcomes[1]
    changed = {c.id for c, a, b in zip(CLAIMS, *outcomes, strict=True) if a != b}
    assert changed & {"flexion", "full_extension", "cruciate_force", "ap_slope"}


def test_what_the_paper_leaves_open_is_answered(report):
    found = report.experiments.influence
    assert answer(found) in report.html().replace("&#x27;", "'")
    assert found.deciding(LARGEST_EXTENSION, 1) == ["condyle_x"]


def test_a_surrogates_value_never_stands_alone(report):
    """Every search's row with a surrogate's f holds the true model's f as well."""
    (searches,) = (
        b for b in report_blocks(report) if isinstance(b, Table) and "f surrogate, deg" in b.columns
    )
    columns = list(searches.columns)
    predicted, true = columns.index("f surrogate, deg"), columns.index("f true model, deg")
    assert len(searches.rows) == 3 + 2 + 2 + 2 + 2 + 2 + 2
    for row in searches.rows:
        assert row[predicted] == "-" or re.fullmatch(r"\d+\.\d\d|failed", row[true])


def test_threads_change_no_verdict_but_those_on_times(report):
    again = redo_paper(Knee(threads=1), quick=True)
    for one, two in zip(report.verdicts, again.verdicts, strict=True):
        if one.claim.id not in TIMES:
            assert (one.claim, one.outcome, one.why) == (two.claim, two.outcome, two.why)
            np.testing.assert_array_equal(one.values, two.values)


def test_a_space_with_uncertain_rest_lengths_is_judged_too():
    space = ParameterSpace(rest_length_bound_mm=0.5)
    done = redo_paper(Knee(space), quick=True)
    assert "the rest lengths by 0.5 mm" in done.markdown()
    assert done.experiments.turned_percent.shape == (4, 2, 4)
    assert np.isfinite(MEASURES["change_tells_influence"](done.experiments)).all()


def test_the_page_needs_no_other_file_and_is_well_formed(report):
    page = Page(report.html())
    assert page.open == []
    assert len(page.images) == 8
    assert all(link.startswith("data:image/png;base64,") for link in page.links)
    for image in page.images:
        content = base64.b64decode(image["src"].partition(",")[2], validate=True)
        assert content.startswith(b"\x89PNG\r\n\x1a\n")
        assert image["alt"]
    assert "@import" not in report.html()
    assert "url(" not in report.html()


def test_a_title_of_ones_own_is_text_and_nothing_else(other):
    assert "Another &lt;knee&gt; | *own*" in other.html()
    assert r"Another \<knee\> \| \*own\*" in other.markdown()


@given(st.text(st.characters(blacklist_categories=("Cs", "Cc")), min_size=1, max_size=30))
@example("<b>&amp; | \\| <img src=x>")
def test_any_text_stays_in_its_cell(text):
    blocks = [Heading(text), Paragraph(text), Table(("a", "b"), [(text, "agrees")], marked=1)]
    row = to_markdown(blocks).rstrip("\n").splitlines()[-1]
    assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) == 3
    page = Page(to_html(text, blocks, {}))
    assert page.open == []
    assert page.images == []
    assert page.text.count(text) >= 4  # title, heading, paragraph, cell


def test_progress_is_told_and_can_cancel():
    told = []

    def stop_in_the_true_model(progress):
        told.append(progress)
        return "true model" in progress.stage

    with pytest.raises(Cancelled):
        redo_paper(quick=True, callback=stop_in_the_true_model)
    assert told[0].stage == "compile"
    assert all(0 <= t.done < t.total for t in told)
    assert [t.done for t in told] == sorted(t.done for t in told)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"knee": ParameterSpace()}, "knee"),
        ({"knee": Knee(solver="equilibrium")}, "knee"),
        ({"knee": Knee(rest_length="fixed")}, "knee"),
        ({"seed": -1}, "seed"),
        ({"quick": 1}, "quick"),
        ({"callback": 3}, "callback"),
    ],
)
def test_what_is_not_allowed_is_refused_at_once(arguments, named):
    with pytest.raises(ParameterError, match=f"`{named}`") as told:
        redo_paper(**arguments)
    assert "allowed" in str(told.value)
    assert "\n" not in str(told.value)
