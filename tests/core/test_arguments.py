"""Every public callable of the knee: whatever it is given, an answer or one line that names it."""

import decimal
import fractions
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kneecore
from kneecore import (
    FileFormatError,
    Input,
    Knee,
    KneecoreError,
    Model,
    Output,
    ParameterError,
    ParameterSpace,
    SearchResult,
    SearchSettings,
    compare_methods,
    dump_knee,
    fit_surrogate,
    flexion_gradient,
    influence,
    landscape,
    monte_carlo,
    packaged_knee,
    parameter_table,
    read_knee,
    simulate,
    simulate_batch,
    trajectory,
    worst_case,
)
from kneecore import _arguments as arguments
from kneecore._assets import asset_path
from kneecore.knee.file import LONGEST_TEXT, parse_knee
from kneecore.knee.parameters import ALL_NAMES, LARGEST, NAMES, check_physical, widened
from kneecore.numerics import sampling, sampling_options
from kneecore.options import options_of
from kneecore.study.settings import InfluenceSettings, SamplingSettings

KNEE = packaged_knee()
SPACE = ParameterSpace()
X = SPACE.baseline
KNEES = Knee(ParameterSpace(case="material"), solver="equilibrium", threads=1)
SMALL = SearchSettings(training_samples=10, pop_size=10, n_generations=2)


class Sly:
    """A value that fails wherever it is looked at."""

    def __repr__(self):
        raise ValueError("no text")

    def __array__(self, *_, **__):
        raise ValueError("no array")

    def __len__(self):
        raise TypeError("no length")


NUMBERS = [0, 1, 2, -1, 28, 2**63, 10**400, -(10**400), 10**5000, 1e308, -1e308, 1e-320, -0.0]
ODD = [
    *(None, True, False, "", "x", "1", "both", "a\0b", "\ud800", "y" * 100_000, b"x", (), [], {}),
    *(float("nan"), float("inf"), -float("inf"), 1j, object(), Sly(), len, ValueError, slice(1)),
    *(fractions.Fraction(1, 3), decimal.Decimal("1e999"), np.float64("nan"), np.bool_(True)),
    *(np.array(1.0), np.zeros(28), np.zeros((2, 28)), np.zeros((0, 28)), np.zeros((1, 1, 28))),
    *(np.full(28, "1"), np.ones(28, bool), np.ones(28, complex), np.full(28, None), np.ones(5)),
    *([10**400] * 28, [True] * 28, ["1"] * 28, [[1.0], [1.0, 2.0]], [1e308] * 28, [-1e308] * 28),
    *(1e3 * X, -X, X.astype(np.float32), X.astype(str), X.astype("O"), X.tolist(), [X, X]),
    *({"acl_femur_x": 1e308}, {"acl_femur_x": "1"}, {1: 1}, {"x": 1.0}, {"acl_femur_x": 10**400}),
    np.array(["2020-01-01"] * 28, dtype="datetime64[D]"),
    np.zeros(28, dtype=[("a", float)]),
]
ANYTHING = st.sampled_from(NUMBERS + ODD) | st.text(max_size=5) | st.floats() | st.integers()

BOUNDS = {
    "geometry_bound_mm": 1.0,
    "slope_bound_deg": 1.0,
    "material_bound_percent": 10.0,
    "rest_length_bound_mm": 0.0,
    "rest_length_bound_percent": 0.0,
}


def count(value):
    """Check a count that a caller has given; its name is our own."""
    return sampling_options.check_count("value", value)


