"""The lesson's eight steps as data: texts, questions, and what each does to the page.

All of the lesson's texts stand here. In `told`, a name in braces is a number that is computed when
the step is revealed (`kneeviz.state.lesson_facts`). What a step asks of the page is named here and
done by `kneeviz.actions.lesson`.
"""

from dataclasses import dataclass
from typing import Any

Instructions = tuple[tuple[Any, ...], ...]
"""What to do, in order: each a name and what it needs."""

CURVES, SAMPLES, STAND_IN, ERROR = "curves", "samples", "stand-in", "error"
"""What may be held back: the knees' curves, random knees, the surrogate, and its error."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One page of the lesson: a question, an answer, and a picture that confirms or corrects it."""

    name: str
    """Which facts belong to it."""
    title: str
    text: str
    question: str
    choices: tuple[str, ...] = ()
    """Two to four answers to choose from; none where a number is asked for."""
    unit: str = ""
    """Of the number that is asked for."""
    tolerance: float = 0.0
    """How far from the true number an answer is right."""
    told: str
    """What was seen, once it is revealed."""
    button: str
    """Label of the one thing to press, once it is revealed."""
    on_open: Instructions
    """Done when the step opens."""
    on_press: Instructions
    """Done when it is revealed, and when its button is pressed again."""
    hidden: tuple[str, ...] = ()
    """What is held back, for it would tell the answer."""
    still_hidden: tuple[str, ...] = ()
    """What is held back after the answer too, for a later step."""

    def is_right(self, given: float, right: float) -> bool:
        """Tell whether an answer is right: the place of a choice, or a number near enough."""
        return given == right if self.choices else abs(given - right) <= self.tolerance


_CALM: Instructions = (
    ("clean",),
    ("landscape", False),
    ("mode", "sweep"),
    ("forces", False),
)
_LATER = (SAMPLES, STAND_IN, ERROR)

