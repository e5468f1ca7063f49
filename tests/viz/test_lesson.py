import string
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import pause, press, widget

import kneecore
from kneecore import MOMENT
from kneeviz.actions import lesson
from kneeviz.page.lesson import held_back, hides
from kneeviz.state.lesson import Answers
from kneeviz.state.lesson_facts import FACTS, Fact
from kneeviz.state.lesson_steps import CURVES, ERROR, SAMPLES, STAND_IN, STEPS
from kneeviz.state.presets import PRESETS, RANDOM, preset_knee
from kneeviz.state.shown import Shown
from kneeviz.views.html import lesson as words
from kneeviz.views.tabs.learn import ABOUT

LARGEST = 5
NAMES = ("acl_n", "pcl_n", "mcl_n", "lcl_n")
ONE = Fact(right=1, values=dict.fromkeys(NAMES, 1.0))


def place(name):
    return next(k for k, step in enumerate(STEPS) if step.name == name)


def test_there_are_eight_steps_with_everything_a_step_needs():
    assert len(STEPS) == len({step.name for step in STEPS}) == len(FACTS) == 8
    for step in STEPS:
        assert step.title
        assert len(step.text) > 80
        assert step.question.endswith("?")
        assert step.button
        assert step.on_press
        asks_number = bool(step.unit) and step.tolerance > 0.0
        assert (2 <= len(step.choices) <= 4) != asks_number


@pytest.mark.parametrize("step", STEPS, ids=lambda s: s.title)
def test_every_instruction_is_one_that_is_known(monkeypatch, step):
    done = []
    page = SimpleNamespace(glide_to=lambda moment: done.append(moment))
    known = ("set_mode", "set_forces", "set_playing", "choose_preset", "_clean", "_show_pair")
    for name in (*known, "start_search", "set_landscape"):
        monkeypatch.setattr(lesson, name, lambda *args: done.append(args))
    for instruction in (*step.on_open, *step.on_press):
        before = len(done)
        lesson.follow(page, instruction, None)
        assert len(done) == before + 1, instruction


def test_presets_of_the_lesson_exist():
    named = [d[1] for s in STEPS for d in (*s.on_open, *s.on_press) if d[0] == "preset"]
    assert named
    assert set(named) <= {*PRESETS, RANDOM}


def test_about_says_what_must_be_said():
    for text in ("reconstruction", "not available", "illustrat", "no medical device", "surrogate"):
        assert text in ABOUT.replace("orientation only", "illustrative").replace(
            "stand-in", "surrogate"
        )


class TestAnswers:
    def test_the_first_time_that_a_step_is_revealed_counts(self):
        answers = Answers()
        answers.give(0, 0)
        answers.reveal(0, ONE)
        answers.give(0, 1)  # it is revealed: too late
        answers.open()
        answers.give(0, 1)
        answers.reveal(0, ONE)
        assert answers.given == {0: 1}
        assert answers.tally == {"answered": 1, "right": 0}

    def test_without_an_answer_nothing_is_counted(self):
        answers = Answers()
        answers.reveal(0, ONE)
        assert answers.tally == {"answered": 0, "right": 0}
        assert "No answer given." in words.verdict(0, answers)

    def test_a_number_is_right_within_its_tolerance(self):
        step = STEPS[place("millimetre")]
        assert step.is_right(1.6 + 0.99 * step.tolerance, 1.6)
        assert not step.is_right(1.6 - 1.01 * step.tolerance, 1.6)

    def test_a_verdict_says_the_right_answer_where_the_given_one_was_wrong(self):
        answers = Answers(given={0: 1}, fact=replace(ONE, right=3))
        assert "Not quite.</b> Your answer: PCL. It is: LCL." in words.verdict(0, answers)
        answers.given[0] = 3
        assert "Right.</b> Your answer: LCL.<br>" in words.verdict(0, answers)


@pytest.fixture(scope="module")
def state(app):
    """A state in which every step has something to tell."""
    page = app.page
    if page.state.result is None:
        page.post(("search", "surrogate"))
        eventually(lambda: page.state.result is not None)
    return page.state


