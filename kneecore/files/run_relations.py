"""What must agree in the course of a search: its runs, its evidence, its repair."""

import numpy as np

from kneecore.files.consistent import check_equal, check_holds
from kneecore.files.model import digits_of
from kneecore.search.result import Evidence, SearchResult, gap_percent

__all__ = ["check_evidence", "check_repair", "check_runs"]

_SINGLE = 1e-4
"""The genetic algorithm's search in the surrogate has single precision."""
_SLACK = 1e-9
"""Share of f by which sums of the same numbers may differ."""
_PER_CENT = 100.0


def _searched_f(result: SearchResult) -> float | None:
    """Return f of the best pair in the space that was searched last."""
    if (
        result.verdict is not None and result.repair is not None
    ):  # a search inside the bounds ends with the best that was run
        return result.objective_model
    if result.repair is not None and not result.repair.rounds:  # ended before its first optimum
        return result.objective_model
    f = result.objective_surrogate
    return result.objective_model if f is None else f


def check_runs(result: SearchResult) -> None:
    """Raise a `FileFormatError` if runs and history do not end at the value that was found."""
    values, history = np.array(result.run_values), result.history
    digits, f = digits_of(result.model), _searched_f(result)
    check_holds("search.run_values", len(values) > 0, "one for each run")
    # A pair that fails in the model is worth minus infinity to a search, and nothing to a file.
    if f is not None and not np.isnan(values).all():
        check_equal("search.run_values", np.nanmax(values), f, digits=digits)
    inside = result.repair is not None and result.verdict is not None  # no pairs are bred there
    ga = result.settings.method == "ga" and not inside
    whole = result.stop_reason != "cancelled"
    if whole:
        n_runs = result.settings.n_runs if ga else 1
        check_holds("search.run_values", len(values) == n_runs, f"{n_runs} follows from `runs`")
    if ga and whole:
        n = result.settings.n_generations + 1
        check_holds("search.history", len(history) == n, f"{n} values follow from `generations`")
    if len(history) and len(values) and f is not None:
        rounding = _SINGLE if ga else _SLACK
        check_equal("search.history", history[-1], f, digits=digits, rounding=rounding)
    # The last is f in motion, where a search has begun with the knees at rest.
    moved = result.evidence is not None and result.evidence.n_models > 0
    risen = history[:-1] if moved or not ga else history
    if not moved and not ga and len(history) > 1:
        check_holds("search.history", history[-1] >= history[-2] * (1.0 - _SLACK), "it never falls")
    with np.errstate(invalid="ignore"):
        falls = np.diff(risen) < -_SLACK * np.abs(risen[1:])
    check_holds("search.history", ~falls, "it never falls")
    _check_pairs(result, ga=ga, whole=whole)


def _check_pairs(result: SearchResult, *, ga: bool, whole: bool) -> None:
    """Check how many pairs the genetic algorithm has evaluated: an elite is not evaluated again."""
    settings, pairs = result.settings, result.counts.get("pairs_evaluated", 0)
    where = "counts.pairs_evaluated"
    if not ga:
        check_holds(where, pairs == 0, "0 follows from the method")
        return
    n_elite = settings.options.split(settings.pop_size)[0]
    one = settings.pop_size + settings.n_generations * (settings.pop_size - n_elite)
    searches, left = divmod(pairs, one * settings.n_runs)
    if not whole:
        return
    if result.repair is None:
        fits = searches == 1 and left == 0
        check_holds(where, fits, f"{one * settings.n_runs} follows from the options")
    else:  # a repair searches as often as it must
        fits = searches >= 1 and left == 0
        check_holds(where, fits, f"a multiple of {one * settings.n_runs} follows from the options")


