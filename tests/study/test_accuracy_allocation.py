"""Which measurement must be how good: closed forms, and what the exact search says of the knee."""

import json

import numpy as np
import pytest
from commands import called
from scipy.optimize import minimize
from study_models import LEVERS, Filter, Levers

import kneecore
from kneecore import (
    AccuracyAllocationSettings,
    Cancelled,
    FileFormatError,
    Input,
    Knee,
    Model,
    NeededAccuracySettings,
    Output,
    ParameterError,
    ParameterSpace,
)
from kneecore.cli.sweep import main
from kneecore.files.digest import with_digest
from kneecore.numerics.sampling import uniform
from kneecore.study.arguments import Steps
from kneecore.study.best_search import best_pair, one_column
from kneecore.study.cheapest import cheapest_linear

REST = Knee(solver="equilibrium")
SLOPES = np.array([24.0, 10.0, 4.0, 0.01])  # of Levers, by measurement, over its stated bounds
NOMINAL = float(LEVERS @ [10.0, -3.0, 50.0, 0.0, 1.0])


def allocated(model=REST, callback=None, **settings):
    return kneecore.accuracy_allocation(
        model, AccuracyAllocationSettings(**settings), callback=callback
    )


def narrowed(found, factors):
    """Return the model with other tolerances of its measurements."""
    model = found.model
    share = dict(zip(found.names, factors, strict=True))
    return model.with_widths([share[model.measurements[name]] for name in model.names])


def largest(model, seed):
    """Return the largest watched output by an exact search."""
    found = best_pair(
        model, one_column(model, model.watched), seed=seed, steps=Steps(None, "test", 1)
    )
    return float(found.y[1, model.watched])


@pytest.fixture(scope="module")
def knees():
    return allocated()


class TestClosedForm:
    @pytest.mark.parametrize("costs", [{}, {"ends": 5.0, "slope": 0.3}])
    def test_a_linear_model_gets_tolerances_as_the_root_of_cost_by_slope(self, costs):
        found = allocated(Levers(), within=NOMINAL + 12.0, costs=costs)
        weights = np.array([costs.get(name, 1.0) for name in found.names])
        # The offset hardly matters and stays as stated; the others share the rest of the 12.
        t = np.sqrt(weights / SLOPES)[:3]
        t *= (12.0 - SLOPES[3]) / (SLOPES[:3] @ t)
        assert t.max() < 1.0
        np.testing.assert_allclose(found.factors, [*t, 1.0], rtol=1e-2)
        np.testing.assert_allclose(found.gains, SLOPES * found.factors, rtol=1e-9)
        assert found.as_stated.tolist() == [False, False, False, True]
        assert found.cost == pytest.approx((weights / [*t, 1.0]).sum(), rel=1e-3)
        assert found.names == ("ends", "force", "slope", "offset")
        assert found.units == ("mm", "%", "deg", "deg")
        assert found.stated.tolist() == [2.0, 10.0, 4.0, 1.0]

    def test_with_caps_nothing_is_cheaper(self):
        rng = np.random.default_rng(5)
        for _ in range(20):
            costs, slopes = rng.uniform(0.1, 5.0, (2, 6))
            limit = slopes.sum() * rng.uniform(0.05, 0.95)
            t = cheapest_linear(costs, slopes, limit)
            assert slopes @ t == pytest.approx(limit)
            assert t.max() <= 1.0
            best = minimize(
                lambda t, c=costs: (c / t).sum(),
                np.full(6, limit / slopes.sum()),
                bounds=6 * [(1e-6, 1.0)],
                constraints={"type": "ineq", "fun": lambda t, s=slopes, m=limit: m - s @ t},
                method="SLSQP",
            )
            assert (costs / t).sum() <= best.fun * (1.0 + 1e-4)  # it passes the limit by little

    def test_what_has_no_effect_stays_as_stated(self):
        assert cheapest_linear(np.ones(3), np.array([2.0, 0.0, 2.0]), 1.0).tolist() == [
            0.25,
            1.0,
            0.25,
        ]


