"""How a model's inputs, outputs and picture become sliders, curves and lines: no server."""

import models
import numpy as np
import pytest

import kneecore
from kneecore import Input, Model, Output, Shape
from kneeviz.anymodel import curves, frame
from kneeviz.anymodel.dials import dial, dials, folders
from kneeviz.anymodel.slices import picture_of
from kneeviz.anymodel.state import ModelState
from kneeviz.anymodel.views import words
from kneeviz.anymodel.views.inputs import hint
from kneeviz.geometry import surfaces
from kneeviz.views import theme


def inputs(n):
    return [Input(f"k_{i}", nominal=100.0, tolerance_percent=5) for i in range(n)]


def model_of(*outputs, n_inputs=1):
    m = sum(o.n_columns for o in outputs)
    return Model(lambda x: np.zeros(m), inputs(n_inputs), outputs)


class TestDials:
    def test_bounds_and_home_are_exact_though_few_digits_are_shown(self):
        one = dial(0, Input("x", lower=-np.pi, nominal=1.0 / 3.0, upper=np.pi))
        assert (one.low, one.home, one.high) == (-3.14, 0.33, 3.14)
        assert one.value(one.low) == -np.pi
        assert one.value(one.high) == np.pi
        assert one.value(one.home) == 1.0 / 3.0
        assert one.value(0.5) == 0.5
        assert one.shown(4.0) == 3.14

    @pytest.mark.parametrize(
        ("value", "label"),
        [(4.7e-9, "C (10⁻⁹ F)"), (0.2, "C (F)"), (0.002, "C (10⁻³ F)"), (2.1e11, "C (10⁹ F)")],
    )
    def test_tiny_and_huge_values_have_a_power_of_ten(self, value, label):
        one = dial(0, Input("C", nominal=value, tolerance_percent=10, unit="F"))
        assert one.label == label
        assert one.value(one.shown(1.05 * value)) == pytest.approx(1.05 * value, rel=1e-3)

    def test_the_unit_for_tables_is_the_sliders(self):
        given = Input("a", nominal=0.02, half_range=0.001, unit="m", shown_unit="mm",
                      shown_scale=1e-3)  # fmt: skip
        one = dial(0, given)
        assert (one.label, one.low, one.high) == ("a (mm)", 19.0, 21.0)

    def test_what_is_held_has_no_slider(self):
        held = Input("T", lower=20.0, upper=20.0, unit="<K>")
        model = Model(lambda x: 0.0, [held, *inputs(1)], [Output("y")])
        assert [one.index for one in dials(model)] == [1]
        assert "T = 20 &lt;K&gt;" in words.held([held])

    def test_only_allowed_values_are_taken(self):
        teeth = dial(0, Input("teeth", lower=17, upper=21, integer=True))
        assert (teeth.step, teeth.value(18.4), teeth.even) == (1.0, 18.0, True)
        gauge = dial(0, Input("gauge", choices=(0.5, 0.8, 2.0), unit="mm"))
        assert [gauge.value(v) for v in (0.5, 0.6, 0.7, 1.9)] == [0.5, 0.5, 0.8, 2.0]
        assert not gauge.even

    def test_many_stand_in_folders(self):
        few, many = (dials(model_of(Output("y"), n_inputs=n)) for n in (10, 17))
        assert [title for title, _ in folders(few)] == [""]
        assert [title for title, _ in folders(many)] == ["k_0 to k_7", "k_8 to k_15", "k_16"]
        assert [one for _, group in folders(many) for one in group] == list(many)


class TestCurves:
    def test_outputs_over_an_axis_are_curves_and_others_numbers(self):
        model = model_of(
            Output("a", axis=(3, 1, 2)),
            Output("b"),
            Output("c", axis=(7,)),
            Output("d", axis=(1, 2)),
        )
        shown, single = curves.places(model)
        assert [place.output.name for place in shown] == ["a", "d"]
        assert shown[0].columns.tolist() == [1, 2, 0]
        assert shown[0].axis.tolist() == [1.0, 2.0, 3.0]
        assert single == [3, 4]

    def test_a_long_curve_is_thinned_to_its_ends(self):
        [place], _ = curves.places(model_of(Output("a", axis=np.arange(5000.0))))
        assert len(place.axis) == curves.MOST_POINTS
        assert (place.axis[0], place.axis[-1]) == (0.0, 4999.0)

    @pytest.mark.parametrize(
        ("axis", "expected"), [((1, 10, 100), True), ((1, 50), False), ((0, 100), False)]
    )
    def test_decades_are_drawn_as_such(self, axis, expected):
        [place], _ = curves.places(model_of(Output("a", axis=axis)))
        assert place.logarithmic is expected

    def test_the_range_is_kept_until_it_does_not_serve(self):
        old = curves.span([np.array([0.0, np.nan, 10.0])])
        assert old[0] < 0.0 < 10.0 < old[1]
        assert curves.kept_span(old, (1.0, 9.0)) == old
        assert curves.kept_span(old, (1.0, 12.0))[1] > 12.0
        assert curves.kept_span(old, (1.0, 1.1))[1] < 2.0
        assert curves.kept_span(old, None) == old
        assert curves.span([np.full(3, np.nan)]) is None
        assert curves.span([np.full(3, 2.0)]) == (pytest.approx(1.94), pytest.approx(2.06))


