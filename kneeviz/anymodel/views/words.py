"""What a model's page says, as HTML; all text of the user's is escaped."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kneecore import Input, Model, MonteCarloResult, SearchResult
from kneecore.report.influence import answer
from kneecore.report.tables import with_unit
from kneeviz.anymodel.curves import Curves
from kneeviz.anymodel.state import ModelState
from kneeviz.geometry.picture import Picture
from kneeviz.views import theme
from kneeviz.views.html.influence import bars, caption
from kneeviz.views.html.pieces import (
    box,
    coloured,
    command_line,
    curve_switch,
    escape,
    faint,
    plain,
    table,
)
from kneeviz.views.html.strips import strip

FloatArray = NDArray[np.float64]

_F = '<span title="The differences of the two models\u2019 outputs, summed">f</span>'
_MOST_ROWS = 8
_MOST_NAMES = 12
_MOST_NUMBERS = 40
_MOST_BARS = 30
_MOST_ROWS_COMPARED = 100
_HUES = {"trusted": "#2b8a3e", "doubtful": "#c46a00", "not found": "#d6336c"}


def _minus(text: str) -> str:
    return text.replace("-", "\u2212") if text[:1] == "-" else text


def short(value: float) -> str:
    """Return a number of any size in four digits."""
    return _minus(f"{value:.4g}") if np.isfinite(value) else "\u2013"


def told(value: float, unit: str, digits: int = 4) -> str:
    """Return a number of any size with its unit, escaped."""
    text = _minus(f"{value:.{digits}g}") if np.isfinite(value) else "\u2013"
    return escape(with_unit(text, unit))


def duration(seconds: float) -> str:
    """Return a time for people."""
    if seconds < 1.0:
        return f"{1000.0 * seconds:.0f} ms"
    for size, word in ((86_400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {word}"
    return f"{seconds:.0f} s"


def time_left(seconds: float | None) -> str:
    """Return what is left to wait for; nothing where it is unknown or soon over."""
    if seconds is None or seconds < 2.0:
        return ""
    return faint(f"At most {duration(seconds)} left.")


def swatch(colour: str, style: str = "solid") -> str:
    """Return a piece of a line."""
    return (
        f'<span style="display:inline-block;width:20px;border-top:3px {style} {colour};'
        f'vertical-align:middle;margin-right:5px"></span>'
    )


def legend(state: ModelState, shown: Curves, colours: theme.Palette) -> str:
    """Return the charts' key: what is drawn now."""
    here = "" if state.is_here else ", for other inputs"
    own = "model" if state.is_here else "model (last run)"
    items = [
        ("current", shown.own, colours.current, "solid", own),
        ("current", shown.last, colours.current, "dotted", f"last run{here}"),
        ("surrogate", shown.predicted, colours.surrogate, "dashed", "surrogate"),
        ("baseline", shown.nominal, colours.baseline, "solid", "nominal"),
        ("model_1", shown.one, colours.model_1, "solid", "model 1"),
        ("model_2", shown.two, colours.model_2, "solid", "model 2"),
        ("band", shown.low, colours.band_edge, "solid", "99.7 % band"),
    ]
    return box(
        "".join(
            curve_switch(key, swatch(hue, style) + text)
            for key, values, hue, style, text in items
            if values is not None
        ),
        style="font-size:11.5px",
    )


def numbers(
    state: ModelState, columns: Sequence[int], shown: Curves, colours: theme.Palette
) -> str:
    """Return the outputs that are single numbers, side by side."""
    if not columns:
        return ""
    own, label = (shown.last, "last run") if state.slow else (shown.own, "model")
    entries = [
        ("nominal", colours.baseline, shown.nominal),
        (label, colours.current, own),
        ("surrogate", colours.surrogate, shown.predicted),
        ("model 1", colours.model_1, shown.one),
        ("model 2", colours.model_2, shown.two),
    ]
    known = [(label, hue, y) for label, hue, y in entries if y is not None]
    band = [faint("99.7 %")] if shown.low is not None else []
    head = ("", *(coloured(label, hue) for label, hue, _ in known), *band)
    rows = []
    for k in columns[:_MOST_NUMBERS]:
        one = state.model.columns[k]
        cells = [short(float(y[k])) for _, _, y in known]
        if shown.low is not None and shown.high is not None:
            cells.append(faint(f"{short(float(shown.low[k]))} to {short(float(shown.high[k]))}"))
        rows.append((_named(one.label, one.output.unit), *cells))
    more = len(columns) - _MOST_NUMBERS
    rest = faint(f"and {more} more, in the files") if more > 0 else ""
    return box(table(head, rows) + rest)


def _named(name: str, unit: str) -> str:
    return escape(name) + (faint(f" {escape(unit)}") if unit else "")


