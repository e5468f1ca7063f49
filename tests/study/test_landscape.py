"""The slice of the parameter space under two parameters."""

from dataclasses import replace

import numpy as np
import pytest

import kneecore
from kneecore import (
    MOMENT,
    NAMES,
    Knee,
    ParameterError,
    ParameterSpace,
    fit_surrogate,
    landscape,
    simulate,
)
from kneecore.knee.readings import DEFICIT, READINGS, reading

FIRST, SECOND = "condyle_x", "acl_stiffness"
AT_FIRST, AT_SECOND = NAMES.index(FIRST), NAMES.index(SECOND)


@pytest.fixture(scope="module")
def space():
    return ParameterSpace(geometry_bound_mm=0.7)


@pytest.fixture(scope="module")
def surrogate(space):
    return fit_surrogate(Knee(space), seed=3)


@pytest.fixture(scope="module")
def x(space):
    return space.from_unit(np.random.default_rng(5).random(len(NAMES)))


@pytest.fixture(scope="module")
def found(space, surrogate, x):
    return landscape(Knee(space), (FIRST, SECOND), x=x, surrogate=surrogate, n_points=4)


def test_every_grid_point_is_the_model_and_the_surrogate_there(found, space, surrogate, x):
    for a in range(4):
        for b in range(4):
            knee = x.copy()
            knee[AT_FIRST] = np.linspace(space.lower[AT_FIRST], space.upper[AT_FIRST], 4)[a]
            knee[AT_SECOND] = np.linspace(space.lower[AT_SECOND], space.upper[AT_SECOND], 4)[b]
            np.testing.assert_allclose(found.y[a, b], np.degrees(simulate(knee).flexion), atol=1e-9)
            np.testing.assert_allclose(found.y_surrogate[a, b], surrogate.predict(knee), atol=1e-9)
    assert (found.n_models, found.n_failed) == (16, 0)


def test_through_the_knees_own_values_runs_the_knees_own_angle(space, surrogate):
    """The baseline lies in the middle of an odd grid."""
    middle = landscape(Knee(space), (SECOND, FIRST), surrogate=surrogate, n_points=3)
    own = np.degrees(simulate(space.baseline).flexion)
    np.testing.assert_allclose(middle.y[1, 1], own, atol=1e-9)
    assert np.ptp(middle.y[:, 1, 5]) < np.ptp(middle.y[1, :, 5])


def test_a_training_knee_lies_on_the_slice_through_itself(space, surrogate):
    """There the surrogate is exact, so both sheets meet: the reason why they do not elsewhere."""
    trained = surrogate.training_x[0]
    around = landscape(Knee(space), (FIRST, SECOND), x=trained, surrogate=surrogate, n_points=2)
    np.testing.assert_allclose(surrogate.predict(trained), surrogate.training_y[0], atol=1e-6)
    assert np.abs(around.error[..., 5]).max() > 1e-3


@pytest.mark.parametrize("load", range(12))
def test_readings_are_the_angles_at_the_loads(found, load):
    name = f"{MOMENT[load]:+g} N m"
    np.testing.assert_array_equal(reading(found.y, name), found.y[..., load])
    np.testing.assert_array_equal(
        found.error[..., load], found.y_surrogate[..., load] - found.y[..., load]
    )
    assert name in READINGS


def test_the_extension_deficit_is_what_is_missing_to_straight(found):
    at_most = found.y[..., int(np.argmax(MOMENT))]
    shown = reading(found.y, DEFICIT)
    np.testing.assert_array_equal(shown[at_most > 0], at_most[at_most > 0])
    assert (shown[at_most <= 0] == 0.0).all()
    angles = np.zeros((3, 12))
    angles[:, 5] = (-4.0, 7.0, np.nan)
    np.testing.assert_array_equal(reading(angles, DEFICIT), [0.0, 7.0, np.nan])


def test_failed_models_are_counted_and_leave_holes():
    wide = ParameterSpace(geometry_bound_mm=1.0, material_bound_percent=10.0)
    found = landscape(Knee(wide, threads=1), ("acl_femur_x", "condyle_radius"), n_points=3)
    broken = found.y.copy()
    broken[0, 2] = np.nan
    holed = replace(found, y=broken)
    assert (found.n_failed, holed.n_failed) == (0, 1)
    assert np.isnan(reading(holed.y, DEFICIT)).sum() == 1
    assert found.y_surrogate is None
    assert found.error is None


@pytest.mark.parametrize(
    ("names", "case"),
    [
        (("condyle_x", "condyle_x"), "both"),
        (("condyle_x",), "both"),
        (("condyle_x", "knee_cap"), "both"),
        (("condyle_x", "acl_stiffness"), "geometry"),
    ],
)
def test_two_different_free_parameters_are_needed(names, case):
    with pytest.raises(ParameterError, match="`names`"):
        landscape(Knee(ParameterSpace(case=case)), names)


def test_rest_lengths_can_be_its_parameters():
    space = ParameterSpace(rest_length_bound_mm=1.0)
    name = "acl_rest_length_change"
    found = landscape(Knee(space), (name, "condyle_x"), x=ParameterSpace().baseline, n_points=3)
    knee = np.array(space.baseline)
    knee[space.names.index(name)] = 1e-3
    np.testing.assert_allclose(found.y[2, 1], np.degrees(simulate(knee).flexion), atol=1e-9)


def test_other_bad_arguments(space):
    with pytest.raises(ParameterError, match="`n_points`"):
        landscape(Knee(space), (FIRST, SECOND), n_points=1)
    with pytest.raises(ParameterError, match="`x`"):
        landscape(Knee(space), (FIRST, SECOND), x=np.tile(space.baseline, (2, 1)))
    with pytest.raises(ParameterError, match="`name`"):
        reading(np.zeros(12), "+7 N m")


def test_a_knee_whose_rest_lengths_are_changed_but_held(space):
    knee = np.append(space.baseline, [1e-3, 0.0, 0.0, 0.0])
    found = landscape(Knee(space), (FIRST, SECOND), x=knee, n_points=3)
    np.testing.assert_allclose(found.y[1, 1], np.degrees(simulate(knee).flexion), atol=1e-9)
    assert kneecore.Landscape.from_json(found.to_json()).to_json() == found.to_json()


def test_comes_back_from_its_folder(found, tmp_path):
    names = [p.name for p in found.save(tmp_path / "slice")]
    assert names[-1] == "landscape.json"
    assert {"landscape.csv", "figure_landscape.png", "figure_landscape.svg"} < set(names)
    again = kneecore.load(tmp_path / "slice")
    assert again.to_json() == found.to_json()
    assert str(again) == str(found)
    lines = (tmp_path / "slice" / "landscape.csv").read_text().splitlines()
    assert len(lines) == 1 + 16
    assert len(lines[0].split(",")) - lines[0].count(", deg") == 2 + 24
