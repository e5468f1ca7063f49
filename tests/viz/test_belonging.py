"""Nothing on the page belongs to something else: every change against every thing that is drawn."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from kneecore import Knee, packaged_knee
from kneeviz.page import belonging
from kneeviz.page.belonging import (
    ACCURACY,
    BAND,
    BASELINE,
    GHOSTS,
    INFLUENCE,
    KNEE,
    LANDSCAPE,
    METHODS,
    OTHERS,
    PAPER,
    PICTURES,
    SAMPLING,
    SURROGATE,
    TEXTS,
    WORST,
)
from kneeviz.state.bounds import Bounds
from kneeviz.state.ghosts import as_ghost
from kneeviz.state.knee import KneeState, Solved
from kneeviz.state.landscape import LandscapeState, Slice
from kneeviz.state.origin import digest, of_found
from kneeviz.state.shown import Band
from kneeviz.views import theme
from kneeviz.views.view import View

ALL_OF_THE_BOX = {WORST, BAND, SURROGATE, METHODS, SAMPLING, INFLUENCE, ACCURACY, LANDSCAPE}
KNEES_RULE = ALL_OF_THE_BOX | {KNEE, BASELINE, GHOSTS}


def page_with_everything():
    """A page on which all has been computed for what is set."""
    state = KneeState(packaged_knee())
    found = SimpleNamespace(model=Knee(state.space))
    carried = replace(state.origin(), bounds=None)
    solved = Solved(x=state.x.copy(), response=None, sweep=None, origin=carried)
    state.current, state.baseline = solved, replace(solved, origin=replace(carried, knee=None))
    state.surrogate = state.result = found
    landscape = LandscapeState(lambda *_: None)
    asked = Slice(
        x=state.x.copy(), knee=found.model, surrogate=None, names=landscape.names,
        own_deg=np.zeros(12), predicted_deg=None,
    )  # fmt: skip
    landscape.shown, landscape.found = True, (asked, None)
    none = np.zeros(12)
    return SimpleNamespace(
        state=state,
        unsolved=False,
        animation=SimpleNamespace(morphing=False),
        ghosts=(as_ghost(solved),),
        live=SimpleNamespace(keeps_up=False),
        band=Band(lower_deg=none, upper_deg=none, text="", origin=of_found(found)),
        methods=SimpleNamespace(found=found),
        study=SimpleNamespace(sampled=found, influence=found, accuracy=found, paper=found),
        landscape=landscape,
    )


def with_around(page):
    """The same with a live result, around a knee that is not the baseline."""
    page.state.x[0] += 1e-4
    around = SimpleNamespace(model=Knee(page.state.space_around_knee()))
    page.state.result, page.band = around, replace(page.band, origin=of_found(around))


def move_knee(page):
    page.state.x[3] += 1e-6


def other_baseline(page):
    knee = packaged_knee()
    baseline = knee.baseline.copy()
    baseline[0] += 1e-6
    page.state.take_box(replace(knee, baseline=baseline), page.state.bounds)


def bounds(**changes):
    def change(page):
        page.state.take_box(page.state.knee, Bounds(**changes))

    return change


CHANGES = {
    "knee": (move_knee, {KNEE, LANDSCAPE}),
    "baseline": (other_baseline, KNEES_RULE | {PAPER}),
    "geometry": (bounds(geometry_mm=0.9), ALL_OF_THE_BOX | {PAPER}),
    "slope": (bounds(slope_deg=0.9), ALL_OF_THE_BOX | {PAPER}),
    "material": (bounds(material_percent=9.0), ALL_OF_THE_BOX | {PAPER}),
    "case": (bounds(case="geometry"), ALL_OF_THE_BOX | {PAPER}),
    # A baseline of 28 values becomes one of 32.
    "rest lengths vary": (bounds(rest_length_mm=1.0), KNEES_RULE | {PAPER}),
    "rest lengths' rule": (bounds(rest_length="fixed"), KNEES_RULE),
    "landscape's axes": (lambda page: page.landscape.choose(0, "mcl_femur_x"), {LANDSCAPE}),
}
SUBJECTS = sorted(belonging.standing(page_with_everything()))


@pytest.mark.parametrize("subject", SUBJECTS)
@pytest.mark.parametrize("change", CHANGES)
def test_every_change_against_every_thing_drawn(change, subject):
    page, (make, stale) = page_with_everything(), CHANGES[change]
    state = page.state
    assert belonging.fits(page, subject)
    before = (state.x.copy(), state.knee, state.bounds, page.landscape.names)
    surrogate = state.surrogate
    make(page)
    state.surrogate = surrogate  # as under a hand that moves a bound on
    assert belonging.fits(page, subject) == (subject not in stale)
    state.x[:], page.landscape.names = before[0], before[3]
    state.space = before[2].space(before[1])
    state.knee, state.bounds = before[1], before[2]
    assert belonging.fits(page, subject)


@pytest.mark.parametrize("subject", [WORST, BAND])
def test_what_is_around_a_knee_is_stale_once_that_moves(subject):
    page = page_with_everything()
    with_around(page)
    assert belonging.fits(page, subject)
    move_knee(page)
    assert "knee" in belonging.changed(page, subject)
    page.live.keeps_up = True
    assert belonging.fits(page, subject)


def test_a_knee_on_its_way_is_not_stale():
    page = page_with_everything()
    move_knee(page)
    page.animation.morphing = True
    assert belonging.fits(page, KNEE)


def test_digests_differ_in_the_last_bit_and_in_how_parts_are_cut():
    x = np.ones(3)
    assert digest(x) != digest(np.nextafter(x, 2.0))
    assert digest("ab", "c") != digest("a", "bc")


# Every output of the view has a place in one of the tables.


def outputs(node, path="", seen=None):
    """Yield (place, handle) of all that can show something, in what a view is made of."""
    seen = set() if seen is None else seen
    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node, viser.GuiHtmlHandle | viser.GuiMarkdownHandle | viser.GuiImageHandle):
        yield path, "text"
    elif isinstance(node, viser.GuiUplotHandle | viser.GuiPlotlyHandle | viser.SceneNodeHandle):
        yield path, "picture"
    elif isinstance(node, dict):
        for key, value in node.items():
            yield from outputs(value, f"{path}.{key}".strip("."), seen)
    elif isinstance(node, list | tuple):
        for value in node:
            yield from outputs(value, path, seen)
    elif type(node).__module__.startswith("kneeviz.views"):
        for name, value in vars(node).items():
            yield from outputs(value, f"{path}.{name}".strip("."), seen)


@pytest.fixture(scope="module")
def view():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield View(server, lambda *_: None, KneeState(packaged_knee()))
    server.stop()


def test_every_text_and_picture_says_what_it_is_of(view):
    places = dict(outputs(view))
    texts = {p for p, kind in places.items() if kind == "text"}
    known = set(TEXTS) | set(OTHERS) | set(PICTURES)
    assert not sorted(texts - known)
    pictures = {p for p, kind in places.items() if kind == "picture"}
    assert not sorted(p for p in pictures if p.partition(".")[0] not in PICTURES)
    assert "error" in texts
    assert any(p.startswith("scene.own") for p in pictures)


def test_no_table_names_what_is_not_there(view):
    places = {place for place, _ in outputs(view)} | {"landscape"}
    first = {place.partition(".")[0] for place in places}
    assert not sorted(p for p in {**TEXTS, **OTHERS} if p not in places)
    assert not sorted(p for p in PICTURES if p not in first)


def test_all_subjects_of_the_tables_are_watched():
    named = {
        subject for table in (TEXTS, PICTURES) for entry in table.values() for subject in entry
    }
    assert named == set(SUBJECTS)


def test_what_fades_does_so_together_and_nothing_else():
    plain = theme.LIGHT
    faded = theme.faded(plain, frozenset({WORST}))
    assert {faded.model_1, faded.model_2} & {plain.model_1, plain.model_2} == set()
    assert faded.model_1 != faded.model_2
    assert replace(faded, model_1=plain.model_1, model_2=plain.model_2) == plain
    assert theme.faded(plain, frozenset()) == plain
    assert theme.faded(plain, frozenset({KNEE})).bone != plain.bone
