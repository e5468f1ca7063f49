from types import SimpleNamespace

import pytest

from kneeviz.actions import lesson
from kneeviz.state.presets import PRESETS, RANDOM
from kneeviz.views.tabs.learn import ABOUT, STEPS


def test_there_are_six_to_eight_steps_with_everything_a_step_needs():
    assert 6 <= len(STEPS) <= 8
    for step in STEPS:
        assert step.title
        assert len(step.text) > 80
        assert step.question.endswith("?")
        assert step.button
        assert step.on_press


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
    for words in ("reconstruction", "not available", "illustrat", "no medical device", "surrogate"):
        assert words in ABOUT.replace("orientation only", "illustrative").replace(
            "stand-in", "surrogate"
        )