CALLABLES = {
    ParameterSpace: BOUNDS
    | {"case": "both", "half_ranges": None, "baseline": X, "centre": X}
    | {"title": "a", "note": None, "sources": None},
    ParameterSpace.from_file: BOUNDS
    | {"path": asset_path("baseline.toml"), "case": "both", "around": "baseline"},
    SPACE.to_unit: {"x": X},
    SPACE.from_unit: {"u": np.full(28, 0.5)},
    SPACE.from_free_unit: {"u": np.full(28, 0.5)},
    SPACE.at_bounds: {"x": X, "tolerance": 1e-3},
    SPACE.to_toml: {"current": X},
    read_knee: {"path": asset_path("baseline.toml")},
    parse_knee: {"text": ""},
    parameter_table: {"rest_lengths": False},
    dump_knee: {"baseline": X, "half_ranges": KNEE.half_ranges, "current": None}
    | {"sources": None, "title": "a", "note": None},
    simulate: {"x": X, "baseline": None, "rest_length": "recomputed", "solver": "equilibrium"},
    simulate_batch: {"X": X[None], "baseline": None, "rest_length": "fixed"}
    | {"solver": "equilibrium", "threads": 1},
    flexion_gradient: {"x": X, "baseline": None, "rest_length": "recomputed"},
    trajectory: {"x": X, "baseline": None, "rest_length": "recomputed", "frame_steps": 250},
    Knee: {"space": SPACE, "solver": "equilibrium", "rest_length": "recomputed", "threads": 1},
    KNEES.simulate: {"x": X},
    KNEES.simulate_batch: {"x": X[None]},
    KNEES.trajectory: {"x": X},
    KNEES.evaluate: {"x": X[None]},
    KNEES.draw: {"x": X},
    KNEES.with_size: {"size": 1.0},
    KNEES.weights: {"objective": "all", "given": None},
    KNEES.to_free_unit: {"x": X},
    KNEES.from_free_unit: {"u": np.full(6, 0.5)},
    KNEES.at_bounds: {"x": X, "tolerance": 1e-3},
    Input: {"name": "a", "nominal": 1.0, "tolerance_percent": None, "half_range": None}
    | {"lower": 0.0, "upper": 2.0, "unit": "", "shown_unit": None, "shown_scale": 1.0},
    Output: {"name": "a", "unit": "", "axis": None, "axis_name": "", "axis_unit": ""}
    | {"scale": None},
    Model: {"run": len, "inputs": [Input("a", lower=0, upper=1)], "outputs": [Output("b")]}
    | {"gradient": None, "draw": None, "name": "m", "threads": None},
    SearchSettings: {o.name: o.default for o in options_of(SearchSettings)},
    fit_surrogate: {"model": KNEES, "n_samples": 30, "seed": 0, "callback": None},
    worst_case: {"model": KNEES, "settings": SMALL, "callback": None},
    compare_methods: {"model": None, "settings": None, "callback": None},
    monte_carlo: {"model": KNEES, "settings": SamplingSettings(n_samples=10)}
    | {"marks": None, "callback": None},
    influence: {"model": KNEES, "settings": InfluenceSettings(n_base=2, intervals=False)}
    | {"callback": None},
    landscape: {"model": KNEES, "names": ("acl_stiffness", "pcl_stiffness"), "x": None}
    | {"surrogate": None, "n_points": 2, "callback": None},
    kneecore.load: {"path": "nothing"},
    SearchResult.from_json: {"text": "{}"},
    SearchResult.load: {"path": "nothing"},
    check_physical: {"values": X, "argument": "x"},
    widened: {"x": X, "width": 32},
    count: {"value": 1},
    sampling_options.check_seed: {"seed": 1},
    sampling.n_drawn: {"n_samples": 1, "sampling": "sobol"},
}
OF_A_FILE = (read_knee, parse_knee, ParameterSpace.from_file, kneecore.load)
OF_A_FILE += (SearchResult.from_json, SearchResult.load)
OUR_OWN = {"argument", "width"}  # given by our own code, never by a user


def check(function, given_):
    """Call a function: whatever it refuses, it refuses in one line that names what is wrong."""
    for count in ("n_samples", "n_points"):  # a budget is the caller's to choose
        if type(given_.get(count)) is int:
            given_[count] = min(given_[count], 40)
    if callable(given_.get("callback")):
        return  # it is called, and may do what it wants
    try:
        function(**given_)
    except KneecoreError as error:
        message = str(error)
    else:
        return
    assert "\n" not in message
    assert len(message) < 400
    # What is wrong within a file, and what only two bounds together exceed, has other names.
    of_a_file = function in OF_A_FILE
    assert "`" in message or "the bounds" in message or "all bounds" in message or of_a_file


@pytest.mark.parametrize("function", CALLABLES, ids=lambda f: f.__qualname__)
def test_every_odd_value_of_every_argument(function):
    for name in sorted(set(CALLABLES[function]) - OUR_OWN):
        for value in NUMBERS + ODD:
            check(function, CALLABLES[function] | {name: value})


@pytest.mark.parametrize("function", CALLABLES, ids=lambda f: f.__qualname__)
@settings(max_examples=50, deadline=None)
@given(st.data())
def test_anything_gets_an_answer_or_one_line_that_names_the_argument(function, data):
    given_ = dict(CALLABLES[function])
    names = sorted(set(given_) - OUR_OWN)
    for name in data.draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True)):
        given_[name] = data.draw(ANYTHING, label=name)
    check(function, given_)


ARRAYS = {
    "texts": np.full(28, "1"),
    "booleans": np.ones(28, dtype=bool),
    "a list of booleans": [True] * 28,
    "complex numbers": np.ones(28, complex),
    "huge whole numbers": [10**400] * 28,
    "dates": np.array(["2020-01-01"] * 28, dtype="datetime64[D]"),
    "rows of two lengths": [[1.0], [1.0, 2.0]],
    "nothing of the kind": Sly(),
}


@pytest.mark.parametrize("kind", ARRAYS)
def test_arrays_of_other_things_are_refused(kind):
    for function in (simulate, SPACE.to_unit, SPACE.from_unit, flexion_gradient, trajectory):
        with pytest.raises(ParameterError, match="is not an array of numbers"):
            function(ARRAYS[kind])