STEPS = (
    Step(
        name="rest",
        title="A knee at rest",
        text="Thigh bone above, shin bone below, four ligaments between them. Nothing pulls on "
        "this knee: it hangs half bent, and all four ligaments are slack.",
        question="A gentle moment of 0.8 N·m straightens it a little. Which ligament will then "
        "pull hardest?",
        choices=("ACL", "PCL", "MCL", "LCL"),
        told="Under 0.8 N·m the ACL pulls with {acl_n}, the PCL with {pcl_n}, the MCL with {mcl_n} "
        "and the LCL with {lcl_n}. Which one tightens first depends on where it is attached, "
        "not on how well known it is.",
        button="Straighten it a little",
        on_open=(*_CALM, ("moment", 0.0)),
        on_press=(("glide", 0.8),),
        hidden=(CURVES, *_LATER),
        still_hidden=_LATER,
    ),
    Step(
        name="motion",
        title="Bend and stretch",
        text="A moment turns the shin: up to 5 N·m to straighten it, then 5 N·m to bend it. The "
        "curve that appears on the left with the answer shows at which angle the knee comes to "
        "rest under each moment; the dot is the knee that you see.",
        question="0.1 N·m already turns this knee visibly away from rest. By how many degrees from "
        "rest does 5 N·m straighten it, fifty times as much?",
        unit="°",
        tolerance=10.0,
        told="0.1 N·m straightens it by {small_deg}, 5 N·m by {large_deg}: {ratio} times as much, "
        "not fifty. Near rest the ligaments are slack and the knee is soft; then they tighten, "
        "and it becomes stiff.",
        button="Play the motion",
        on_open=(*_CALM, ("moment", 0.0)),
        on_press=(("play", True),),
        hidden=(CURVES, *_LATER),
        still_hidden=_LATER,
    ),
    Step(
        name="load",
        title="Who carries the load?",
        text="Colour and width show tension. Straight, the cruciates (ACL, PCL) and the outer band "
        "(LCL) hold the knee. See the numbers beside their names.",
        question="Which two ligaments hold the knee when it is fully bent?",
        choices=("ACL and PCL", "PCL and MCL", "ACL and LCL", "MCL and LCL"),
        told="Fully bent, the ACL pulls with {acl_n}, the PCL with {pcl_n}, the MCL with {mcl_n} "
        "and the LCL with {lcl_n}. Straight it was {acl_straight_n}, {pcl_straight_n}, "
        "{mcl_straight_n} and {lcl_straight_n}. The load goes from one to another as the knee "
        "bends: see the tab “Forces”.",
        button="Bend it fully",
        on_open=(*_CALM, ("forces", True), ("moment", 5.0)),
        on_press=(("glide", -5.0),),
        hidden=(CURVES, *_LATER),
        still_hidden=_LATER,
    ),
    Step(
        name="millimetre",
        title="One millimetre",
        text="Nobody knows exactly where a ligament is attached: measurements differ by several "
        "millimetres. Let us move one attachment of the ACL by its bound, one millimetre.",
        question="By how many degrees does this one change turn the straight knee, under 5 N·m?",
        unit="°",
        tolerance=0.7,
        told="Under 5 N·m the knee came to rest at {before_deg}, and now at {after_deg}: it turned "
        "by {change_deg}. That was one of 28 dials, and a small turn of it.",
        button="Move the ACL",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("preset", "ACL 1 bound further forward"),),
        hidden=_LATER,
        still_hidden=_LATER,
    ),
    Step(
        name="random",
        title="Why not try them all?",
        text="This knee has 28 dials: attachments, shapes, stiffnesses. Trying only the two ends "
        "of each means 2²⁸ knees, more than 260 million, and the worst need not be among them "
        "for sure. So let us try fifty, with every dial anywhere within its bounds.",
        question="How many degrees lie between the two most different of fifty random knees, "
        "under 5 N·m?",
        unit="°",
        tolerance=6.0,
        told="The {knees} faint curves are such knees. Under 5 N·m they come to rest between "
        "{lowest_deg} and {highest_deg}: {spread_deg} apart. Chance hardly ever turns all "
        "dials the bad way at once; the worst case lies beyond.",
        button="Another random knee",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("preset", "Random, within bounds"),),
        hidden=_LATER,
        still_hidden=(STAND_IN, ERROR),
    ),
    Step(
        name="stand-in",
        title="A cheap stand-in",
        text="Simulate 50 random knees (the faint curves), and fit a smooth function through "
        "them: the surrogate, drawn dashed. It answers at once. The landscape that follows "
        "shows both over two of the dials: the true model grey, the stand-in purple. Turn it "
        "with the mouse.",
        question="How far off is the stand-in at a knee that it has never seen, on average?",
        choices=("Less than 0.1°", "Between 0.1° and 3°", "More than 3°"),
        told="At this random knee, which was not among those it learned from, the stand-in is off "
        "by {rms_deg} (root mean square over the loads) and by {largest_deg} at worst. Good "
        "enough to search in; what is found must be asked of the true model.",
        button="Landscape of a random knee",
        on_open=(*_CALM, ("moment", 2.0)),
        on_press=(("preset", "Random, within bounds"), ("landscape", True)),
        hidden=(ERROR,),
    ),
    Step(
        name="extremes",
        title="Evolution finds the extremes",
        text="Pairs of knees compete: the more differently the two move, the more offspring they "
        "have. After 800 generations two knees are left. The true model then checks what the "
        "stand-in promised.",
        question="How many degrees apart are these two, under 5 N·m, within the same bounds as the "
        "random knees of step 5?",
        unit="°",
        tolerance=8.0,
        told="Model 1 (blue) comes to rest at {one_deg}, model 2 (orange) at {two_deg}: "
        "{apart_deg} apart. The {knees} random knees were {spread_deg} apart. Sampling shows "
        "what is usual; only a search shows what is possible.",
        button="Run the search",
        on_open=(*_CALM, ("moment", 5.0)),
        on_press=(("search",),),
    ),
    Step(
        name="meaning",
        title="What it means",
        text="Every point of the two knees lies within the same small bounds, and yet one "
        "over-extends and the other stays bent. A plan that rests on one set of numbers, for a "
        "graft or an implant, should ask what the worst case within its own uncertainty would do. "
        "Mind that this knee is a planar reconstruction, no patient.",
        question="How much of the largest difference between the two could a surgeon see while the "
        "knee is hardly loaded, by 0.1 N·m?",
        choices=("Nearly all: three quarters or more", "A part of it", "Less than a tenth"),
        told="Under 0.1 N·m the two are {unloaded_deg} apart, under {most_nm} {most_deg}. A knee "
        "that is hardly loaded hides most of the difference: examine it under load.",
        button="Play both",
        on_open=(("landscape", False), ("mode", "sweep"), ("pair",), ("moment", 0.0)),
        on_press=(("play", True),),
        hidden=(CURVES,),
    ),
)

TITLE = "A lesson in {steps} steps"
INVITATION = (
    "Why one millimetre matters, from a knee at rest to the two most different knees. Each step "
    "sets the stage and asks a question. Answer first, then reveal: the picture confirms or "
    "corrects you. You may also go on without an answer. Everybody who looks at this knee sees "
    "the same. Your own knee is put aside and comes back at the end."
)
START, REVEAL = "Start the lesson", "Reveal"
COUNT = "Step {step} of {steps}"
TALLY = "Answered: {answered}, right: {right}"
LAST_TALLY = "Last time: {answered} of {steps} answered, {right} right."
NUMBER = "Your answer ({unit})"
YOURS = "Your answer: {answer}."
RIGHT, WRONG, NONE = "Right.", "Not quite.", "No answer given."
NEAR_ENOUGH = "Within {tolerance} counts as right."
IT_IS = "It is: {answer}."
WAIT = "The search is running …"
NOTHING = "There is nothing to tell; press again."
BEGUN = "The lesson has begun: your knee, bounds and result are put aside."
OVER = "The lesson is over: your knee, bounds and result are back."
