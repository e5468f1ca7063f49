"""The accuracy that is needed, for people."""

from collections.abc import Sequence

from rich.console import RenderableType
from rich.text import Text

from kneecore.knee.model import Knee
from kneecore.presented import Words
from kneecore.report.bound_sweep import how_searched
from kneecore.report.outputs import NO_PROOF, origin, shown
from kneecore.report.tables import render, with_unit
from kneecore.study.needed_accuracy import NeededAccuracy

__all__ = ["WORDS"]


def _knee_answer(need: NeededAccuracy) -> str:
    goal = f"Every knee extends to within {need.settings.within:g} deg"
    if need.size is None:
        return (
            f"Not {goal[0].lower()}{goal[1:]} even if the geometry is known exactly: one stops "
            f"at {need.largest_value:.2f} deg."
        )
    if need.reaches_largest:
        return (
            f"{goal} even if the geometry is only known to within {need.size:g} mm, the "
            f"widest bound that was looked at: all reach "
            f"{need.largest_value:.2f} deg."
        )
    return (
        f"{goal} if the geometry is known to within {need.size:.3f} mm; at "
        f"{need.beyond:.3f} mm one stops at {need.beyond_value:.2f} deg."
    )


def _value(need: NeededAccuracy, value: float) -> str:
    unit = need.model.columns[need.column].output.unit
    return with_unit(shown(need.model, value), unit)


def _answer(need: NeededAccuracy) -> str:
    model = need.model
    name = model.columns[need.column].title
    assert need.settings.within is not None
    goal = f"{name} is at most {_value(need, need.settings.within)}"
    reached = _value(need, need.largest_value)
    if need.size is None:
        return f"Not always: {name} is {reached} even if the inputs are known exactly."
    size = with_unit(f"{need.size:.4g}", model.size_unit)
    if need.reaches_largest:
        return (
            f"{goal} even where the {model.size_name} is {size}, the widest that was looked at: it "
            f"reaches {reached}."
        )
    assert need.beyond is not None
    assert need.beyond_value is not None
    beyond = with_unit(f"{need.beyond:.4g}", model.size_unit)
    return (
        f"{goal} where the {model.size_name} is {size}; at {beyond} it reaches "
        f"{_value(need, need.beyond_value)}."
    )


def summary(need: NeededAccuracy) -> str:
    """Return the answer in one sentence."""
    return _knee_answer(need) if isinstance(need.model, Knee) else _answer(need)


def _knee_lines(need: NeededAccuracy, knee: Knee) -> list[str]:
    lines = []
    if need.sampled_value is not None:
        lines.append(
            f"{need.n_sampled:,} random knees within that bound all reach "
            f"{need.sampled_value:.2f} deg: sampling would have passed a wider one."
        )
    lines.append(
        f"{need.n_searches} exact searches at +5 N m, solver: {knee.solver}, "
        f"{need.seconds:.2f} s. {NO_PROOF}"
    )
    return lines


def _lines(need: NeededAccuracy) -> list[str]:
    lines = []
    if need.sampled_value is not None:
        lines.append(
            f"The largest of {need.n_sampled:,} random models within these bounds is "
            f"{_value(need, need.sampled_value)}."
        )
    lines.append(
        f"{need.n_searches} searches, {need.seconds:.2f} s. {how_searched(in_model=need.in_model)}"
    )
    return lines


def _parts(need: NeededAccuracy) -> Sequence[RenderableType]:
    model = need.model
    lines = _knee_lines(need, model) if isinstance(model, Knee) else _lines(need)
    return [Text("\n".join([summary(need), *lines, origin(model)]))]


WORDS = Words(
    summary=summary,
    text=lambda need: render(_parts(need)),
    html=lambda need: render(_parts(need), html=True),
)
