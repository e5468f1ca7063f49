"""A model as a table of JSON, and back: what it was, not the function behind it."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kneecore._arguments import number
from kneecore.copula import pairs_of
from kneecore.errors import FileFormatError
from kneecore.inputs import Input
from kneecore.knee.model import Knee
from kneecore.knee.parameters import ALL_NAMES, N_PARAMETERS, NAMES
from kneecore.knee.response import RestLength, Solver
from kneecore.knee.space import ParameterSpace
from kneecore.model import Model
from kneecore.numbers import DIGITS
from kneecore.outputs import Output

__all__ = [
    "array",
    "baseline_table",
    "digits_of",
    "model_table",
    "named",
    "number_or_none",
    "read_knee",
    "read_model",
    "read_vector",
]

FloatArray = NDArray[np.float64]

_OF_VALUES = (
    "integer", "choices", "distribution", "deviations", "mode", "least", "most", "quantile",
)  # fmt: skip


def named(names: tuple[str, ...], x: FloatArray) -> dict[str, float]:
    """Return the values of inputs by name."""
    return dict(zip(names, x.tolist(), strict=True))


def digits_of(model: Model) -> int | None:
    """Return the decimals that a model's numbers have in files; None keeps them whole.

    A knee's units are such that ten decimals are plenty; nothing is known of another's.
    """
    return DIGITS if isinstance(model, Knee) else None


def array(value: Any, shape: tuple[int, ...], where: str) -> FloatArray:
    """Return numbers of a table as an array; -1 stands for any length.

    Raises
    ------
    FileFormatError
        If they are no numbers, or of another shape.
    """
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise FileFormatError(f"`{where}` holds something other than numbers") from None
    if len(numbers.shape) != len(shape) or any(
        want not in (-1, have) for want, have in zip(shape, numbers.shape, strict=True)
    ):
        raise FileFormatError(f"`{where}` has shape {numbers.shape}; {shape} is allowed")
    return numbers


def number_or_none(table: dict[str, Any], key: str) -> float | None:
    """Return a number of a table, or None."""
    value = table[key]
    if value is None or (isinstance(value, int | float) and not isinstance(value, bool)):
        return None if value is None else float(value)
    raise FileFormatError(f"`{key}` is {value!r}; a number or null is allowed")


def read_vector(table: Any, names: tuple[str, ...], where: str) -> FloatArray:
    """Return the values that `named` has told, in the order of `names`."""
    if not isinstance(table, dict) or set(table) != set(names):
        raise FileFormatError(f"`{where}` must name the {len(names)} inputs")
    return array([table[name] for name in names], (len(names),), where)


# Any model.


def model_table(model: Model) -> dict[str, Any]:
    """Return a model's inputs and outputs."""
    given = model.correlation
    correlated = {} if given is None else {"correlation": pairs_of(model.names, given)}
    return {
        "name": model.name,
        "order": list(model.order),
        "watched": model.watched,
        "size": model.size,
        "size_name": model.size_name,
        "size_unit": model.size_unit,
        "inputs": [_input_table(i, model.measurements.get(i.name, i.name)) for i in model.inputs],
        "outputs": [
            {
                "name": o.name,
                "unit": o.unit,
                "axis": None if o.axis is None else list(o.axis),
                "axis_name": o.axis_name,
                "axis_unit": o.axis_unit,
                "scale": o.scale,
            }
            for o in model.outputs
        ],
        **correlated,
    }


def _input_table(one: Input, measurement: str) -> dict[str, Any]:
    """Return an input; what is usual of its values and their distribution is left out."""
    own = {name: getattr(one, name) for name in _OF_VALUES}
    usual = {field.name: field.default for field in dataclasses.fields(Input)}
    table = {
        "name": one.name,
        "nominal": one.nominal,
        "lower": one.lower,
        "upper": one.upper,
        "unit": one.unit,
        "shown_unit": one.shown_unit,
        "shown_scale": one.shown_scale,
        **{name: value for name, value in own.items() if value != usual[name]},
    }
    if measurement != one.name:
        table["measurement"] = measurement
    if one.choices is not None:
        table |= {"lower": None, "upper": None, "choices": list(one.choices)}
    return table


