"""The command line that gives a result again."""

import shlex
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from kneecore.knee.parameters import widened
from kneecore.knee.space import ParameterSpace
from kneecore.numerics.genetic_options import GeneticOptions
from kneecore.search.settings import default_space

if TYPE_CHECKING:
    from kneecore.search.result import SearchResult


def needs_file(space: ParameterSpace) -> bool:
    """Tell whether a space can only be given as a knee file."""
    packaged = ParameterSpace()
    own = not np.array_equal(space.baseline, widened(packaged.baseline, len(space.baseline)))
    return (
        own
        or not space.is_around_baseline
        or space.half_ranges is not None
        or space.title != packaged.title
    )


def command_line(result: "SearchResult") -> str:
    """Return the command; options at their defaults are left out."""
    space = result.space
    words: list[tuple[str, object, object]] = [("--case", space.case, "both")]
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
    words += [
        ("--method", result.method, "ga"),
        ("--solver", result.solver, "dynamics"),
        (
            "--space",
            result.search_space,
            default_space(result.method, repair=result.repair is not None),
        ),
        ("--training-samples", result.training_samples, 50),
        ("--pop-size", result.pop_size, 200),
        ("--generations", result.n_generations, 800),
        ("--runs", result.n_runs, 1),
        ("--objective", result.objective, "all"),
        ("--seed", result.seed, 0),
        ("--rest-length", result.rest_length, "recomputed"),
    ]
    if result.repair is not None:
        words += [
            ("--repair-gap-percent", result.repair.goal_percent, 1.0),
            ("--repair-models", result.repair.max_models, 40),
        ]
    usual = GeneticOptions()
    for option in fields(GeneticOptions):
        name = option.name
        flag = f"--ga.{name.replace('_', '-')}"
        words.append((flag, getattr(result.options, name), getattr(usual, name)))
    given = [
        f"{flag} {shlex.quote(str(value))}" for flag, value, default in words if value != default
    ]
    if result.repair is not None:
        given.append("--repair")
    if result.rivals:
        given.append("--compare")
    return " ".join(["python -m kneecore.search", *given])
