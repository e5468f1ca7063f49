"""The command line that gives a search's result again."""

import dataclasses
import shlex
from dataclasses import replace
from typing import Any

from kneecore.knee.bounds import needs_file
from kneecore.knee.model import Knee
from kneecore.options import options_of
from kneecore.search.result import SearchResult
from kneecore.search.settings import SearchSettings

__all__ = ["command_line"]


def _knee_words(knee: Knee) -> list[tuple[str, Any, Any]]:
    """Return the options that choose the knees: (flag, value, default) each."""
    space = knee.space
    words: list[tuple[str, Any, Any]] = [("--case", space.case, "both")]
    if needs_file(space):
        words.append(("--baseline", "knee.toml", None))
        around = "baseline" if space.is_around_baseline else "current"
        words.append(("--around", around, "baseline"))
    else:
        words += [
            ("--geometry-bound-mm", space.geometry_bound_mm, 1.0),
            ("--slope-bound-deg", space.slope_bound_deg, 1.0),
            ("--material-bound-percent", space.material_bound_percent, 10.0),
            ("--rest-length-bound-mm", space.rest_length_bound_mm, 0.0),
            ("--rest-length-bound-percent", space.rest_length_bound_percent, 0.0),
        ]
    return [
        *words,
        ("--distribution", space.distribution, "uniform"),
        ("--deviations", space.deviations, None),
        ("--quantile", space.quantile, None),
        ("--solver", knee.solver, "dynamics"),
        ("--rest-length", knee.rest_length, "recomputed"),
    ]


def _setting_words(settings: SearchSettings) -> list[tuple[str, Any, Any]]:
    """Return the options of the search: (flag, value, default) each."""
    words: list[tuple[str, Any, Any]] = []
    usual = SearchSettings().usual(in_corners=True, gradient=True, n_free=0)
    usual["search_space"] = replace(settings, search_space=None).usual(
        in_corners=True, gradient=True, n_free=0
    )["search_space"]
    for one in options_of(SearchSettings):
        value, default = getattr(settings, one.name), usual.get(one.name, one.default)
        if value is None:
            continue
        if dataclasses.is_dataclass(default):
            words += [
                (f"{one.flag}.{f.name.replace('_', '-')}", getattr(value, f.name), f.default)
                for f in dataclasses.fields(default)
            ]
        else:
            words.append((one.flag, value, default))
    return words


def _said(flag: str, value: Any) -> str:
    if value is True:
        return flag
    values = value if isinstance(value, tuple) else (value,)
    return " ".join([flag, *(shlex.quote(str(v)) for v in values)])


def command_line(result: SearchResult) -> str | None:
    """Return the command; options at their defaults are left out. None for a model of one's own.

    Where the space is not the packaged one it reads the `knee.toml` that `save` writes.
    """
    if not isinstance(result.model, Knee):
        return None
    words = [*_knee_words(result.model), *_setting_words(result.settings)]
    given = [_said(flag, value) for flag, value, default in words if value != default]
    if result.methods:
        given.append("--compare")
    return " ".join(["python -m kneecore.search", *given])