def test_a_number_is_no_name_of_a_file(tmp_path):
    """Opening True would read from stdout, and close it."""
    path = tmp_path / "knee.toml"
    path.write_bytes(asset_path("baseline.toml").read_bytes())
    descriptor = os.open(path, os.O_RDONLY)
    try:
        for number in (descriptor, True, 1.0, b"knee.toml", None):
            with pytest.raises(
                ParameterError, match=r"`path` is .*; the name of a file is allowed"
            ):
                read_knee(number)
        os.fstat(descriptor)
    finally:
        os.close(descriptor)


def str_or_type(value):
    return "a huge number" if type(value) is int else repr(value)


@pytest.mark.parametrize("bound", sorted(BOUNDS))
@pytest.mark.parametrize(
    "value", [1e308, 10**400, 10**5000, -1e308, "1", True, None], ids=str_or_type
)
def test_a_bound_that_is_none(bound, value):
    with pytest.raises(ParameterError) as caught:
        ParameterSpace(**{bound: value})
    assert bound in str(caught.value) or "the bounds are too wide" in str(caught.value)


@pytest.mark.parametrize("name", ALL_NAMES)
def test_a_value_beyond_any_knee_is_refused_and_one_at_the_limit_is_not(name):
    if name == "poissons_ratio":
        return  # it has limits of its own
    index = ALL_NAMES.index(name)
    x = np.append(X, np.zeros(4))
    x[index] = LARGEST[index]
    check_physical(x)
    x[index] *= 1.0001
    with pytest.raises(ParameterError, match=rf"`{name}` is .* at most .* is allowed"):
        check_physical(x)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"mm"', '"m"', "`acl_femur_x` is -14000 mm; a size of at most 500 mm"),
        ('"deg"', '"rad"', "`plateau_slope` is 515.662 deg; a size of at most 90 deg"),
        ("value = 35.0", "value = 35e6", r"`acl_stiffness` is 3.5e\+07 N/mm\^2; a size of at most"),
        ("value = 24.0", "value = 24e6", r"`youngs_modulus` is 2.4e\+07 MPa; a size of at most"),
        ("value = 32.1", "value = 0.0321", "`condyle_radius` is 0.0321 mm; a size of at least"),
        ('"MPa"', '"Pa"', "`youngs_modulus` is 2.4e-05 MPa; a size of at least 0.001 MPa"),
    ],
)
def test_a_knee_in_the_wrong_unit_is_refused(old, new, said):
    text = asset_path("baseline.toml").read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(FileFormatError, match=said) as caught:
        parse_knee(text.replace(old, new))
    assert "which unit?" in str(caught.value)


def test_ten_times_the_bounds_are_no_absurd_knees():
    ten = ParameterSpace(
        geometry_bound_mm=10.0,
        slope_bound_deg=10.0,
        half_ranges={name: 0.9 * x for name, x in zip(NAMES[22:27], X[22:27], strict=True)},
        rest_length_bound_mm=10.0,
    )
    corners = np.random.default_rng(0).integers(0, 2, (1000, 32)).astype(float)
    check_physical(ten.from_unit(corners))
    # Twice the size of the largest values keeps the limits generous.
    assert (2.0 * np.maximum(np.abs(ten.lower), np.abs(ten.upper))[:22] <= LARGEST[:22]).all()


def test_texts_that_no_file_could_hold_are_refused():
    for name in ("title", "note"):
        for text in (5, "\ud800", "x" * (LONGEST_TEXT + 1), b"x"):
            with pytest.raises(ParameterError, match=f"`{name}` "):
                ParameterSpace(**{name: text})
            with pytest.raises(ParameterError, match=f"`{name}` "):
                dump_knee(baseline=X, half_ranges=KNEE.half_ranges, **{name: text})
    with pytest.raises(ParameterError, match=r"`sources\[0\]` is 5; text is allowed"):
        ParameterSpace(sources=(5,))


@settings(max_examples=50, deadline=None)
@given(st.text(st.characters(codec="utf-8"), max_size=LONGEST_TEXT))
def test_every_text_that_is_allowed_comes_back(text):
    knee = parse_knee(dump_knee(baseline=X, half_ranges=KNEE.half_ranges, note=text, title="a"))
    assert (knee.note or "") == text.strip()


def test_the_longest_texts_come_back():
    worst = "\x01" * LONGEST_TEXT  # six characters in the file each
    text = dump_knee(baseline=X, half_ranges=KNEE.half_ranges, note=worst, title=worst)
    assert parse_knee(text).note == worst


def test_what_is_shown_is_one_short_line():
    assert arguments.shown(10**5000) == "a value of type int"
    assert arguments.shown(Sly()) == "a value of type Sly"
    assert "\n" not in arguments.shown(np.zeros((50, 50)))
    assert len(arguments.shown("x" * 10**6)) < 100
    assert "(1,000,002 characters)" in arguments.shown("x" * 10**6)
    assert arguments.shown("short") == "'short'"
