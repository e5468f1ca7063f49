"""What the tab "Influence" says: a sentence and a chart, or what to do to get them."""

from kneecore import InfluenceResult, WorstCaseSlopes
from kneecore.report.influence import answer
from kneeviz.state.study import BARS
from kneeviz.views import theme
from kneeviz.views.html import influence
from kneeviz.views.html.labels import parameter_label
from kneeviz.views.html.pieces import box, escape, faint


def indices(found: InfluenceResult | None, load: int, chart: str, colours: theme.Palette) -> str:
    """Return what decides at a load (index), as bars or as a heat map."""
    if found is None:
        return box(
            "Which parameters decide each angle? Press <b>Influence</b> in the tab “Study” on the "
            "right: some seconds."
        )
    told = answer(found, load, called=parameter_label)
    words = escape(told.replace(" N m", " N·m:", 1))
    head = box(
        f"<b>{words}</b>" + influence.groups(found, load, colours),
        style="font-size:12px",
    )
    draw = influence.bars if chart == BARS else influence.heat_map
    foot = influence.caption(found, bars=chart == BARS)
    body = box(draw(found, load, colours) + faint(foot), style="padding-top:0")
    return head + body


def no_slopes() -> str:
    """Return what to do to get the slopes at the worst case."""
    return box("What separates the two worst cases? Search for them first (tab “Search”).")


def slopes(found: WorstCaseSlopes, load: int, colours: theme.Palette) -> str:
    """Return the slopes at the worst case, as bars."""
    return box(influence.slopes(found, load, colours))
