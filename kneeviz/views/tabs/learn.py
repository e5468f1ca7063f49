"""The guided lesson and the page about the app: texts, and what each step does to the page.

What a step asks for is named here and done by `kneeviz.actions.lesson`.
"""

from dataclasses import dataclass
from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box
from kneeviz.views.tabs.events import on_press

Instructions = tuple[tuple[Any, ...], ...]
"""What to do, in order: each a name and what it needs."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One page of the lesson."""

    title: str
    text: str
    question: str
    button: str
    """Label of the one thing to press."""
    on_open: Instructions
    """Done when the step opens."""
    on_press: Instructions
    """Done when its button is pressed."""


_CALM: Instructions = (
    ("clean",),
    ("landscape", False),
    ("mode", "sweep"),
    ("forces", False),
)

STEPS = (
    Step(
        title="A knee at rest",
        text="Thigh bone above, shin bone below, four ligaments between them. Nothing pulls on "
        "this knee: it hangs slightly bent, and all four ligaments are slack.",
        question="Which ligament will become tight first when the knee straightens?",
        button="Straighten it a little",
        on_open=(*_CALM, ("moment", 0.0)),
        on_press=(("glide", 0.8),),
    ),
    Step(
        title="Bend and stretch",
        text="A moment turns the shin: up to 5 N·m to straighten it, then 5 N·m to bend it. The "
        "curve on the left shows the angle at which the knee comes to rest under each moment; the "
        "dot is the knee that you see.",
        question="Where is the knee soft, and where does it become stiff?",
        button="Play the motion",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("play", True),),
    ),
    Step(
        title="Who carries the load?",
        text="Colour and width show tension. Straight, the cruciates (ACL, PCL) and the outer band "
        "(LCL) hold the knee. See the numbers beside their names, and the tab “Forces”.",
        question="Which two ligaments hold the knee when it is fully bent?",
        button="Bend it fully",
        on_open=(*_CALM, ("forces", True), ("moment", 5.0)),
        on_press=(("glide", -5.0),),
    ),
    Step(
        title="One millimetre",
        text="Nobody knows exactly where a ligament is attached: measurements differ by several "
        "millimetres. Let us move one attachment of the ACL by its bound, one millimetre.",
        question="How many degrees of extension does this one change cost or win?",
        button="Move the ACL",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("preset", "ACL 1 bound further forward"),),
    ),
    Step(
        title="Why not try them all?",
        text="This knee has 28 dials: attachments, shapes, stiffnesses. Trying only the two ends "
        "of each means 2²⁸ knees, more than 260 million, and the worst need not be among them "
        "for sure.",
        question="Press several times: how different do random knees become?",
        button="Another random knee",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("preset", "Random, within bounds"),),
    ),
    Step(
        title="A cheap stand-in",
        text="Simulate 50 random knees (the faint curves), and fit a smooth function through "
        "them: the surrogate, drawn dashed. It answers at once, and it is wrong by an amount "
        "that stands below the curve. The landscape shows both over two of the dials: the true "
        "model grey, the stand-in purple. Turn it with the mouse.",
        question="Where do the two sheets part, and do they so at every random knee?",
        button="Landscape of a random knee",
        on_open=(*_CALM, ("moment", 2.0)),
        on_press=(("preset", "Random, within bounds"), ("landscape", True)),
    ),
    Step(
        title="Evolution finds the extremes",
        text="Pairs of knees compete: the more differently the two move, the more offspring they "
        "have. After 800 generations two knees are left. The true model then checks what the "
        "stand-in promised.",
        question="Which of the two cannot straighten, and which bends backwards?",
        button="Run the search",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("search",),),
    ),
    Step(
        title="What it means",
        text="Every point of the two knees lies within the same small bounds, and yet one "
        "over-extends and the other stays bent. A plan that rests on one set of numbers, for a "
        "graft or an implant, should ask what the worst case within its own uncertainty would do. "
        "Mind that this knee is a planar reconstruction, no patient.",
        question="At which moment do the two part?",
        button="Play both",
        on_open=(("landscape", False), ("mode", "sweep"), ("pair",), ("moment", 0.0)),
        on_press=(("play", True),),
    ),
)

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
    """The lesson's page with its three buttons, and the text about the app."""

    def __init__(self, gui: Any, post: Post) -> None:
        self.page = gui.add_html("")
        self.press = gui.add_button("")
        self.turn = gui.add_button_group("Lesson", ("Back", "Next"))
        with gui.add_folder("About this app", expand_by_default=False):
            gui.add_html(box(ABOUT))
        on_press(self.press, post, "lesson_press")
        on_press(self.turn, post, "lesson_turn")
        self.show(None)

    def show(self, number: int | None) -> None:
        """Show a step, or the invitation before the first."""
        if number is None:
            self.page.content = box(
                f"<b>A lesson in {len(STEPS)} steps</b><br>Why one millimetre matters, from a "
                "knee at rest to the two most different knees. Each step sets the stage, asks a "
                "question and has one button. Everybody who looks at this knee sees the "
                "same. Your own knee is put aside and comes back at the end."
            )
            self.press.label = "Start the lesson"
            return
        step = STEPS[number]
        self.page.content = box(
            f'<div style="opacity:.65">Step {number + 1} of {len(STEPS)}</div>'
            f'<b style="font-size:15px">{step.title}</b>'
            f'<div style="margin:4px 0">{step.text}</div><i>{step.question}</i>'
        )
        self.press.label = step.button
