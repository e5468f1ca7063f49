"""The tab "Learn": the guided lesson's widgets, and the text about the app."""

from typing import Any

import viser

from kneeviz.jobs.messages import Post
from kneeviz.state.lesson import Answers
from kneeviz.state.lesson_steps import NUMBER, REVEAL, START, STEPS, Step
from kneeviz.views.html.lesson import invitation, step_page, verdict
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press, on_value

_MOST_CHOICES = max(len(step.choices) for step in STEPS)
_LARGEST = 360.0
"""What may be answered, up and down."""

ABOUT = """
<b>What you see.</b> A planar model of a human knee from the side: the thigh bone is fixed, the shin
moves under a moment, four ligaments pull when they are stretched, and the round condyle presses on
the straight plateau. For each of twelve moments the model is simulated until it comes to rest.<br>
<b>What it is for.</b> Its 28 parameters are uncertain. The search finds the two knees within the
bounds that move most differently, either in a fast stand-in or in the model itself. The stand-in's
answer is always shown with the true model's.<br>
<b>The baseline is a reconstruction.</b> The parameter table of Ciszkiewicz &amp; Dumas (2024,
doi 10.3389/fmech.2024.1392616) is in a supplement that is not available. The values here start from
attachment points of the literature and were fitted so that the model behaves as the paper's text
says. What was fitted is no evidence for the paper's claims.<br>
<b>Limits.</b> Two dimensions; no muscles, kneecap, gravity or friction; one circle and one line for
the joint surfaces; ligaments as single lines. Bones, and all depth in the 3D view, are drawn for
orientation only and nothing is computed from them. Between the twelve loads the pose is
interpolated. This is no medical device.
"""


class LearnTab:
    """The lesson's page, what takes an answer, its buttons, and the text about the app."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.page = gui.add_html("")
        self.choices = [gui.add_button("", visible=False) for _ in range(_MOST_CHOICES)]
        self.number = gui.add_number("", 0.0, min=-_LARGEST, max=_LARGEST, step=0.1, visible=False)
        self.press = gui.add_button("")
        self.verdict = gui.add_html("")
        self.turn = gui.add_button_group("Lesson", ("Back", "Next"))
        self.sheet = gui.add_button(
            "Sheet to print (lesson.html)",
            color="gray",
            hint="The lesson's questions with room for answers, and the answers on a page of "
            "their own.",
        )
        with gui.add_folder("About this app", expand_by_default=False):
            gui.add_html(box(ABOUT))
        for place, choice in enumerate(self.choices):
            on_press(choice, post, ("lesson_choice", place))
        on_value(self.number, post, "lesson_number")
        on_press(self.press, post, "lesson_press")
        on_press(self.turn, post, "lesson_turn")
        on_press(self.sheet, post, "lesson_sheet")
        self.show(None, Answers())

    def show(self, at: int | None, answers: Answers) -> None:
        """Show a step as far as it has come, or the invitation before the first."""
        if at is None:
            self.page.content, self.verdict.content = invitation(answers), ""
            self.press.label = START
            self._show_answer(None, None)
            return
        step = STEPS[at]
        self.page.content, self.verdict.content = step_page(at, answers), verdict(at, answers)
        self.press.label = step.button if answers.revealed else REVEAL
        asked = not answers.revealed and not answers.waiting
        self._show_answer(step if asked else None, answers.given.get(at))

    def _show_answer(self, step: Step | None, given: float | None) -> None:
        """Show what takes the answer to a step, and what was answered; nothing without a step."""
        choices = () if step is None else step.choices
        for place, button in enumerate(self.choices):
            button.visible = place < len(choices)
            if button.visible:
                button.label = choices[place]
                button.color = None if given == place else "gray"
                button.icon = viser.Icon.CHECK if given == place else None
        self.number.visible = step is not None and not choices
        if step is not None and not choices:
            self.number.label = NUMBER.format(unit=step.unit)
            self.number.value = 0.0 if given is None else given