class TestFrame:
    def test_shapes_fill_the_frame_and_widen_it_when_they_leave(self):
        square = Shape(name="s", points=100.0 * models.SQUARE, kind="closed")
        first = frame.frame_around([[square]])
        lines = frame.segments(square, first)
        assert lines.shape == (4, 2, 2)
        np.testing.assert_array_equal(lines[-1, 1], lines[0, 0])
        size = np.ptp(lines.reshape(-1, 2), axis=0)
        assert (size > 0.8 * frame.WIDTH).all()
        assert (size <= frame.WIDTH).all()
        assert frame.widened(first, [[square]]) is first
        far = Shape(name="f", points=[[500.0, 0.0]])
        wider = frame.widened(first, [[square], [far]])
        assert wider.holds(np.array([[500.0, 0.0], [-100.0, -100.0]]))

    def test_a_link_is_dashed_with_its_ends_shown_and_a_point_is_a_ring(self):
        link = Shape(name="l", points=[[0.0, 0.0], [10.0, 0.0]], kind="link")
        lines = frame.segments(link, frame.frame_around([[link]]))
        dashes = lines[lines[:, 0, 1] == lines[:, 1, 1]]
        assert len(dashes) > 10
        ring = frame.segments(Shape(name="p", points=[[1.0, 2.0]]), frame.frame_around([[link]]))
        assert len(ring) == 12

    def test_places_that_are_not_known_are_left_out(self):
        shape = Shape(name="s", points=[[0.0, 0.0], [1.0, 0.0], [np.nan, 1.0], [1.0, 1.0]])
        assert frame.segments(shape, frame.frame_around([[shape]])).shape == (1, 2, 2)
        assert frame.frame_around([[Shape(name="s", points=[[np.nan, 0.0]])]]) is None

    def test_the_scale_is_round_and_stands_in_the_lower_margin(self):
        square = Shape(name="s", points=100.0 * models.SQUARE, kind="closed")
        one = frame.frame_around([[square]])
        length, lines = frame.scale_bar(one)
        assert length == 50.0  # of 224, with margins
        bar = lines[0]
        assert np.ptp(bar[:, 0]) == pytest.approx(length * one.scale)
        lowest = frame.segments(square, one)[..., 1].min()
        assert -0.5 * one.size[1] < bar[0, 1] < lowest


def test_how_inputs_are_drawn_is_told_where_it_is_not_uniformly():
    normal = Input("x", lower=0.0, upper=1.0, distribution="normal", deviations=2)
    model = Model(lambda x: x.sum(), [normal, *inputs(1)], [Output("y")])
    assert "1 normal with bounds at 2 sd, 1 uniform" in words.drawn(model)
    assert "Samples are normal with bounds at 2 sd." in hint(dials(model)[0])
    assert "Samples" not in hint(dials(model)[1])
    assert words.drawn(model_of(Output("y"))) == ""


def test_time_left_is_told_where_it_is_worth_it():
    assert words.time_left(None) == words.time_left(1.0) == ""
    assert "At most 3 min left." in words.time_left(180.0)


def test_names_of_the_users_are_no_markup():
    model = Model(lambda x: x[0], inputs(1), [Output("<y>", unit="<m>")], name="<model>")
    state, colours = ModelState.of(model), theme.palette(False)
    state.nominal = np.array([1.0])
    told = words.numbers(state, [0], curves.curves_of(state), colours)
    assert "&lt;y&gt;" in told
    assert "<y>" not in told + words.comparison(state, colours)


def test_a_landscape_over_few_values_is_a_sheet_too():
    teeth = Input("teeth", lower=17, upper=19, integer=True)
    model = Model(lambda x: x.sum(), [*inputs(1), teeth], [Output("y")])
    state = ModelState.of(model)
    state.landscape = kneecore.landscape(model, ("k_0", "teeth"), n_points=5)
    shown = picture_of(state, state.landscape)
    vertices, faces = surfaces.sheet(surfaces.box_around(shown, zoom=False), shown.model)
    assert (len(vertices), len(faces)) == (5 * 3, 2 * 4 * 2)
    assert shown.own.place == (0.5, 0.5)


def test_a_landscape_of_the_surrogate_alone_is_drawn_as_the_surrogate():
    state = ModelState.of(models.ishigami())
    state.landscape = kneecore.landscape(state.model, ("x_1", "x_3"), n_points=5)
    both = picture_of(state, state.landscape)
    state.in_surrogate = True
    alone = picture_of(state, state.landscape)
    np.testing.assert_array_equal(alone.surrogate, both.model)
    assert np.isnan(alone.model).all()
    assert both.own.place == (0.5, 0.5)
    assert both.ends[1] == (-np.pi, np.pi)