def read_model(table: dict[str, Any]) -> Model:
    """Return the model that `model_table` has told; it has no function and cannot be run."""
    return _ReadModel(table)


class _ReadModel(Model):
    """A model as a file tells it."""

    def __init__(self, table: dict[str, Any]) -> None:
        super().__init__(
            None,
            [Input(**one) for one in table["inputs"]],
            [Output(**one) for one in table["outputs"]],
            name=str(table["name"]),
            correlation=table.get("correlation"),
        )
        self._order = tuple(int(k) for k in table.get("order", range(self.n_outputs)))
        if sorted(self._order) != list(range(self.n_outputs)):
            raise FileFormatError("`order` must name each of the model's numbers once")
        # Files that were written before these were told have the usual ones.
        self.watched = int(table.get("watched", self.watched))
        self._size = number("size", table["size"])
        self.size_name = str(table.get("size_name", self.size_name))
        self.size_unit = str(table.get("size_unit", self.size_unit))
        if self._size <= 0.0:
            raise FileFormatError(f"`size` is {self._size:g}; a number above 0 is allowed")
        if not 0 <= self.watched < self.n_outputs:
            raise FileFormatError(
                f"`watched` is {self.watched}; a number from 0 to {self.n_outputs - 1} is allowed"
            )

    @property
    def order(self) -> tuple[int, ...]:
        """The columns in the order in which neighbours change together."""
        return self._order


# The knee.


def baseline_table(space: ParameterSpace) -> dict[str, Any]:
    """Return the baseline and the bounds of a space of knees."""
    names = space.names
    return {
        "title": space.title,
        "note": space.note,
        "parameters": named(names, space.baseline),
        "geometry_bound_mm": space.geometry_bound_mm,
        "slope_bound_deg": space.slope_bound_deg,
        "material_bound_percent": space.material_bound_percent,
        "rest_length_bound_mm": space.rest_length_bound_mm,
        "rest_length_bound_percent": space.rest_length_bound_percent,
        "centre": None if space.is_around_baseline else named(names, space.centre),
        "half_ranges": dict(space.half_ranges) if space.half_ranges is not None else None,
        "sources": list(space.sources) if space.sources is not None else None,
        "lower": named(names, space.lower),
        "upper": named(names, space.upper),
        **space.likely.told,
    }


def knee_vector(table: Any, where: str) -> FloatArray:
    """Return a knee's 28 values, or 32 with the changes of the rest lengths."""
    if not isinstance(table, dict) or set(table) not in (set(NAMES), set(ALL_NAMES)):
        raise FileFormatError(f"`{where}` must name the 28 parameters")
    return read_vector(table, NAMES if len(table) == N_PARAMETERS else ALL_NAMES, where)


def _space(document: dict[str, Any]) -> ParameterSpace:
    baseline = document["baseline"]
    return ParameterSpace(
        case=document["case"],
        geometry_bound_mm=baseline["geometry_bound_mm"],
        slope_bound_deg=baseline["slope_bound_deg"],
        material_bound_percent=baseline["material_bound_percent"],
        # Results that were written before rest lengths could be uncertain have none.
        rest_length_bound_mm=baseline.get("rest_length_bound_mm", 0.0),
        rest_length_bound_percent=baseline.get("rest_length_bound_percent", 0.0),
        half_ranges=baseline["half_ranges"],
        # Uniform ones do not say so.
        distribution=baseline.get("distribution", "uniform"),
        deviations=baseline.get("deviations"),
        quantile=baseline.get("quantile"),
        sources=None if baseline["sources"] is None else tuple(map(str, baseline["sources"])),
        baseline=knee_vector(baseline["parameters"], "baseline.parameters"),
        title=str(baseline["title"]),
        note=baseline["note"],
        # Results that were written before a box could be around another knee have none.
        centre=knee_vector(baseline.get("centre") or baseline["parameters"], "baseline.centre"),
    )


def read_knee(document: dict[str, Any]) -> Knee:
    """Return the knees of a result: keys case, baseline, solver, rest_length and threads."""
    solver: Solver = document.get("solver", "dynamics")
    rest_length: RestLength = document["rest_length"]
    return Knee(
        _space(document), solver=solver, rest_length=rest_length, threads=int(document["threads"])
    )
