"""The lesson in words: a step's page, and what was seen."""

from kneeviz.state import lesson_steps as words
from kneeviz.state.lesson import Answers
from kneeviz.state.lesson_facts import Fact
from kneeviz.state.lesson_steps import STEPS, Step
from kneeviz.views.html.pieces import box, heading, number

_UNITS = {"deg": (1, "°"), "n": (0, "N"), "nm": (1, "N·m"), "knees": (0, "")}
_UNITLESS = (1, "")


def invitation(answers: Answers) -> str:
    """Return what stands before the first step, and the tally of the last time."""
    text = heading(words.TITLE.format(steps=len(STEPS))) + words.INVITATION
    if answers.judged:
        last = words.LAST_TALLY.format(steps=len(STEPS), **answers.tally)
        text += f'<div style="margin-top:4px"><b>{last}</b></div>'
    return box(text)


def step_page(at: int, answers: Answers) -> str:
    """Return a step's page: its number, the tally, its text and its question."""
    step = STEPS[at]
    count = words.COUNT.format(step=at + 1, steps=len(STEPS))
    tally = words.TALLY.format(**answers.tally)
    line = "display:flex;justify-content:space-between;opacity:.75"
    return box(
        f'<div style="{line}"><span>{count}</span><span>{tally}</span></div>'
        f'{heading(step.title)}<div style="margin:4px 0">{step.text}</div><b>{step.question}</b>'
    )


def verdict(at: int, answers: Answers) -> str:
    """Return whether the answer was right and what was seen; nothing before it is revealed."""
    if answers.fact is None:
        return box(words.WAIT) if answers.waiting else ""
    step, given = STEPS[at], answers.given.get(at)
    parts = [f"<b>{judgement(step, given, answers.fact)}</b>"]
    if given is not None:
        parts.append(words.YOURS.format(answer=answer_words(step, given)))
    if given is not None and not step.choices:
        parts.append(words.NEAR_ENOUGH.format(tolerance=answer_words(step, step.tolerance)))
    if step.choices and given != answers.fact.right:
        parts.append(words.IT_IS.format(answer=answer_words(step, answers.fact.right)))
    return box(f"{' '.join(parts)}<br>{told(step, answers.fact)}")


def judgement(step: Step, given: float | None, fact: Fact) -> str:
    """Return in a word whether an answer is right."""
    if given is None:
        return words.NONE
    return words.RIGHT if step.is_right(given, fact.right) else words.WRONG


def answer_words(step: Step, answer: float) -> str:
    """Return an answer as it is read: a choice's words, or a number with its unit."""
    return step.choices[int(answer)] if step.choices else number(answer, 1, step.unit)


def told(step: Step, fact: Fact) -> str:
    """Return what was seen, with its numbers."""
    return step.told.format(**{name: _number(name, v) for name, v in fact.values.items()})


def _number(name: str, value: float) -> str:
    digits, unit = _UNITS.get(name.rpartition("_")[2], _UNITLESS)
    sign = "+" if unit == "N·m" and value > 0.0 else ""
    return sign + number(value, digits, unit)
