import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kneecore
from kneecore import MOMENT, NAMES
from kneeviz.geometry import mechanism
from kneeviz.geometry.mechanism import Pose
from kneeviz.views import theme
from kneeviz.views.scene import body
from kneeviz.views.scene.labels import spread_labels

X = kneecore.packaged_knee().baseline


@pytest.fixture(scope="module")
def response():
    return kneecore.simulate(X)


def pose_at(response, k):
    return Pose(
        flexion=float(response.flexion[k]),
        moment=float(MOMENT[k]),
        tibia_position=response.tibia_position[k],
        tension=response.tension[k],
        contact_force=float(response.contact_force[k]),
    )


def test_flexion_turns_the_shin_backwards():
    below = np.array([[0.0, -1.0]])
    placed = mechanism.to_femur(below, np.deg2rad(90.0), np.zeros(2))
    np.testing.assert_allclose(placed, [[-1.0, 0.0]], atol=1e-12)


def test_quaternion_and_matrix_agree():
    w, _, _, z = mechanism.quaternion(0.7)
    turn = np.array([[1 - 2 * z * z, -2 * w * z], [2 * w * z, 1 - 2 * z * z]])
    np.testing.assert_allclose(turn, mechanism.rotation(0.7), atol=1e-12)


@pytest.mark.parametrize("k", range(12))
def test_drawn_ligaments_have_the_computed_tension(response, k):
    """The geometry drawn is the geometry computed: k e^2 of the drawn length is the tension."""
    segments = mechanism.ligament_segments(X, pose_at(response, k))
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    stretch = np.maximum(length - response.rest_length, 0.0)
    np.testing.assert_allclose(X[22:26] * stretch**2, response.tension[k], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("k", range(12))
def test_drawn_contact_is_the_computed_contact(response, k):
    along, depth = mechanism.contact_coordinates(
        X, float(response.flexion[k]), response.tibia_position[k]
    )
    assert along == pytest.approx(response.ap_position[k], abs=1e-12)
    assert depth == pytest.approx(response.indentation[k], abs=1e-12)


def test_contact_point_lies_on_the_line_below_the_centre(response):
    pose = pose_at(response, 3)
    point = mechanism.contact_point(X, pose)
    centre, radius = mechanism.condyle(X)
    assert np.linalg.norm(point - centre) == pytest.approx(radius - response.indentation[3])


def test_arrow_grows_with_the_force_and_ends_at_the_contact(response):
    weak, strong = (mechanism.contact_arrow(X, pose_at(response, k)) for k in (0, 5))
    for arrow, k in ((weak, 0), (strong, 5)):
        length = np.linalg.norm(arrow[1] - arrow[0])
        assert length == pytest.approx(mechanism.ARROW_PER_NEWTON * response.contact_force[k])
        np.testing.assert_allclose(arrow[1], mechanism.contact_point(X, pose_at(response, k)))
    assert strong[0][1] > strong[1][1]  # the femur presses downwards


@given(
    flexion=st.floats(-0.5, 2.4),
    along=st.floats(-0.03, 0.03),
    depth=st.floats(-0.002, 0.004),
    seed=st.integers(0, 99),
)
def test_tibia_at_contact_turns_contact_coordinates_round(flexion, along, depth, seed):
    x = kneecore.ParameterSpace().from_unit(np.random.default_rng(seed).random(28))
    origin = mechanism.tibia_at_contact(x, flexion, along, depth)
    assert mechanism.contact_coordinates(x, flexion, origin) == pytest.approx((along, depth))


@pytest.mark.parametrize("name", [n for n in NAMES if n.endswith(("_x", "_y", "radius", "slope"))])
def test_every_geometric_slider_moves_what_is_drawn(name):
    """Under a fixed pose, each geometric parameter moves an end, the circle or the line."""
    pose = Pose(
        flexion=0.4, moment=1.0, tibia_position=np.array([-0.007, -0.03]),
        tension=np.zeros(4), contact_force=0.0,
    )  # fmt: skip
    moved = np.array(X)
    moved[NAMES.index(name)] += 1e-3

    def drawn(x):
        return np.concatenate(
            [
                mechanism.ligament_segments(x, pose).ravel(),
                mechanism.circle(x).ravel(),
                mechanism.plateau_line(x).ravel(),
            ]
        )

    assert np.abs(drawn(moved) - drawn(X)).max() > 2e-5


class TestLigamentLook:
    def test_slack_is_thin_and_grey(self):
        assert body.ligament_width(0.0) < body.ligament_width(2.0)
        assert body.ligament_colour(0, 0.0, theme.LIGHT.slack) == theme.LIGHT.slack

    def test_width_grows_with_tension(self):
        widths = [body.ligament_width(t) for t in (1.0, 10.0, 100.0, 300.0, 400.0)]
        assert (np.diff(widths) > 0).all()
        assert body.ligament_width(1e6) < 12.0

    def test_a_loaded_ligament_has_its_own_hue(self):
        colours = {body.ligament_colour(i, 100.0, theme.LIGHT.slack) for i in range(4)}
        assert colours == {theme.rgb(c) for c in theme.LIGAMENT_COLOURS}

    def test_no_ligament_has_a_models_colour(self):
        own = set(theme.LIGAMENT_COLOURS)
        assert not own & {theme.MODEL_1, theme.MODEL_2, theme.SURROGATE}


class TestLabels:
    @given(st.integers(0, 10_000))
    def test_spread_labels_do_not_overlap(self, seed):
        anchors = np.random.default_rng(seed).uniform(-0.03, 0.03, (4, 2))
        size = (0.034, 0.0125)
        placed = spread_labels(anchors, size)
        for i in range(4):
            for j in range(i):
                gap = np.abs(placed[i] - placed[j])
                assert (gap >= np.array(size) - 1e-6).any()

    def test_labels_with_room_stay(self):
        anchors = np.array([[0.0, 0.0], [1.0, 0.0]])
        np.testing.assert_array_equal(spread_labels(anchors, (0.1, 0.1)), anchors)