class TestFacts:
    @pytest.mark.parametrize("step", STEPS, ids=lambda s: s.title)
    def test_a_text_tells_what_is_computed_and_no_number_is_left_over(self, state, step):
        fact = FACTS[step.name](state)
        told = {name for _, name, _, _ in string.Formatter().parse(step.told) if name}
        assert told <= set(fact.values)
        assert "{" not in words.told(step, fact)
        if step.choices:
            assert fact.right in range(len(step.choices))

    def test_the_numbers_are_kneecores(self, state):
        baseline = kneecore.simulate(state.space.baseline)
        moved = kneecore.simulate(preset_knee("ACL 1 bound further forward", state.space))
        angle, tension = np.degrees(baseline.flexion), baseline.tension
        change = abs(np.degrees(moved.flexion[LARGEST]) - angle[LARGEST])
        assert FACTS["millimetre"](state).right == pytest.approx(change)
        first, bent = tension[MOMENT == 0.8][0], tension[MOMENT == -5.0][0]
        assert STEPS[0].choices[FACTS["rest"](state).right] == "LCL"
        assert first.argmax() == 3
        assert set(np.argsort(bent)[2:]) == {1, 2}
        assert STEPS[2].choices[FACTS["load"](state).right] == "PCL and MCL"
        motion = FACTS["motion"](state).values
        turned = angle[MOMENT == 0.1][0] - angle[LARGEST]
        assert motion["large_deg"] - motion["small_deg"] == pytest.approx(turned)
        one, two = (np.degrees(r.flexion) for r in list(state.result.responses.values())[1:])
        assert FACTS["extremes"](state).right == pytest.approx(abs(one - two)[LARGEST])
        assert FACTS["meaning"](state).values["most_deg"] == pytest.approx(abs(one - two).max())

    def test_without_a_result_there_is_nothing_to_tell_yet(self, state):
        bare = SimpleNamespace(result=None, training_curves=state.training_curves)
        assert FACTS["extremes"](bare) is None
        assert FACTS["meaning"](bare) is None


def shown():
    curves = np.ones((3, 12))
    return Shown(
        sweeps=(object(),) * 4,
        flexion=curves[0],
        predicted=curves[1],
        training=curves,
        strain_free=True,
    )


@pytest.mark.parametrize(
    ("name", "revealed", "there"),
    [
        ("rest", False, ()),
        ("rest", True, (CURVES,)),
        ("millimetre", False, (CURVES,)),
        ("random", True, (CURVES, SAMPLES)),
        ("stand-in", False, (CURVES, SAMPLES, STAND_IN)),
        ("stand-in", True, (CURVES, SAMPLES, STAND_IN, ERROR)),
    ],
)
def test_what_would_answer_a_question_is_held_back(name, revealed, there):
    answers = Answers(fact=ONE if revealed else None)
    page = SimpleNamespace(lesson=place(name), answers=answers)
    seen = held_back(page, shown())
    assert (seen.sweeps[1] is not None) == (CURVES in there)
    assert (seen.predicted is not None) == (STAND_IN in there)
    assert np.isfinite(seen.training).all() == (SAMPLES in there)
    assert hides(page, ERROR) == (ERROR not in there)


def test_outside_of_the_lesson_nothing_is_held_back():
    everything = shown()
    assert held_back(SimpleNamespace(lesson=None), everything) is everything


def test_the_lesson_asks_takes_answers_and_reveals_from_first_to_last(page, visitor):
    learn = page.view.learn

    def content(handle):
        return visitor.props[widget(handle)]["content"]

    press(visitor, learn.turn, "Next")  # as good as the button
    eventually(lambda: page.set_aside is not None)
    for number, step in enumerate(STEPS):
        eventually(lambda n=number: page.lesson == n)
        visitor.wait(lambda c, s=step: s.title in content(learn.page))
        visitor.wait(lambda c: content(learn.verdict) == "")
        if step.choices:
            press(visitor, learn.choices[1])
        else:
            visitor.set(widget(learn.number), 1.5)
        eventually(lambda n=number: n in page.answers.given)
        press(visitor, learn.press)
        visitor.wait(lambda c: "Your answer: " in content(learn.verdict), 30)
        press(visitor, learn.turn, "Next")
    eventually(lambda: page.lesson is None)
    right = page.answers.tally["right"]
    visitor.wait(lambda c: f"8 of 8 answered, {right} right" in content(learn.page))
    assert 0 < right < 8
    assert visitor.notifications == []
    pause(visitor, page)