def check_evidence(result: SearchResult) -> None:
    """Raise a `FileFormatError` if an exact search's evidence does not fit what it has found."""
    evidence = result.evidence
    if evidence is None:
        return
    check_holds("evidence.share_reached", 0.0 <= evidence.share_reached <= 1.0, "0 to 1")
    reached = evidence.share_reached * evidence.n_climbs
    check_holds(
        "evidence.share_reached", abs(reached - round(reached)) < 1e-6, "a share of `climbs`"
    )
    check_holds(
        "evidence.models_lost",
        evidence.n_failed <= evidence.n_evaluations,
        "at most the models with a gradient",
    )
    signs = [set(signs) <= {-1, 0, 1} for signs, _ in evidence.patterns]
    check_holds("evidence.patterns", signs, "signs are -1, 0 or 1")
    lengths = [len(signs) == result.model.n_outputs for signs, _ in evidence.patterns]
    check_holds("evidence.patterns", lengths, "a sign for each output")
    _check_ranks(result, evidence)


def _check_ranks(result: SearchResult, evidence: Evidence) -> None:
    """Check that nothing that lost is better than what was found."""
    f, digits = _searched_f(result), digits_of(result.model)
    values = np.array([value for _, value in evidence.patterns])
    check_holds("evidence.patterns", np.diff(values) <= 0.0, "the best pattern is the first")
    at_rest, moved = evidence.objective_proxy, evidence.n_models > 0
    climbed = f if at_rest is None else at_rest
    if climbed is not None and len(values):
        most = climbed + _SLACK * abs(climbed)
        check_holds("evidence.patterns", values[0] <= most, "at most f of the pair")
    if f is None:
        return
    second, before = evidence.second_best, evidence.objective_before_climb
    check_holds("evidence.second_best", second is None or second <= f, "at most f of the pair")
    fits = before is None or before <= f + _SLACK * abs(f)
    check_holds("evidence.objective_before_climb", fits, "at most f of the pair")
    if moved:
        return
    if at_rest is not None:
        check_equal("evidence.objective_at_rest", at_rest, f, digits=digits)
    if len(values) > 1:
        fits = second is not None and second >= values[1] - _SLACK * abs(values[1])
        check_holds("evidence.second_best", fits, "at least f of the second pattern")


def check_repair(result: SearchResult) -> None:
    """Raise a `FileFormatError` if a repair's rounds do not lead to what was found."""
    repair, digits = result.repair, digits_of(result.model)
    if repair is None:
        return
    most = "at most the models that were added"
    check_holds("repair.models_failed", repair.n_failed <= repair.n_models, most)
    check_holds("repair.checks_failed", repair.n_checked_failed <= repair.n_checked, most)
    fits = repair.n_models + repair.n_checked <= repair.max_models
    check_holds("repair.models_added", fits, "at most max_models, those checked among them")
    added = [one.n_models for one in repair.rounds]
    check_holds("repair.rounds", np.diff([*added, repair.n_models]) >= 0, most)
    for one in repair.rounds:
        follows = gap_percent(one.objective_surrogate, one.objective_model)
        check_equal(
            "repair.rounds.gap_percent", one.gap_percent, follows, digits=digits, size=_PER_CENT
        )
    if repair.rounds:
        last = repair.rounds[-1].objective_surrogate
        check_equal(
            "repair.rounds.objective_surrogate", last, result.objective_surrogate, digits=digits
        )
    y = result.training_y
    if y is None:
        return
    failed = ~np.isfinite(y[len(y) - repair.n_models :]).all(axis=1)
    fits = repair.n_failed == np.count_nonzero(failed)
    check_holds("repair.models_failed", fits, f"{np.count_nonzero(failed)} follows from `training`")
    _check_best_known(result)


def _check_best_known(result: SearchResult) -> None:
    """Check that the pair is the most different one of all models that a repair has run."""
    y = result.training_y
    assert y is not None
    weights = result.model.weights(result.settings.objective, result.settings.weights)
    good = y[np.isfinite(y).all(axis=1)]
    best = -np.inf
    for k in range(1, len(good)):
        best = max(best, float((np.abs(good[:k] - good[k]) * weights).sum(axis=1).max()))
    size = float(2.0 * (np.abs(good).max(axis=0, initial=0.0) * weights).sum())
    if np.isfinite(best):
        check_equal(
            "objective_model",
            result.objective_model,
            best,
            digits=digits_of(result.model),
            size=size,
        )