def error_line(state: ModelState, shown: Curves) -> str:
    """Return how far the surrogate is off, in words."""
    trained = state.surrogate
    if trained is None or shown.predicted is None:
        return ""
    model, parts = state.model, []
    unit, scaled = model.objective_unit, any(o.scale is not None for o in model.outputs)
    of_scale = " of the outputs\u2019 scales" if scaled else ""
    if state.is_here and state.last is not None and state.last.y is not None:
        gap = model.weights() * np.abs(shown.predicted - state.last.y)
        if np.isfinite(gap).any():
            worst = told(float(np.nanmax(gap)), unit, 2)
            parts.append(f"Surrogate\u2019s error here: at most <b>{worst}</b>{of_scale}.")
    if trained.loo_rms is not None and not scaled:
        rms, n = told(trained.loo_rms, unit, 2), len(trained.training_x)
        parts.append(faint(f"Expected from its {n:,} runs: {rms} (rms)."))
    return box(" ".join(parts))


def held(inputs: Sequence[Input]) -> str:
    """Return which inputs do not vary."""
    if not inputs:
        return ""
    names = [f"{escape(i.name)} = {told(i.shown(i.lower), i.label)}" for i in inputs[:_MOST_NAMES]]
    more = len(inputs) - _MOST_NAMES
    return box(faint("Held: " + ", ".join(names) + (f" and {more} more" if more > 0 else "") + "."))


def drawn(model: Model) -> str:
    """Return how samples of the inputs are drawn, where it is not uniformly and independently."""
    if not model.drawn_as:
        return ""
    told = f"Band and influence draw the inputs by their distributions: {escape(model.drawn_as)}."
    return box(faint(f"{told} The search takes the bounds."))


def cost(state: ModelState, n_runs: Mapping[str, int]) -> str:
    """Return what so many runs of a slow model take, by what they are for."""
    seconds = state.seconds
    if seconds is None or not state.slow or not n_runs:
        return ""
    parts = [f"{what} {n:,} runs, {duration(n * seconds)}" for what, n in n_runs.items()]
    return box(faint("; ".join(parts) + ", one after the other."))


def found(result: SearchResult, *, same_bounds: bool) -> str:
    """Return what a search found, and how far it is to be trusted."""
    lines = [f"<b>{plain(result.summary())}</b>", objective_line(result)]
    if not same_bounds:
        lines.insert(0, "<b>The bounds of this result are others than this page\u2019s.</b>")
    if result.verdict is not None:
        word = coloured(result.verdict.word, _HUES[result.verdict.word])
        lines.append(" ".join([f"Verdict: {word}.", *map(escape, result.verdict.reasons)]))
        if result.verdict.outlook:
            lines.append(faint(escape(result.verdict.outlook)))
    if result.repair is not None:
        n = result.counts.get("models_simulated", 0)
        failed = result.counts.get("models_failed", 0)
        reused = result.counts.get("models_reused", 0)
        before = f", {reused:,} of them done before" if reused else ""
        lines.append(faint(f"{n:,} runs{before}, {failed:,} failed."))
    if result.stop_reason == "cancelled":
        lines.append(faint("The search was stopped: this is the best pair until then."))
    return box("<br>".join(lines))


def objective_line(result: SearchResult) -> str:
    """Return f in the model and in the surrogate, never one without the other."""
    model = "not known (the model failed there)"
    if result.objective_model is not None:
        model = told(result.objective_model, result.model.objective_unit)
    if result.objective_surrogate is None:
        return f"{_F} = <b>{model}</b>, in the model."
    surrogate = told(result.objective_surrogate, result.model.objective_unit)
    gap = "" if result.gap_percent is None else f" (gap {_minus(f'{result.gap_percent:.1f}')} %)"
    return f"{_F}: surrogate {surrogate}, model <b>{model}</b>{gap}."


def differences(result: SearchResult, colours: theme.Palette, again: str = "") -> str:
    """Return the outputs that differ most between both worst models, and the inputs that do.

    `again` is the command that gives the result without a browser.
    """
    model, settings = result.model, result.settings
    weights = model.weights(settings.objective, settings.weights)
    size = np.nan_to_num(weights * np.abs(result.y[0] - result.y[1]))
    order = np.argsort(-size, kind="stable")[:_MOST_ROWS]
    head = ("", coloured("model 1", colours.model_1), coloured("model 2", colours.model_2))
    rows = [
        (
            escape(model.columns[k].title),
            *(told(float(v), model.columns[k].output.unit) for v in result.y[:, k]),
        )
        for k in order
        if size[k] > 0.0
    ]
    foot = _opposite(result)
    if again:
        foot += f"<br>The same without a browser:{command_line(again)}"
    return box(table(head, rows) + f'<div style="margin-top:5px">{foot}</div>')