class TestKnees:
    def test_one_tolerance_for_all_is_the_needed_accuracy(self, knees):
        need = kneecore.needed_accuracy(REST)
        assert abs(knees.equal.size - need.size) <= need.settings.tolerance
        assert knees.equal.size == pytest.approx(0.273, abs=5e-3)
        share = dict(zip(knees.names, knees.equal_factors, strict=True))
        assert share["acl_femur"] == pytest.approx(knees.equal.size)
        assert share["plateau_slope"] == pytest.approx(knees.equal.size)
        assert share["youngs_modulus"] == pytest.approx(1.0)  # the material stays as stated

    def test_no_other_search_and_no_sample_passes_the_limit(self, knees):
        within = narrowed(knees, knees.factors)
        assert max(largest(within, seed) for seed in (11, 12)) <= 5.0
        assert knees.largest_value == pytest.approx(5.0, abs=2e-3)
        angles = within.evaluate(within.from_free_unit(uniform(2000, within.n_free, 8)))
        assert angles[:, within.watched].max() <= 5.0
        assert knees.sampled_value <= knees.largest_value
        assert (knees.n_sampled, knees.n_sampled_failed) == (2000, 0)

    def test_each_tolerance_10_percent_wider_alone_passes_it_or_is_as_stated(self, knees):
        open_ones = ~knees.as_stated
        assert 5 < open_ones.sum() < len(knees.names)
        assert (knees.enlarged[open_ones] > 5.0).all()
        assert np.isnan(knees.enlarged[~open_ones]).all()
        k = int(np.argmin(knees.factors))
        wider = knees.factors.copy()
        wider[k] *= 1.1
        assert largest(narrowed(knees, wider), 3) == pytest.approx(knees.enlarged[k], abs=1e-4)

    def test_costs_less_than_one_tolerance_for_all_and_than_its_neighbours(self, knees):
        assert knees.cost < 0.8 * knees.equal_cost
        slopes, open_ones = knees.gains / knees.factors, ~knees.as_stated
        # Where nothing can be gained, one multiplier belongs to all: c / t^2 = l s.
        multiplier = 1.0 / (knees.factors**2 * slopes)[open_ones]
        np.testing.assert_allclose(multiplier, multiplier.mean(), rtol=0.05)
        held = slopes[knees.as_stated]
        assert (multiplier.mean() * held < 1.05).all()

    def test_what_costs_more_may_be_less_good(self, knees):
        dear = allocated(costs={"acl_femur": 9.0})
        k = dear.names.index("acl_femur")
        others = np.delete(dear.factors / knees.factors, k)
        assert dear.factors[k] > 1.5 * knees.factors[k]
        assert others.max() <= 1.01

    def test_the_two_coordinates_of_a_point_are_one_measurement(self, knees):
        inputs = dict(zip(knees.names, knees.inputs, strict=True))
        assert len(inputs) == 18
        assert inputs["acl_femur"] == ("acl_femur_x", "acl_femur_y")
        assert inputs["condyle_centre"] == ("condyle_x", "condyle_y")
        assert inputs["plateau_point"] == ("plateau_x", "plateau_y")
        assert inputs["acl_stiffness"] == ("acl_stiffness",)
        told = zip(knees.stated, knees.units, strict=True)
        stated = dict(zip(knees.names, told, strict=True))
        assert stated["condyle_radius"] == (1.0, "mm")
        assert stated["plateau_slope"] == (1.0, "deg")
        assert stated["poissons_ratio"] == (10.0, "%")

    def test_uncertain_rest_lengths_are_measurements_too(self):
        space = ParameterSpace(geometry_bound_mm=0.2, rest_length_bound_mm=1.0)
        found = allocated(Knee(space, solver="equilibrium"), tolerance=0.1)
        assert len(found.names) == 22
        k = found.names.index("acl_rest_length_change")
        assert (found.stated[k], found.units[k]) == (1.0, "mm")
        assert found.factors[k] < 1.0

    def test_knees_in_motion(self):
        space = ParameterSpace(geometry_bound_mm=0.4, case="geometry")
        found = allocated(Knee(space), tolerance=0.2)
        assert 4.99 < found.largest_value <= 5.0
        assert (found.enlarged[~found.as_stated] > 5.0).all()

    def test_one_and_two_threads_give_the_same(self, knees):
        one = allocated(Knee(solver="equilibrium", threads=1))
        assert one.factors.tobytes() == knees.factors.tobytes()


