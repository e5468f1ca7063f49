from types import SimpleNamespace

import pytest

from kneeviz.actions import lesson as do_lesson
from kneeviz.state.knee import PRESETS
from kneeviz.views.tabs import controls
from kneeviz.views.tabs import learn as lesson


def test_there_are_six_to_eight_steps_with_everything_a_step_needs():
    assert 6 <= len(lesson.STEPS) <= 8
    for step in lesson.STEPS:
        assert step.title
        assert len(step.text) > 80
        assert step.question.endswith("?")
        assert step.button
        assert step.press


@pytest.mark.parametrize("step", lesson.STEPS, ids=lambda s: s.title)
def test_every_deed_is_one_that_the_stage_knows(monkeypatch, step):
    done = []
    session = SimpleNamespace(glide_to=lambda moment: done.append(moment))
    known = ("set_overlay", "set_mode", "set_forces", "set_playing", "choose_preset")
    for name in (*known, "start_search", "set_landscape"):
        monkeypatch.setattr(do_lesson, name, lambda *args: done.append(args))
    for deed in (*step.stage, *step.press):
        before = len(done)
        do_lesson.stage(session, deed, None)
        assert len(done) == before + 1, deed


def test_presets_of_the_lesson_exist():
    named = [d[1] for s in lesson.STEPS for d in (*s.stage, *s.press) if d[0] == "preset"]
    assert named
    assert set(named) <= {*PRESETS, controls.RANDOM}


def test_about_says_what_must_be_said():
    for words in ("reconstruction", "not available", "illustrat", "no medical device", "surrogate"):
        assert words in lesson.ABOUT.replace("orientation only", "illustrative").replace(
            "stand-in", "surrogate"
        )
