"""The parameter table and the space that the uncertainty spans."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive import BASELINE
from naive import NAMES as NAIVE_NAMES

from kneecore import NAMES, ParameterError, ParameterSpace, parameter_table
from kneecore.knee.likely import POISSON_LIMIT


def test_the_table_agrees_with_the_naive_model():
    assert tuple(NAIVE_NAMES) == NAMES
    np.testing.assert_allclose([p.baseline for p in parameter_table()], BASELINE, rtol=1e-14)


def test_the_table_has_22_geometric_and_6_material_parameters():
    kinds = [p.kind for p in parameter_table()]
    assert kinds == ["geometry"] * 22 + ["material"] * 6
    assert all(p.meaning and p.source and p.half_range > 0 for p in parameter_table())


def test_default_half_ranges():
    space = ParameterSpace()
    half = (space.upper - space.lower) / 2
    names = dict(zip(NAMES, half, strict=True))
    assert names["acl_femur_x"] == pytest.approx(1e-3)
    assert names["plateau_slope"] == pytest.approx(np.radians(1.0))
    assert names["acl_stiffness"] == pytest.approx(3.5e6)
    nu = NAMES.index("poissons_ratio")
    assert space.lower[nu] == pytest.approx(0.414)
    assert space.upper[nu] == POISSON_LIMIT


@pytest.mark.parametrize(("case", "free"), [("both", 28), ("geometry", 22), ("material", 6)])
def test_cases_hold_the_rest_at_the_baseline(case, free):
    space = ParameterSpace(case=case)
    assert space.n_free == free
    held = ~space.free
    np.testing.assert_array_equal(space.lower[held], space.baseline[held])
    np.testing.assert_array_equal(space.upper[held], space.baseline[held])
    assert space.from_free_unit(np.zeros(free)).shape == (28,)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=28, max_size=28),
    st.sampled_from(["both", "geometry", "material"]),
    st.floats(0.01, 3.0),
)
def test_unit_cube_and_back(u, case, bound):
    space = ParameterSpace(case=case, geometry_bound_mm=bound)
    x = space.from_unit(u)
    assert (x >= space.lower).all()
    assert (x <= space.upper).all()
    expected = np.where(space.free, u, 0.5)
    np.testing.assert_allclose(space.to_unit(x), expected, atol=1e-9)


def test_corners_are_met_exactly():
    space = ParameterSpace()
    np.testing.assert_array_equal(space.from_unit(np.ones(28)), space.upper)
    np.testing.assert_array_equal(space.from_unit(np.zeros(28)), space.lower)
    assert (space.at_bounds(space.upper) == 1).all()
    assert (space.at_bounds(space.lower) == -1).all()
    assert (space.at_bounds(space.baseline) == 0).all()


def test_half_ranges_by_parameter_take_the_bounds_place():
    space = ParameterSpace(half_ranges={"condyle_radius": 2e-3, "acl_stiffness": 0.0})
    k, s = NAMES.index("condyle_radius"), NAMES.index("acl_stiffness")
    assert space.upper[k] - space.lower[k] == pytest.approx(4e-3)
    assert not space.free[s]
    assert space.n_free == 27


@pytest.mark.parametrize("case", ["both", "geometry", "material"])
def test_a_box_around_another_knee(case):
    centre = ParameterSpace().from_unit(np.linspace(0.1, 0.9, 28))
    space = ParameterSpace(case=case, geometry_bound_mm=0.5, centre=centre)
    own = ParameterSpace(case=case, geometry_bound_mm=0.5, baseline=centre)
    np.testing.assert_array_equal(space.lower, own.lower)
    np.testing.assert_array_equal(space.upper, own.upper)
    np.testing.assert_array_equal(space.baseline, ParameterSpace().baseline)
    np.testing.assert_array_equal(space.centre, centre)
    assert not space.is_around_baseline
    assert ParameterSpace(case=case).is_around_baseline


def test_a_box_around_another_knee_goes_through_its_file(tmp_path):
    centre = ParameterSpace().from_unit(np.linspace(0.1, 0.9, 28))
    space = ParameterSpace(centre=centre, material_bound_percent=7.0)
    path = tmp_path / "knee.toml"
    path.write_text(space.to_toml())
    again = ParameterSpace.from_file(path, around="current")
    np.testing.assert_array_equal(again.centre, space.centre)
    np.testing.assert_array_equal(again.baseline, space.baseline)
    np.testing.assert_allclose(again.lower, space.lower, rtol=1e-15)
    np.testing.assert_allclose(again.upper, space.upper, rtol=1e-15)
    assert ParameterSpace.from_file(path).is_around_baseline
    path.write_text(ParameterSpace().to_toml())
    with pytest.raises(ParameterError, match=r"has no \[current\] knee"):
        ParameterSpace.from_file(path, around="current")
    with pytest.raises(ParameterError, match="`around` is 'mine'"):
        ParameterSpace.from_file(path, around="mine")


def test_rest_lengths_around_another_knee():
    centre = ParameterSpace().from_unit(np.linspace(0.1, 0.9, 28))
    space = ParameterSpace(centre=centre, rest_length_bound_mm=0.5)
    assert len(space.centre) == len(space.baseline) == len(space.lower) == 32
    np.testing.assert_allclose((space.upper - space.lower)[28:], 1e-3)


def test_arrays_cannot_be_changed_by_accident():
    space = ParameterSpace()
    with pytest.raises(ValueError, match="read-only"):
        space.lower[0] = 0.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"case": "bones"}, "`case` is 'bones'; both, geometry, material are allowed"),
        ({"geometry_bound_mm": -1.0}, "`geometry_bound_mm` is -1 mm"),
        ({"geometry_bound_mm": float("nan")}, "`geometry_bound_mm` is nan mm"),
        ({"slope_bound_deg": float("inf")}, "`slope_bound_deg` is inf deg"),
        ({"material_bound_percent": "ten"}, "`material_bound_percent` is 'ten'"),
        ({"material_bound_percent": 100.0}, "`youngs_modulus` is 0 MPa; a value above 0"),
        ({"geometry_bound_mm": 40.0}, "`condyle_radius` is -7.9 mm; a value above 0"),
        ({"half_ranges": {"meniscus": 1.0}}, "`half_ranges` names 'meniscus'"),
        (
            {"geometry_bound_mm": 0.0, "slope_bound_deg": 0.0, "material_bound_percent": 0.0},
            "zero width",
        ),
        ({"baseline": [1.0, 2.0]}, r"`baseline` has shape \(2,\)"),
        ({"baseline": "knee"}, "`baseline` is not an array of numbers"),
    ],
)
def test_what_is_not_allowed_is_named(arguments, said):
    with pytest.raises(ParameterError, match=said) as caught:
        ParameterSpace(**arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("poissons_ratio", 0.5, "`poissons_ratio` is 0.5; a value above -1 and below 0.5"),
        ("acl_stiffness", -1.0, "a stiffness of at least 0"),
        ("condyle_radius", 0.0, "`condyle_radius` is 0 mm; a value above 0"),
        ("youngs_modulus", -2.4e7, "`youngs_modulus` is -24 MPa; a value above 0"),
        ("plateau_x", np.nan, "`plateau_x` is nan mm; a finite number"),
        ("plateau_slope", np.inf, "a finite number"),
    ],
)
def test_a_baseline_that_no_knee_can_have(name, value, said):
    baseline = np.array(BASELINE)
    baseline[NAMES.index(name)] = value
    with pytest.raises(ParameterError, match=said):
        ParameterSpace(baseline=baseline)