class TestEdges:
    def test_when_all_may_be_as_stated(self):
        found = allocated(Levers(), within=NOMINAL + 50.0)
        assert found.as_stated.all()
        assert found.equal.reaches_largest
        assert "even if no measurement is better than stated" in found.summary()
        assert found.cost == found.equal_cost == 4.0

    def test_when_the_bracket_of_one_tolerance_begins_at_0(self):
        found = allocated(Levers(), within=NOMINAL + 1.0, tolerance=0.5)
        assert (found.equal.size, found.equal_factors) == (0.0, None)
        t = np.sqrt(1.0 / SLOPES)
        np.testing.assert_allclose(
            found.factors[:3], (t * 0.99 / (SLOPES[:3] @ t[:3]))[:3], rtol=0.01
        )
        assert "one tolerance" not in found.summary()
        assert type(found).from_json(found.to_json()).to_json() == found.to_json()

    def test_when_nothing_is_enough(self):
        found = allocated(Levers(), within=NOMINAL - 1.0)
        assert (found.factors, found.gains, found.enlarged, found.cost) == (None,) * 4
        assert found.largest_value == found.nominal_value == pytest.approx(NOMINAL)
        assert found.summary().startswith("Not sum is at most")
        assert type(found).from_json(found.to_json()).to_json() == found.to_json()
        assert found.figures()
        assert " - " in str(found)

    def test_when_the_material_alone_is_too_uncertain_for_one_tolerance(self):
        space = ParameterSpace(material_bound_percent=40.0)
        found = allocated(Knee(space, solver="equilibrium"), within=-3.4, tolerance=0.1)
        assert found.equal.size is None
        assert found.equal_cost is None
        assert found.largest_value == pytest.approx(-3.4, abs=1e-3)
        assert "one tolerance for all" not in found.summary()
        assert type(found).from_json(found.to_json()).to_json() == found.to_json()

    def test_without_gradients_a_repaired_surrogate_is_searched(self):
        model = Model(
            lambda x: [4.0 * x[0] + x[1] + 0.5 * x[0] * x[1]],
            [Input("one", lower=-1.0, upper=1.0), Input("two", lower=-1.0, upper=1.0)],
            [Output("y")],
        )
        found = allocated(model, within=2.0, tolerance=0.1)
        assert not found.in_model
        assert found.largest_value <= 2.0
        t = found.factors
        assert 4.0 * t[0] + t[1] + 0.5 * t[0] * t[1] == pytest.approx(2.0, abs=1e-3)
        # The best of all on the limit, by looking at many.
        one = np.linspace(0.1, 0.5, 4001)
        two = (2.0 - 4.0 * one) / (1.0 + 0.5 * one)
        fits = (two > 0.0) & (two <= 1.0)
        best = (1.0 / one + 1.0 / np.where(fits, two, 1e-9))[fits].min()
        assert found.cost == pytest.approx(best, rel=1e-3)
        assert found.names == ("one", "two")  # each input by itself

    def test_inputs_without_a_common_measure_are_told_in_shares(self):
        class Mixed(Levers):
            @property
            def measurements(self):
                return super().measurements | {"d": "ends"}

        found = allocated(Mixed(), within=NOMINAL + 12.0)
        assert (found.units[0], found.stated[0]) == ("% of its bounds", 100.0)

    def test_a_models_file_tells_what_is_measured_together(self, tmp_path):
        path = tmp_path / "model.toml"
        path.write_text(
            """
            name = "sum"
            inputs = [
                { name = "a", lower = -1.0, upper = 1.0, measurement = "both" },
                { name = "b", lower = -1.0, upper = 1.0, measurement = "both" },
                { name = "c", lower = -1.0, upper = 1.0 },
            ]
            outputs = [{ name = "y" }]
            function = { run = "numpy:sum" }
            """
        )
        assert Model.from_file(path).measurements == {"a": "both", "b": "both", "c": "c"}

    def test_its_results_tell_what_is_measured_together(self):
        told = {"a": "both", "b": "both", "c": None}
        inputs = [Input(n, lower=-1.0, upper=1.0, measurement=m) for n, m in told.items()]
        slopes = {"gradient": lambda x: np.ones((len(x), 1, 3))}
        model = Model(np.sum, inputs, [Output("y")], **slopes)
        found = allocated(model, within=1.5)
        again, document = (f(found.to_json()) for f in (type(found).from_json, json.loads))
        assert again.model.measurements == {"a": "both", "b": "both", "c": "c"}
        assert again.names == found.names == ("both", "c")
        document["measurements"][0]["name"] = "each"
        with pytest.raises(FileFormatError, match="`measurements` must be both, c"):
            type(found).from_json(json.dumps(with_digest(document)))

    def test_an_interior_maximum_needs_no_accuracy(self):
        model = Model(
            lambda x: np.stack([x[:, 0] - x[:, 1] ** 2], axis=1),
            [Input("up", lower=-1.0, upper=1.0), Input("bent", lower=-1.0, upper=1.0)],
            [Output("y")],
            batched=True,
            gradient=lambda x: np.stack([np.ones(len(x)), -2.0 * x[:, 1]], axis=1)[:, None],
        )
        found = allocated(model, within=0.25)
        np.testing.assert_allclose(found.factors, [0.25, 1.0], rtol=1e-3)

    def test_cancelled(self):
        seen = []

        def stop(report):
            seen.append((report.stage, report.done, report.total))
            return report.stage == "enlarging each tolerance" and report.done == 1

        with pytest.raises(Cancelled):
            allocated(Levers(), stop, within=NOMINAL + 12.0)
        assert {stage for stage, _, _ in seen} == {
            "bracketing the bound",
            "allocating",
            "enlarging each tolerance",
        }
        assert all(done <= total for _, done, total in seen)

    @pytest.mark.parametrize(
        ("call", "said"),
        [
            (lambda: allocated(costs={"acl": 2.0}), "`costs` names 'acl'; acl_femur, "),
            (lambda: allocated(costs={"acl_femur": 0.0}), "`costs['acl_femur']` is 0; a number"),
            (lambda: allocated(costs=3), "`costs` is 3; a mapping"),
            (lambda: allocated(Filter()), "`within` is None"),
            (lambda: allocated(tolerance=-1.0), "`tolerance` is -1"),
            (lambda: allocated(seed=-1), "`seed` is -1"),
            (lambda: allocated(Knee(ParameterSpace(case="material"))), "`case` is 'material'"),
            (
                lambda: Input("a", half_range=1.0, nominal=0.0, measurement=" "),
                "`measurement of a`",
            ),
            (lambda: REST.with_widths(np.ones(3)), "`factors` has shape (3,); (28,) finite"),
            (lambda: REST.with_widths(-np.ones(28)), "`factors` has shape (28,)"),
            (lambda: Levers().with_widths(np.zeros(5)), "all bounds have zero width"),
        ],
    )
    def test_refused_in_a_sentence(self, call, said):
        with pytest.raises(ParameterError) as refused:
            call()
        assert said in str(refused.value)
        assert "\n" not in str(refused.value)


