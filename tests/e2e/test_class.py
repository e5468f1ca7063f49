"""A class and its links as a teacher and a student see them."""

from dataclasses import replace

import pytest
from e2e.conftest import Visitor, eventually

from kneecore import NAMES
from kneeviz.server.app import App
from kneeviz.state import links
from kneeviz.state.bounds import Bounds

pytestmark = pytest.mark.filterwarnings("ignore:Queued a ")  # viser's, for those who left
ACL_X = NAMES.index("acl_femur_x")


@pytest.fixture(scope="module")
def classs(chromium):
    running = App(port=0, for_class=True)
    eventually(lambda: running.page.model_ready)
    yield running
    running.stop()


def at(classs, **changes):
    """The query of a link to the present state with changes."""
    state = replace(classs.page.snapshot(), **changes)
    return f"fixedDpr=0.5&knee={links.to_code(state, classs.page.view.first_settings)}"


def test_a_student_watches_until_he_has_the_wheel(chromium, classs):
    student = Visitor(chromium, classs.class_url)
    student.page.get_by_text("You are watching; the teacher drives (Visitor 1).").wait_for()
    style = student.thumb("ACL femur x").evaluate(
        "node => getComputedStyle(node.closest('.mantine-Slider-root')).pointerEvents"
    )
    assert style == "none"
    # Opened by a link of his own, whose question makes the first page of the class wait.
    teacher = Visitor(chromium, classs.url, "&" + at(classs, bounds=Bounds(geometry_mm=0.5)))
    teacher.wait("() => !location.href.includes('token=')")  # it may be on the wall
    teacher.press("Open the linked knee")
    teacher.wait_until(lambda: classs.page.state.bounds.geometry_mm == 0.5)
    teacher.row("Who drives").locator("input:not([type='hidden'])").click()
    teacher.page.get_by_role("option", name="Visitor 1").click()
    student.page.get_by_text("You have the wheel (Visitor 1).").wait_for()
    student.thumb("ACL femur x").focus()
    student.page.keyboard.press("End")
    student.wait_until(lambda: classs.page.state.x[ACL_X] == pytest.approx(-13.5e-3))
    assert (student.errors, teacher.errors) == ([], [])
    student.close()
    teacher.close()