def _opposite(result: SearchResult) -> str:
    sides = result.model.at_bounds(result.x).astype(int)
    names = [
        escape(name)
        for name, one, two in zip(result.model.names, *sides, strict=True)
        if one * two < 0
    ]
    if not names:
        return "No input lies at opposite bounds in the two."
    more = len(names) - _MOST_NAMES
    listed = ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
    return f"At opposite bounds ({len(names)}): {listed}."


def sampled(study: MonteCarloResult) -> str:
    """Return what a sampling found."""
    stopped = "stopped after " if study.stop_reason == "cancelled" else ""
    note = (
        f"{stopped}{study.n_samples:,} runs of the {escape(study.model.name)}, "
        f"{study.settings.sampling}, seed {study.settings.seed}: "
        f"<b>{study.n_failed:,} failed</b>.{_drawn_as(study.model)}"
    )
    return box(f"{plain(study.summary())}<br>{faint(note)}")


def _drawn_as(model: Model) -> str:
    return f" Inputs: {escape(model.drawn_as)}." if model.drawn_as else ""


def comparison(state: ModelState, colours: theme.Palette) -> str:
    """Return the inputs side by side: where each point lies within the bounds."""
    pair = (None, None) if state.result is None else (state.result.x[0], state.result.x[1])
    points = [
        ("nominal", colours.baseline, state.model.nominal),
        ("yours", colours.current, state.x),
        ("model 1", colours.model_1, pair[0]),
        ("model 2", colours.model_2, pair[1]),
    ]
    known = [(label, hue, x) for label, hue, x in points if x is not None]
    key = " \u00b7 ".join(coloured(label, hue) for label, hue, _ in known)
    rows = []
    for one in state.dials[:_MOST_ROWS_COMPARED]:
        width = one.upper - one.lower
        values = [(hue, float(x[one.index])) for _, hue, x in known]
        rows.append(
            strip(
                escape(one.name) + faint(f" {escape(one.unit)}"),
                f"{escape(one.name)}: {escape(one.text(one.lower))} to "
                f"{escape(one.text(one.upper))}",
                [(hue, (v - one.lower) / width, short(v / one.scale)) for hue, v in values],
            )
        )
    more = len(state.dials) - _MOST_ROWS_COMPARED
    rest = faint(f"and {more} more, in the files") if more > 0 else ""
    return box(f'<div style="margin-bottom:4px">{key}</div>' + "".join(rows) + rest)


def influence(state: ModelState, colours: theme.Palette) -> str:
    """Return which inputs decide an output: a sentence and bars, or what to do to get them."""
    found = state.influence
    if found is None:
        return box("Which inputs decide? Press <b>Influence</b> in the tab \u201cStudy\u201d.")
    title = state.model.columns[state.column].title
    head = f"<b>{escape(answer(found, state.column))}</b>"
    drawn = bars(
        found,
        state.column,
        colours,
        called=lambda name: name,
        hue_of=lambda _, c: c.exact,
        quantity=title,
        most=_MOST_BARS,
    )
    of = f"Of the {escape(found.model.name)}.{_drawn_as(found.model)}"
    foot = faint(f"{caption(found, bars=True)} {of}")
    return box(head) + box(drawn + foot, style="padding-top:0")


def plain_with_unit(name: str, unit: str) -> str:
    """Return a name with its unit, for the scene, where nothing is markup."""
    return f"{name} ({unit})" if unit else name


def landscape_key(state: ModelState, shown: Picture, colours: theme.Palette) -> str:
    """Return what the landscape shows, and how far the surrogate is off."""
    found = state.landscape
    assert found is not None
    lines = []
    if not state.in_surrogate:
        n_failed = int(np.count_nonzero(~np.isfinite(found.y[..., state.column])))
        failed = f", {n_failed:,} failed (holes)" if n_failed else ""
        lines.append(f"{swatch(colours.current)}model: {found.n_models:,} runs{failed}")
    if shown.surrogate is not None:
        lines.append(f"{swatch(colours.surrogate)}surrogate")
        if len(shown.training):
            lines.append(f"{swatch(colours.baseline, 'dotted')}the runs that it learned from")
    if found.error is not None and np.isfinite(found.error[..., state.column]).any():
        worst = float(np.nanmax(np.abs(found.error[..., state.column])))
        off = told(worst, shown.unit, 2)
        lines.append(f"Surrogate against model: at most <b>{off}</b> off on this slice.")
    if not np.array_equal(found.x, state.x):
        lines.append("<b>The other inputs have moved since.</b>")
    return box("<br>".join(lines))