class TestWidths:
    @pytest.mark.parametrize("model", [Levers(), REST, Knee()], ids=["levers", "rest", "motion"])
    def test_each_input_has_its_own(self, model):
        factors = np.linspace(0.1, 1.0, len(model.names))
        other = model.with_widths(factors)
        middle = 0.5 * (model.lower + model.upper)
        if isinstance(model, Knee):
            middle = model.space.centre
        for one, two in ((model.lower, other.lower), (model.upper, other.upper)):
            share = (two - middle) / (one - middle)
            clipped = np.array([name == "poissons_ratio" for name in model.names])
            np.testing.assert_allclose(share[~clipped], factors[~clipped], rtol=1e-9)
        assert other.identity != model.identity
        if model.proxy is not None:
            np.testing.assert_array_equal(other.proxy.lower, other.lower)

    def test_around_another_knee(self):
        centre = ParameterSpace().baseline.copy()
        centre[0] += 1e-3
        knee = Knee(ParameterSpace(centre=centre), solver="equilibrium")
        other = knee.with_widths(np.full(28, 0.5))
        np.testing.assert_allclose(0.5 * (other.lower + other.upper)[:22], centre[:22])
        np.testing.assert_array_equal(other.space.baseline, knee.space.baseline)


class TestFiles:
    @pytest.mark.parametrize(
        ("change", "said"),
        [
            (lambda row: row.update(stated=2 * row["stated"]), "`measurements.stated` is 2.0"),
            (lambda row: row.update(name="acl"), "`measurements` must be acl_femur"),
            (lambda row: row.update(inputs=["acl_femur_x"]), "`measurements.inputs` contradicts"),
            (lambda row: row.update(cost=3.0), "`measurements.cost` is 3.0; 1.0 follows"),
            (lambda row: row.update(enlarged_deg=None), "`enlarged` contradicts"),
            (lambda row: row.update(cheapest_share=0.0), "a number above 0 is needed"),
        ],
    )
    def test_what_contradicts_the_rest_is_refused(self, knees, change, said):
        document = knees.to_dict()
        row = document["measurements"][0]
        change(row)
        for name in ("equal", "cheapest"):
            row[name] = row["stated"] * row[f"{name}_share"]
        with pytest.raises(FileFormatError) as refused:
            type(knees).from_json(json.dumps(document))
        assert said in str(refused.value)


