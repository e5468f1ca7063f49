"""The lesson on paper."""

import re

import pytest
from viz.conftest import eventually
from viz.visits import press

from kneeviz.export.sheet import html_sheet
from kneeviz.state.lesson_steps import STEPS


@pytest.fixture(scope="module")
def sheet():
    return html_sheet()


def test_every_question_has_room_and_the_answers_stand_on_a_page_of_their_own(sheet):
    questions, answers = sheet.split('<div class="answers">')
    for step in STEPS:
        assert step.question in questions
        assert step.title in answers
        for choice in step.choices:
            assert f"<li>{choice}</li>" in questions
    assert questions.count('class="room"') == sum(not step.choices for step in STEPS)
    assert len(re.findall("<section><h2>", answers)) == len(STEPS)
    assert "LCL.</b>" in answers
    assert "LCL.</b>" not in questions
    assert ".answers { break-before: page; }" in sheet


def test_it_needs_nothing_else_and_has_a_picture(sheet):
    assert not re.findall(r"""(?:src|href)=["']|url\(|@import|<script""", sheet)
    assert sheet.count("<svg") == 1
    for name in ("ACL", "PCL", "MCL", "LCL"):
        assert f">{name}</text>" in sheet
    assert "{" not in re.sub(r"(?s)<style>.*</style>", "", sheet)


def test_a_visitor_gets_the_same_to_print(page, visitor, sheet):
    press(visitor, page.view.learn.sheet)
    visitor.wait(lambda c: c.downloads.get("lesson.html"), 60)
    eventually(lambda: page.export_job is None)
    assert visitor.downloads["lesson.html"].decode() == sheet