class TestCommand:
    def test_prints_and_writes(self, capsys, tmp_path):
        arguments = ["accuracy", "--solver", "equilibrium", "--costs", "acl_femur", "4"]
        arguments += ["--tolerance-mm", "0.1", "--out", str(tmp_path / "a"), "--quiet"]
        code, out, _ = called(capsys, main, *arguments)
        assert code == 0
        assert "with a tolerance for each measurement" in out
        names = sorted(p.name for p in (tmp_path / "a").iterdir())
        figure = "figure_accuracy_allocation"
        assert names == ["accuracy_allocation.json", f"{figure}.png", f"{figure}.svg"]
        found = kneecore.load(tmp_path / "a")
        document = json.loads((tmp_path / "a" / "accuracy_allocation.json").read_text())
        assert with_digest(found.to_dict()) == document
        assert str(found) == out.rstrip("\n")
        assert found.settings.costs == {"acl_femur": 4.0}
        assert document["measurements"][0]["cost"] == 4.0
        code, _, err = called(capsys, main, *arguments)
        assert code == 2
        assert "--force" in err

    def test_a_wrong_name_gets_one_line(self, capsys):
        code, out, err = called(capsys, main, "accuracy", "--costs", "acl", "2", "--quiet")
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "`--costs` names 'acl'" in err


def test_needed_accuracy_settings_are_those_of_the_equal_answer(knees):
    assert knees.equal.settings == NeededAccuracySettings(within=5.0, largest=1.0)
